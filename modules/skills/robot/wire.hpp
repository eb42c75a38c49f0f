#pragma once
// The endpoints of a RosRobot while they are open. Internal to ros_robot.cpp and wire.cpp.
//
// Threads: the loop's.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/skills/robot/battery_presence.hpp"
#include "musher/modules/skills/robot/camera_feeds.hpp"
#include "musher/modules/skills/robot/detector_feeds.hpp"
#include "musher/modules/skills/robot/flight_hold.hpp"
#include "musher/modules/skills/robot/look_feeds.hpp"
#include "musher/modules/skills/robot/map_feed.hpp"
#include "musher/modules/skills/robot/navigator.hpp"
#include "musher/modules/skills/robot/photo_folder.hpp"
#include "musher/modules/skills/robot/recent_value.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/modules/skills/robot/saved_flight.hpp"
#include "musher/modules/skills/robot/traffic.hpp"
#include "musher/modules/skills/robot/velocity_output.hpp"
#include "musher/navigation/frames/frame_tree.hpp"
#include "musher/navigation/stamp_order.hpp"
#include "musher/navigation/travelled_path.hpp"

namespace musher::skills {

struct RosRobot::Wire {
  // Opens what the config names.
  Wire(const SkillsConfig& config, transport::Endpoints& endpoints, std::string name_space,
       RosRobot::WriteLine log, std::string flight_file);
  ~Wire() {
    holds_.reset();
    StandStill();
  }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  void StandStill() {
    active_at.reset();  // nor does a person move it from now on
    navigator->CancelAll();
    StopMotion();
    cameras->Update();
  }
  void SetVelocity(const navigation::Velocity& command) {
    holding_ = false;
    velocity->Set(command);
  }
  // A drive takes the base: no skill, no hold and no person sends any more.
  void FreeBase() {
    if (velocity->sending()) StopMotion();
  }
  void StopMotion() {
    holding_ = false;
    velocity->Stop();
  }
  // In the map.
  void ExpectGround(double height_m);
  MissingInterfaces Look() const;
  // Whether the controller drives, for a skill or for another client.
  bool Drives() const;
  // Of planner and controller; succeeds once all that are configured have answered.
  skill::Future<bool> ClearMemory();
  // Subscribes at the first call.
  const navigation::Pose* PoseOf(const std::string& topic);
  // What the scanners have seen, in the map.
  std::vector<navigation::Point> Seen() const;
  // Of each scanner; false without one.
  bool HasScan() const;
  // Whether a recent scan covers the way to a place, in the frame of the odometry.
  bool SeesTowards(const navigation::Point& place) const;
  Time Now() const { return clock.Now(); }
  // Where a frame of a message is in the map, as /tf says; an empty one counts as the map's. Fails
  // with the reason where that is not known.
  Result<navigation::Pose> InMap(const std::string& frame) const;
  // The same on the body; an empty one counts as the body's.
  Result<navigation::Pose> OnBody(const std::string& frame) const;
  // Also along the odometry, which places the body in its frame.
  bool HasTransform(const std::string& parent, const std::string& child) const;
  // The lowest level. Nullopt: none counts.
  std::optional<BatteryLevel> Battery() const;
  // "the battery of r is at 9 %, …"; empty: it is not low, or none reports.
  const std::string& LowBattery() const { return low_battery_; }
  // Nullopt: no recent odometry.
  std::optional<navigation::Pose> PoseNow() const;
  // "cf2x_0 is not held at its place any more: ..."; empty: it is held, or has landed.
  std::string WhyNotHeld() const;

  struct Motion {
    navigation::Pose pose;
    navigation::Velocity velocity;  // in the frame of the pose
  };
  struct Tracked {
    RecentValue<navigation::Pose> pose;
    RecentValue<std::string> refused;  // why a pose has no place in the map
    std::uint64_t count = 0;           // of poses that have come
    Duration stamp{};                  // of the last one
    Time asked{};                      // when a skill has last asked for it
    std::unique_ptr<transport::Subscription> subscription;
  };

  const SkillsConfig& config;
  transport::Node& node;
  transport::Clock& clock;
  const std::string name_space;
  RecentValue<Motion> odometry;         // in its own frame
  RecentValue<Motion> motion;           // the same in the map
  navigation::TravelledPath travelled;  // in the frame of the odometry
  RecentValue<std::string> refused;     // why odometry has no place in the map
  std::vector<RecentValue<std::vector<navigation::Point>>> obstacles;  // of each scanner
  RecentValue<std::vector<SeenObject>> objects;
  RecentValue<std::string> refused_objects;  // why they have no place in the map
  RecentValue<Line> line;
  std::map<std::string, Tracked> tracked;
  std::map<std::string, const transport::Subscription*> optional;  // by topic
  transport::Client<msg::ManipulationControl>* hand = nullptr;     // null: there is none
  std::vector<transport::Client<msg::Trigger>*> memories;          // of planner and controller
  std::unique_ptr<VelocityOutput> velocity;
  FlightHold hold;
  // Of the last step of the skills; nullopt: none since StandStill(), so the robot is not in
  // Active.
  std::optional<Time> active_at;
  std::unique_ptr<Navigator> navigator;
  std::unique_ptr<Traffic> traffic;
  std::unique_ptr<CameraFeeds> cameras;
  std::unique_ptr<PhotoFolder> photos;
  std::unique_ptr<DetectorFeeds> detectors;  // null: the config names none
  std::unique_ptr<LookFeeds> looks;
  std::unique_ptr<MapFeed> maps;

 private:
  void Subscribe(transport::Endpoints& endpoints);
  void SubscribeFrames(transport::Endpoints& endpoints);
  void SubscribeScans(transport::Endpoints& endpoints);
  void SubscribeRanges(transport::Endpoints& endpoints);
  void SubscribeDrives(transport::Endpoints& endpoints);
  void SubscribeCommandsOfOthers(transport::Endpoints& endpoints);
  void OnOdometry(const msg::Odometry& message);
  void OnTeleop(const msg::Twist& twist);
  void OnBattery(const msg::BatteryState& battery, transport::EndpointId publisher);
  void RefuseBattery(const msg::BatteryState& battery);
  void HoldPlace();
  // Of a flyer in the air, for the process after this one.
  void SavePlace();
  // Once for each reason, until a skill or a drive moves it.
  void LogEndOfHold();
  void LogHeldDescent();
  void Log(LogLevel level, const std::string& line) const {
    if (log_) log_(level, line);
  }

  const RosRobot::WriteLine log_;
  SavedFlight saved_flight_;
  bool looked_for_flight_ = false;  // of the process before
  navigation::FrameTree frames_;
  std::string body_frame_;   // of the twist of the odometry
  std::string odom_frame_;   // of its pose; empty: the map's
  bool holding_ = false;     // the last command is that of `hold`
  bool stood_high_ = false;  // with a low battery; logged once
  bool held_high_ = false;   // the same, by what is below it
  std::string end_logged_;   // of the hold
  Time driven_until_{};      // by the controller, as far as it is known
  std::string low_battery_;
  struct BatteryReport {
    double percent = 0;
    bool charges = false;  // or is full
    bool is_full = false;
    double voltage_v = 0;  // may be not a number
  };
  const BatteryReport* LowestBattery() const;  // null: none
  // The last one of each publisher that is connected. One is expected; of several the lowest
  // counts.
  std::map<transport::EndpointId, BatteryReport> batteries_;
  std::optional<Time> battery_differs_since_;  // from low_battery_, in all samples
  bool batteries_logged_ = false;              // that there are several; until one is left
  bool battery_refused_ = false;               // logged once
  bool battery_doubted_ = false;               // that it is not present; logged once
  BatteryPresence presence_;
  navigation::StampOrder odometry_order_;
  Duration line_stamp_{};           // of the last picture
  transport::LoopHandlePtr holds_;  // last: it uses the rest
};

}  // namespace musher::skills
