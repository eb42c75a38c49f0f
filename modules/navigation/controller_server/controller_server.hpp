#pragma once
// controller_server on the network: odometry, scans and the map in; for each robot an action
// nav2_msgs/FollowPath, its trajectory, and its velocity 60 times a second while it drives. Runs on
// any transport.
//
// A newer goal aborts the present one, and the robot goes on or brakes within its limits. At each
// other end, also when it is not permitted any more, velocity 0 is sent, once, and then nothing.
//
// A goal that may have waited while this process could not run is rejected: its client may have
// gone. What drove before a break of more than a minute is aborted (transport/loop_breaks.hpp).
//
// Threads: the loop's; the distances of a new map are computed on a Background.

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/rate_limited_log.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/nav2_msgs/speed_limit.hpp"
#include "musher/modules/navigation/controller_server/path_drive.hpp"
#include "musher/modules/navigation/server/background.hpp"
#include "musher/modules/navigation/server/mask_source.hpp"
#include "musher/modules/navigation/server/server_actuator.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"

namespace musher::navigation {

class ControllerServer {
 public:
  using Config = ControllerConfig;

  // `background`: for maps; null: a ThreadBackground.
  static Result<std::unique_ptr<ControllerServer>> Make(
      const Dependencies& dependencies, const ControllerConfig& config,
      std::unique_ptr<Background> background = nullptr);
  // The robots stand.
  ~ControllerServer();

  // Whether goals are accepted. With false the robots stand at once; `why` is logged.
  void Permit(bool permitted, const std::string& why);
  // The world was restarted: the robots stand.
  void OnTimeJump(const std::string& why);
  // Whether each robot has odometry, a scan, and a subscriber of its velocity.
  SelfCheckResult Check() const;

 private:
  using Action = msg::FollowPath;
  using Goal = transport::ServerGoal<Action>;

  struct Robot {
    explicit Robot(const ControllerRobot& robot, const ControllerConfig& config)
        : config(robot), drive(robot, config) {}

    const ControllerRobot& config;
    PathDrive drive;
    std::optional<Goal> goal;
    double limit_m_s = std::numeric_limits<double>::infinity();  // by the topic
    int updates = 0;
    std::string frame;                                                   // of the body
    transport::Publisher<msg::Twist>* command = nullptr;                 // one of these two
    transport::Publisher<msg::TwistStamped>* stamped_command = nullptr;  // by the config
    transport::Publisher<msg::JointTrajectory>* trajectory = nullptr;
  };

  ControllerServer(const Dependencies& dependencies, ControllerConfig config,
                   std::unique_ptr<Background> background);
  Result<> Open();
  void OpenRobot(Robot& robot);
  void Command(Robot& robot, const msg::Twist& twist) const;
  std::string MissingOf(const Robot& robot) const;
  void SubscribeMaps();
  // `make` runs on the background; its map is that of the flyers, or of the robots on the ground.
  using MakeClearance = std::function<Result<std::shared_ptr<const Clearance>>()>;
  void OnMap(bool flies, MakeClearance make);
  void OnSpeedLimit(const msg::SpeedLimit& limit);
  void OnMask(std::uint8_t type, FilterMask mask);
  void SubscribeMasks();
  // By the topic and by the mask where it is.
  void LimitSpeed(Robot& robot);
  // By the ids of the goal. An end: there is none of that id.
  std::optional<DriveEnd> ChooseCheckers(Robot& robot, const Action::Goal& goal);
  void OnOdometry(Robot& robot, const msg::Odometry& odometry);
  // Why no goal is accepted now; empty: one is.
  std::string WhyRejected();
  void EndAfterBreak();
  void OnGoal(Robot& robot, const Goal& goal);
  void OnCancel(Robot& robot, Goal goal);
  void Tick();
  void Update(Robot& robot);
  void PublishTrajectory(Robot& robot);
  // Ends the goal of a robot as its drive has ended, and lets it stand.
  void Conclude(Robot& robot, const DriveEnd& end);
  void Stand(Robot& robot);
  void Abort(Robot& robot, std::uint16_t error_code, const std::string& why);
  void Halt(Robot& robot, const std::string& why);
  void Warn(const Robot& robot, const std::string& kind, const std::string& what);
  void Log(LogLevel level, const std::string& line) const { dependencies_.log(level, line); }
  Time Now() const { return dependencies_.clock.Now(); }

  const Dependencies dependencies_;
  const ControllerConfig config_;
  FrameTree frames_;
  std::optional<FilterMask> speed_mask_;
  bool speed_in_percent_ = false;
  RateLimitedLog warnings_;
  transport::LoopBreaks breaks_;
  bool permitted_ = false;
  std::string not_permitted_ = "it is not in Active";
  std::vector<std::unique_ptr<Robot>> robots_;
  transport::LoopHandlePtr quiet_ticks_;
  transport::LoopHandlePtr ticks_;  // while a robot drives
  std::unique_ptr<Background> background_;
  std::vector<std::unique_ptr<MaskSource>> masks_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::navigation
