#pragma once
// The robot among others: what it says of itself on the topic of all robots, what they say, and
// where it can give way to them.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/robot_path.hpp"
#include "musher/modules/skills/config/skills_config.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/navigation/traffic/known_robots.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::skills {

class Traffic {
 public:
  static constexpr Duration kPeriod = Milliseconds(500);
  // Between two drives of one travel a path is planned: the robot still wants to go on.
  static constexpr Duration kPathStays = std::chrono::seconds(2);

  // What it asks of its robot.
  struct Body {
    std::function<std::optional<navigation::Pose>()> pose;
    std::function<bool()> drives;
    PlaceOfFrame in_map;
  };

  // `name`: of the robot among all. The endpoints must outlive it.
  Traffic(const SkillsConfig& config, const std::string& name, Body body,
          transport::Endpoints& endpoints);

  // A drive begins.
  void Begin(const navigation::Path& path);
  void NoteCornered(Duration time);

  navigation::RobotIntent Intent();
  std::vector<navigation::RobotIntent> Others() const { return known_.At(clock_.Now()); }
  skill::Future<navigation::Path> ComputeRefuge();

 private:
  void Publish();

  const Body body_;
  transport::Clock& clock_;
  navigation::RobotIntent own_;  // what of it does not change
  navigation::KnownRobots known_;
  navigation::PathLeft path_;
  std::optional<Time> drove_at_;
  std::optional<Time> cornered_until_;
  transport::Publisher<msg::RobotPath>* publisher_ = nullptr;  // null: it does not take part
  transport::Client<msg::ComputeRefuge>* refuge_ = nullptr;
  transport::LoopHandlePtr ticks_;  // last: it uses the rest
};

}  // namespace musher::skills
