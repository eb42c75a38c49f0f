#pragma once
// A world on the network: steps at the pace of its scene, publishes and subscribes.
//
//   clock                  every step, in any namespace
//   world/body_state       every step          world/body_command    commands of the body, unless
//                                              they come on LCM (world_board.hpp)
//   world/battery          once a second       world/set_battery     in %
//   world/touch            when it happens     world/press           a finger on the robot
//   world/charge           cable in, or out    world/place           puts the body there
//   world/draw, pause      services            world/fault, speed, led, motor_power
//   world/referee, referee_json, the same      world/show, hide: a ball by its name
//   world/scan, ultrasonic, tof/..., gps: see world_sensors.hpp; of humanoids: world_show.hpp
//   <robot>/odom, cmd_vel, scan and so on: see world_robots.hpp
//   robot_description, joint_states, /tf, /tf_static: see world_frames.hpp
//   of a competition field: see world_field.hpp
//   musher/machine_status  of the controller, for the picture
//
// Invalid input is refused with a line in the log, and nothing moves.
//
// Threads: created, used and destroyed on the loop. Drawing takes long and runs in the background.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/modules/world/process/followers.hpp"
#include "musher/modules/world/process/pacer.hpp"
#include "musher/modules/world/process/world_board.hpp"
#include "musher/modules/world/process/world_cameras.hpp"
#include "musher/modules/world/process/world_field.hpp"
#include "musher/modules/world/process/world_frames.hpp"
#include "musher/modules/world/process/world_robots.hpp"
#include "musher/modules/world/process/world_sensors.hpp"
#include "musher/modules/world/process/world_show.hpp"
#include "musher/modules/world/simulation/world.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::world {

struct HostOptions {
  std::string name_space;
  std::string picture_path;  // of world/draw
  std::function<void(const std::string&)> log;
  // Runs work beside the loop, from any thread; posts its end to the loop by itself.
  std::function<void(std::function<void()>)> in_background;
  Worker* shooter = nullptr;  // draws the cameras' pictures; outlives the host
};

class WorldHost {
 public:
  // Fails when an endpoint cannot be made.
  static Result<std::unique_ptr<WorldHost>> Start(transport::Node& node, Scene scene,
                                                  HostOptions options);
  ~WorldHost();
  WorldHost(const WorldHost&) = delete;
  WorldHost& operator=(const WorldHost&) = delete;

  // Of the loop.
  const World& world() const { return world_; }
  const Pacer& pacer() const { return pacer_; }

 private:
  WorldHost(transport::Node& node, Scene scene, HostOptions options);
  Result<> Connect();
  void Publish();
  Result<> MakeCameras();
  void Listen();
  void Serve();

  void Arm(Time when);
  void OnStep();
  void PublishBody();
  // Whether a step has to wait, for a picture or a process.
  bool Waits() const;
  void Continue();
  void ListenToFollowers();
  void Remind(int reminders);
  void Touch(int state);
  void SetSpeed(double factor);
  void SetFault(const std::string& text);
  void DrawPicture(std::function<void(bool, const std::string&)> reply);
  // Logs the line, if there is one.
  void Log(const std::optional<std::string>& line) const;

  transport::Node& node_;
  const HostOptions options_;
  World world_;
  Pacer pacer_;
  bool drawing_ = false;
  bool late_ = false;  // a step was due while time waited
  Followers followers_;
  transport::LoopHandlePtr reminder_;
  transport::LoopHandlePtr next_step_;
  transport::Publisher<msg::Clock>* clock_ = nullptr;
  transport::Publisher<msg::BodyState>* body_state_ = nullptr;
  transport::Publisher<msg::BatteryState>* battery_ = nullptr;
  transport::Publisher<msg::Int32>* touch_ = nullptr;
  std::unique_ptr<WorldBoard> board_;  // null: world/body_command is it
  std::unique_ptr<WorldSensors> sensors_;
  std::unique_ptr<WorldCameras> cameras_;
  std::unique_ptr<WorldShow> show_;
  std::unique_ptr<WorldRobots> robots_;
  std::unique_ptr<WorldField> field_;
  std::unique_ptr<WorldFrames> frames_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for callbacks from other threads
  transport::Endpoints endpoints_;                              // last: its callbacks use the rest
};

}  // namespace musher::world
