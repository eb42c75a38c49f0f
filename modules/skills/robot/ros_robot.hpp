#pragma once
// A robot behind ROS 2 topics, actions and services, as skills use it (robot.hpp).
//
//   no topics ── Open() ──→ open ── its endpoints are dropped ──→ no topics
//
// Without topics it has no pose and nothing to see, requests fail, and commands go nowhere: skills
// may be declared and be tested under injected faults. When the endpoints are dropped, and by
// StandStill(), the robot stands: 0 is published and drives are cancelled.
//
// Units and frames: those of robot.hpp. Threads: the loop's; a thread of its own writes photos.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/log.hpp"
#include "musher/modules/skills/config/skills_config.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::skills {

class RosRobot final : public Robot {
 public:
  explicit RosRobot(SkillsConfig config) : config_(std::move(config)) {}

  const SkillsConfig& config() const { return config_; }

  using WriteLine = std::function<void(LogLevel level, const std::string& line)>;

  // Opens its topics, for as long as these endpoints exist. `name_space`: theirs. `flight_file`: of
  // a flyer, for saved_flight.hpp; empty: none.
  void Open(transport::Endpoints& endpoints, const std::string& name_space, WriteLine log = {},
            std::string flight_file = "");
  // Before the skills make a step at this time.
  void BeginStep(Time now);
  // The robot stands, its drives are cancelled.
  void StandStill();

  // What of its environment cannot be reached.
  struct MissingInterfaces {
    std::string odometry;             // empty: it comes
    std::vector<std::string> others;  // "no server of jetbot_0/compute_path_to_pose", ...
  };
  MissingInterfaces Look() const;

  // Why it may not move with its battery: "the battery of r is at 9 %, its limit is 10 %"; empty:
  // it may.
  std::string LowBattery() const;

  const std::string& name() const override { return config_.robot; }
  const std::string& kind() const override { return config_.kind; }
  bool flies() const override { return config_.flies; }
  double radius_m() const override { return config_.radius_m; }
  std::optional<double> ceiling_m() const override { return config_.ceiling_m; }

  Time Now() const override { return now_; }
  std::optional<navigation::Pose> pose() const override;
  std::string WhyNoPose() const override;
  navigation::Velocity velocity() const override;
  std::optional<navigation::Pose> odometry() const override;
  navigation::Path travelled() const override;
  void SetVelocity(const navigation::Velocity& command) override;
  void StopMotion() override;
  std::string HeldBy() const override;
  std::string WhyNotDescending() const override;
  void ExpectGround(double height_m) override;
  void NoteLanding() override;
  std::string WhyNotHeld() const override;
  bool HasTeleop() const override { return !config_.names.teleop.empty(); }
  std::optional<BatteryLevel> battery() const override;
  bool HasTransform(const std::string& parent, const std::string& child) const override;
  bool HasPlanner() const override;
  bool HasController() const override;
  bool Drives() const override;
  void CancelEarlierDrives() override;
  skill::Future<navigation::Path> ComputePath(
      const navigation::Pose& goal, const std::optional<navigation::Pose>& start) override;
  std::unique_ptr<Drive> FollowPath(const navigation::Path& path) override;
  skill::Future<bool> ClearMemory() override;
  navigation::RobotIntent intent() override;
  std::vector<navigation::RobotIntent> others() const override;
  void NoteCornered(Duration time) override;
  skill::Future<navigation::Path> ComputeRefuge() override;
  GroundMap map() override;
  std::vector<navigation::Point> obstacles() const override;
  bool HasScan() const override;
  bool ScanCovers(const navigation::Point& place) const override;
  std::vector<SeenObject> objects() const override;
  bool HasObjects() const override;
  std::optional<std::vector<SeenObject>> Detect() override;
  std::string WhyNothingSeen() const override;
  std::optional<skills::Look> LookFor(const std::string& target) override;
  std::string WhyNoLook() const override;
  std::optional<navigation::Pose> PoseOf(const std::string& topic) override;
  std::string WhyNoPoseOf(const std::string& topic) const override;
  std::uint64_t PosesOf(const std::string& topic) const override;
  bool HasCamera(const std::string& camera) const override;
  std::vector<std::string> cameras() const override;
  skill::Future<Picture> TakePicture(const std::string& camera) override;
  skill::Future<std::string> SavePng(const Picture& picture, const std::string& path) override;
  std::optional<Line> line() const override;
  bool HasHand() const override { return config_.hand; }
  skill::Future<HandReply> UseHand(const HandRequest& request) override;

 private:
  struct Wire;

  const SkillsConfig config_;
  Time now_;
  std::weak_ptr<Wire> wire_;
  bool cancels_earlier_ = false;  // drives, once its topics are open
};

}  // namespace musher::skills
