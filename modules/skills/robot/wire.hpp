#pragma once
// The endpoints of a RosRobot while they are open. Internal to ros_robot.cpp and wire.cpp.
//
// Threads: the loop's.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/modules/skills/robot/camera_feeds.hpp"
#include "musher/modules/skills/robot/detector_feeds.hpp"
#include "musher/modules/skills/robot/navigator.hpp"
#include "musher/modules/skills/robot/photo_folder.hpp"
#include "musher/modules/skills/robot/recent_value.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/modules/skills/robot/velocity_output.hpp"

namespace musher::skills {

struct RosRobot::Wire {
  // Opens what the config names.
  Wire(const SkillsConfig& config, transport::Endpoints& endpoints, std::string name_space);
  ~Wire() { Rest(); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  void Rest() {
    navigator->CancelAll();
    velocity->Stop();
    cameras->Tend();
  }
  Missing Look() const;
  // Subscribes at the first call.
  const navigation::Pose* PoseOf(const std::string& topic);
  Time Now() const { return clock.Now(); }

  struct Motion {
    navigation::Pose pose;
    navigation::Velocity velocity;  // in the frame of the map
  };
  struct Tracked {
    RecentValue<navigation::Pose> pose;
    std::uint64_t count = 0;  // of poses that have come
    Time asked{};             // when a skill has last asked for it
    std::unique_ptr<transport::Subscription> subscription;
  };

  const SkillsConfig& config;
  transport::Node& node;
  transport::Clock& clock;
  const std::string name_space;
  RecentValue<Motion> motion;
  RecentValue<std::vector<navigation::Point>> obstacles;
  RecentValue<std::vector<SeenObject>> objects;
  RecentValue<Line> line;
  std::map<std::string, Tracked> tracked;
  std::map<std::string, const transport::Subscription*> optional;  // by topic
  transport::Client<msg::ManipulationControl>* hand = nullptr;     // null: there is none
  std::unique_ptr<VelocityOutput> velocity;
  std::unique_ptr<Navigator> navigator;
  std::unique_ptr<CameraFeeds> cameras;
  std::unique_ptr<PhotoFolder> photos;
  std::unique_ptr<DetectorFeeds> detectors;  // null: the config names none

 private:
  void Subscribe(transport::Endpoints& endpoints);
};

}  // namespace musher::skills
