#pragma once
// The motion board of the simulated body on LCM, as that of a CyberDog 2 ([motion_board] kind =
// "lcm" in a scene): takes robot_control_cmd, and sends robot_control_response and global_to_robot
// with each step of the world, and motor_temperature once a second.
//
// A frame of mode -1 is a heartbeat and no command. After 500 ms without a frame the body lies
// down, once a jump has ended: 500 ms of world time, and of real time, in which a motion manager on
// LCM sends its frames. So it lies down neither because world time is fast, nor because this
// process was suspended.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "musher/modules/world/simulation/world.hpp"
#include "musher/transport/lcm_socket.hpp"

namespace musher::world {

class WorldBoard {
 public:
  using Log = std::function<void(const std::string&)>;

  // Fails where no route leads to the groups of the scene. The world and the loop outlive it.
  static Result<std::unique_ptr<WorldBoard>> Open(transport::EventLoop& loop, World& world,
                                                  Log log);

  // After each step of the world.
  void OnStep();

 private:
  struct FrameTime {
    Time real;
    Duration world;
  };

  WorldBoard(transport::EventLoop& loop, World& world, Log log)
      : loop_(loop), world_(world), log_(std::move(log)) {}

  void OnSample(const transport::LcmSample& sample);
  void OnGaitText(std::span<const std::byte> data);
  void Take(BoardCommand command);
  void LieDownWithoutFrames();

  transport::EventLoop& loop_;
  World& world_;
  const Log log_;
  std::unique_ptr<transport::LcmSocket> commands_;
  std::unique_ptr<transport::LcmSocket> responses_;
  std::unique_ptr<transport::LcmSocket> locations_;
  std::optional<std::int8_t> wire_count_;  // of the last frame
  std::int8_t count_ = 0;                  // of the body's last command
  std::optional<FrameTime> frame_at_;      // the last one; nullopt: the body lies since
  std::string refused_;                    // the last line of the log
  bool has_gait_sections_ = false;         // the feet of a user's gait; its steps may follow
};

}  // namespace musher::world
