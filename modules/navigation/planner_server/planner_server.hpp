#pragma once
// planner_server on the network: maps, odometry and scans in; for each robot an action
// nav2_msgs/ComputePathToPose, its last path, and a service musher_msgs/ComputeRefuge. Runs on any
// transport.
//
// A robot has one request at a time: a newer goal aborts the present one. A goal that cannot be
// planned is aborted with a code of nav2, and its reason is logged once. A map that cannot be used
// is logged and dropped; the one before stays.
//
// Planning and the conversion of maps run on a Background a robot. Threads: the loop's.

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/rate_limited_log.hpp"
#include "musher/modules/navigation/planner_server/planner_work.hpp"
#include "musher/modules/navigation/server/background.hpp"
#include "musher/modules/navigation/server/mask_source.hpp"
#include "musher/modules/navigation/server/server_actuator.hpp"
#include "musher/navigation/grid/local_grid.hpp"
#include "musher/navigation/pose_history.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::navigation {

class PlannerServer {
 public:
  using Config = PlannerConfig;
  using MakeBackground = std::function<std::unique_ptr<Background>()>;

  // `background`: by default a ThreadBackground.
  static Result<std::unique_ptr<PlannerServer>> Make(const Dependencies& dependencies,
                                                     const PlannerConfig& config,
                                                     const MakeBackground& background = {});
  // Present goals are aborted.
  ~PlannerServer();

  // Whether goals are accepted. With false the present ones are aborted; `why` is logged.
  void Permit(bool permitted, const std::string& why);
  // The world was restarted: odometry and scans of before are not used, requests are aborted.
  void OnTimeJump(const std::string& why);
  // Whether each robot has a map and odometry.
  SelfCheckResult Check() const;

 private:
  using Action = msg::ComputePathToPose;
  using Goal = transport::ServerGoal<Action>;

  using KeepOut = std::shared_ptr<const CellMap>;
  using MakeFromMap = std::function<Result<Planner>(const CellMap* keep_out)>;

  struct Request {
    Goal goal;
    Pose to{};
    std::shared_ptr<std::atomic<bool>> stop;
    Time begin;  // of the steady clock
  };
  struct Robot {
    const PlannerRobot* config = nullptr;
    std::shared_ptr<const Planner> planner;  // of the last usable map
    MakeFromMap make;                        // by the newest map
    bool converting = false;
    bool outdated = false;  // what is converted
    std::optional<Motion> motion;
    Time motion_at;
    std::string frame;  // of the body
    PoseHistory poses;
    std::vector<ScanView> scanners;
    std::optional<LocalGrid> seen;  // by them, lately
    std::optional<Request> request;
    struct LastPath {
      std::shared_ptr<const Planner> planner;
      Pose goal;
      Path path;
      Time at{};
    };
    std::optional<LastPath> last;
    transport::Publisher<msg::Path>* path = nullptr;
    std::unique_ptr<Background> background;
  };

  PlannerServer(const Dependencies& dependencies, PlannerConfig config);
  Result<> Open(const MakeBackground& background);
  void OpenRobot(Robot& robot);
  void OnMap(Robot& robot, MakeFromMap make);
  void OnKeepOut(std::uint8_t type, const FilterMask& mask);
  void Convert(Robot& robot);
  void OnConverted(Robot& robot, Result<Planner> planner);
  void OnOdometry(Robot& robot, const msg::Odometry& odometry);
  void OnScan(Robot& robot, std::size_t scanner, const msg::LaserScan& scan);
  void OnGoal(Robot& robot, const Goal& goal);
  void OnCancel(Robot& robot, Goal goal);
  Result<PathRequest> RequestOf(const Robot& robot, const Action::Goal& goal) const;
  void Plan(Robot& robot, PathRequest request);
  void OnReply(Robot& robot, const PathReply& reply);
  using Refuge = msg::ComputeRefuge;
  void FindRefugeOf(Robot& robot, const Refuge::Request& request,
                    const std::function<void(const Refuge::Response&)>& reply);
  Result<RefugeRequest> RequestOf(const Robot& robot, const Refuge::Request& request) const;
  Result<> CheckPlace(const Robot& robot) const;
  Result<> CheckMap(const Robot& robot) const;
  void Refuse(Robot& robot, const Error& error);
  std::string MissingOf(const Robot& robot) const;
  // Ends the request of a robot; what is planned for it is dropped.
  void Drop(Robot& robot, const std::string& why);
  void Warn(const Robot& robot, const std::string& kind, const std::string& what);
  void Log(LogLevel level, const std::string& line) const { dependencies_.log(level, line); }
  Time Now() const { return dependencies_.clock.Now(); }
  bool IsFresh(Time at) const { return Now() - at <= config_.stale; }

  const Dependencies dependencies_;
  const PlannerConfig config_;
  FrameTree frames_;
  KeepOut keep_out_;  // null: none
  RateLimitedLog warnings_;
  bool permitted_ = false;
  std::string not_permitted_ = "it is not in Active";
  std::vector<std::unique_ptr<Robot>> robots_;
  transport::LoopHandlePtr ticks_;
  std::unique_ptr<MaskSource> masks_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::navigation
