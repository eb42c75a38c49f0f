#include "musher/modules/navigation/controller_server/controller_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "musher/application/refusal.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/modules/navigation/server/robot_endpoints.hpp"
#include "musher/modules/navigation/server/thread_background.hpp"
#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/planner/octree_map.hpp"

namespace musher::navigation {
namespace {

constexpr Duration kUpdatePeriod = Duration(std::chrono::seconds(1)) / 60;
constexpr int kUpdatesAFeedback = 6;
constexpr Duration kQuietPeriod = std::chrono::seconds(2);  // between warnings of one kind
constexpr const char* kControllerId = "FollowPath";         // nav2's default name

Result<std::shared_ptr<const Clearance>> ClearanceOf(const msg::OccupancyGrid& map,
                                                     const std::string& frame) {
  auto grid = ToGrid(map, frame);
  if (!grid) return grid.error();
  auto cells = FromOccupancyGrid(grid.value(), {});
  if (!cells) return cells.error();
  if (auto checked = CheckCellMap(cells.value()); !checked) return checked.error();
  return std::make_shared<const Clearance>(std::move(cells).value());
}

Result<std::shared_ptr<const Clearance>> ClearanceOf(const msg::PointCloud2& cloud,
                                                     const ControllerConfig& config) {
  constexpr double kAroundM = 1;  // of free space around the points
  auto points = ToPoints(cloud, config.frame);
  if (!points) return points.error();
  auto tree = OctreeMap::Make(config.cloud_resolution_m);
  if (!tree) return tree.error();
  tree.value().Block(points.value());
  auto cells = tree.value().Cells({true, kAroundM});
  if (!cells) return cells.error();
  return std::make_shared<const Clearance>(std::move(cells).value());
}

}  // namespace

ControllerServer::ControllerServer(const Dependencies& dependencies, ControllerConfig config,
                                   std::unique_ptr<Background> background)
    : dependencies_(dependencies),
      config_(std::move(config)),
      frames_(config_.tf.stale),
      warnings_([this](const std::string& line) { Log(LogLevel::kWarning, line); }, kQuietPeriod),
      breaks_(dependencies.node.loop()),
      background_(std::move(background)),
      endpoints_(dependencies.node, dependencies.name_space) {}

ControllerServer::~ControllerServer() {
  Permit(false, "the server ends");
}

Result<std::unique_ptr<ControllerServer>> ControllerServer::Make(
    const Dependencies& dependencies, const ControllerConfig& config,
    std::unique_ptr<Background> background) {
  if (!background) background = std::make_unique<ThreadBackground>(dependencies.node.loop());
  std::unique_ptr<ControllerServer> server(
      new ControllerServer(dependencies, config, std::move(background)));
  if (const Result<> opened = server->Open(); !opened) return opened.error();
  return server;
}

Result<> ControllerServer::Open() {
  for (const ControllerRobot& config : config_.robots) {
    robots_.push_back(std::make_unique<Robot>(config, config_));
    OpenRobot(*robots_.back());
  }
  SubscribeMaps();
  if (!config_.speed_limit.empty()) {
    endpoints_.Subscribe<msg::SpeedLimit>(
        config_.speed_limit, [this](const msg::SpeedLimit& limit) { OnSpeedLimit(limit); });
  }
  SubscribeMasks();
  SubscribeFrames(endpoints_, config_.tf, dependencies_.clock, frames_);
  auto& loop = dependencies_.node.loop();
  quiet_ticks_ = loop.Every(kQuietPeriod, [this, &loop] { warnings_.Tick(loop.Now()); });
  return endpoints_.opened();
}

void ControllerServer::SubscribeMaps() {
  const auto any = [this](bool flies) {
    return std::ranges::any_of(robots_,
                               [&](const auto& robot) { return robot->config.flies == flies; });
  };
  if (!config_.map.empty() && any(false)) {
    endpoints_.Subscribe<msg::OccupancyGrid>(
        config_.map,
        [this](msg::OccupancyGrid&& map) {
          const auto grid = std::make_shared<const msg::OccupancyGrid>(std::move(map));
          OnMap(false, [this, grid] { return ClearanceOf(*grid, config_.frame); });
        },
        transport::kLatchedQos);
  }
  if (config_.cloud.empty() || !any(true)) return;
  endpoints_.Subscribe<msg::PointCloud2>(
      config_.cloud,
      [this](msg::PointCloud2&& map) {
        const auto cloud = std::make_shared<const msg::PointCloud2>(std::move(map));
        OnMap(true, [this, cloud] { return ClearanceOf(*cloud, config_); });
      },
      transport::kLatchedQos);
}

void ControllerServer::OpenRobot(Robot& robot) {
  const ControllerRobot& config = robot.config;
  if (config.stamped) {
    robot.stamped_command = endpoints_.Advertise<msg::TwistStamped>(config.command);
  } else {
    robot.command = endpoints_.Advertise<msg::Twist>(config.command);
  }
  robot.trajectory = endpoints_.Advertise<msg::JointTrajectory>(config.trajectory);
  RobotHandlers<Action> handlers;
  handlers.on_odometry = [this, &robot](const auto& odometry) { OnOdometry(robot, odometry); };
  handlers.on_scan = [this, &robot](std::size_t scanner, const auto& scan) {
    const auto mount = frames_.Find(robot.frame, scan.header.frame_id, Now());
    if (mount) robot.drive.Mount(scanner, mount.value());
    robot.drive.OnScan(scanner, ToScan(scan), msg::FromStamp(scan.header.stamp), Now());
  };
  handlers.clear_memory = [this, &robot] {
    robot.drive.ClearMemory();
    Log(LogLevel::kInfo, robot.config.name + ": what it has seen is forgotten");
  };
  handlers.accept = [this, &robot] {
    const std::string why = WhyRejected();
    if (why.empty()) return true;
    Warn(robot, "state", "a goal is rejected: " + why);
    // The drive that the goal was to replace ends: its client follows that one no more.
    Halt(robot, why);
    return false;
  };
  handlers.start = [this, &robot](const Goal& goal) { OnGoal(robot, goal); };
  handlers.cancel = [this, &robot](Goal goal) { OnCancel(robot, std::move(goal)); };
  if (!config.gate.down.topic.empty()) {
    endpoints_.Subscribe<msg::Range>(
        config.gate.down.topic,
        [this, &robot](const msg::Range& range) {
          robot.drive.OnRange(ToReading(range), msg::FromStamp(range.header.stamp), Now());
        },
        transport::kSensorDataQos);
  }
  OpenRobotEndpoints(endpoints_, config, config.action, dependencies_.clock, std::move(handlers));
}

void ControllerServer::Warn(const Robot& robot, const std::string& kind, const std::string& what) {
  warnings_.Log(robot.config.name + kind, robot.config.name + ": " + what,
                dependencies_.node.loop().Now());
}

void ControllerServer::OnMap(bool flies, MakeClearance make) {
  background_->Do([this, flies, make = std::move(make)] {
    const auto made = std::make_shared<Result<std::shared_ptr<const Clearance>>>(make());
    return [this, flies, made] {
      if (!*made) {
        return warnings_.Log("map", "a map is not used: " + made->error().message,
                             dependencies_.node.loop().Now());
      }
      for (const auto& robot : robots_) {
        if (robot->config.flies == flies) robot->drive.SetMap(made->value(), Now());
      }
    };
  });
}

// As nav2 has it: 0 is no limit.
void ControllerServer::OnSpeedLimit(const msg::SpeedLimit& limit) {
  if (!std::isfinite(limit.speed_limit) || limit.speed_limit < 0) {
    return warnings_.Log("speed_limit", "a speed limit that is not a number from 0 on is not used",
                         dependencies_.node.loop().Now());
  }
  for (const auto& robot : robots_) {
    const double own_m_s = robot->config.limits.speed_m_s;
    const double wanted = limit.percentage ? limit.speed_limit / 100 * own_m_s : limit.speed_limit;
    robot->limit_m_s = wanted > 0 ? wanted : std::numeric_limits<double>::infinity();
    LimitSpeed(*robot);
  }
  Log(LogLevel::kInfo, limit.speed_limit == 0
                           ? std::string("no speed limit")
                           : fmt::format("speed limit: {:.2f} {}", limit.speed_limit,
                                         limit.percentage ? "%" : "m/s"));
}

void ControllerServer::SubscribeMasks() {
  for (const std::string& topic : {config_.keep_out, config_.speed_mask}) {
    if (topic.empty()) continue;
    masks_.push_back(std::make_unique<MaskSource>(
        endpoints_, topic, dependencies_.name_space, config_.frame,
        MaskSource::Handlers{
            [this](std::uint8_t type, FilterMask mask) { OnMask(type, std::move(mask)); },
            [this](const std::string& why) {
              warnings_.Log("mask", "a mask is not used: " + why, dependencies_.node.loop().Now());
            }}));
  }
}

void ControllerServer::OnMask(std::uint8_t type, FilterMask mask) {
  using Info = msg::CostmapFilterInfo;
  constexpr int kKeptOutFrom = 65;  // per cent
  if (type == Info::kKeepout) {
    const auto cells = std::make_shared<const CellMap>(KeepOutCells(mask, kKeptOutFrom));
    for (const auto& robot : robots_) robot->drive.SetKeepOut(cells);
  } else if (type == Info::kSpeedPercent || type == Info::kSpeedMS) {
    speed_mask_ = std::move(mask);
    speed_in_percent_ = type == Info::kSpeedPercent;
    for (const auto& robot : robots_) LimitSpeed(*robot);
  } else {
    warnings_.Log("mask", fmt::format("a mask is not used: its type is {}, expected 0 to 2", type),
                  dependencies_.node.loop().Now());
  }
}

// As nav2 has it: an occupancy of 0, and a limit of 0, are no limit.
void ControllerServer::LimitSpeed(Robot& robot) {
  double limit_m_s = robot.limit_m_s;
  const auto pose = robot.drive.pose();
  const auto value = speed_mask_ && pose ? speed_mask_->At(pose->at) : std::nullopt;
  const bool limits = value && *value > 0 && *value != speed_mask_->base;
  if (limits) {
    const double own_m_s = robot.config.limits.speed_m_s;
    limit_m_s = std::min(limit_m_s, speed_in_percent_ ? *value / 100 * own_m_s : *value);
  }
  robot.drive.LimitSpeed(limit_m_s);
}

std::optional<DriveEnd> ControllerServer::ChooseCheckers(Robot& robot, const Action::Goal& goal) {
  double arrive_m = robot.config.arrive_m, arrive_rad = robot.config.arrive_rad;
  std::optional<ProgressRules> progress;
  const auto unknown = [](const std::string& what, const std::string& id) {
    return DriveEnd{FollowCode::kUnknown,
                    fmt::format("there is no {} '{}' in the config", what, id.substr(0, 40))};
  };
  const auto& goals = config_.goal_checkers;
  if (!goals.empty() && !goal.goal_checker_id.empty()) {
    const auto found = std::ranges::find(goals, goal.goal_checker_id, &NamedGoalChecker::name);
    if (found == goals.end()) return unknown("goal checker", goal.goal_checker_id);
    arrive_m = found->arrive_m;
    arrive_rad = found->arrive_rad;
  }
  const auto& checks = config_.progress_checkers;
  if (!checks.empty() && !goal.progress_checker_id.empty()) {
    const auto found =
        std::ranges::find(checks, goal.progress_checker_id, &NamedProgressChecker::name);
    if (found == checks.end()) return unknown("progress checker", goal.progress_checker_id);
    progress = found->rules;
  } else if (!checks.empty()) {
    progress = checks.front().rules;
  }
  robot.drive.Check(arrive_m, arrive_rad, progress);
  return std::nullopt;
}

void ControllerServer::OnOdometry(Robot& robot, const msg::Odometry& odometry) {
  auto motion = ToMotion(odometry, config_.frame, frames_, Now());
  if (!motion) return Warn(robot, "odometry", "refused: " + motion.error().message);
  robot.frame = odometry.child_frame_id;
  robot.drive.OnOdometry(motion.value(), msg::FromStamp(odometry.header.stamp), Now());
}

std::string ControllerServer::WhyRejected() {
  if (!permitted_) return not_permitted_;
  const auto could_not_run = breaks_.Recent();
  if (!could_not_run) return "";
  return Refused<ApplicationRefusal::kMayBeLate>("this server",
                                                 ToMilliseconds(*could_not_run) / 1000)
      .message;
}

// As after a restart: who sent the goals does not see that they are so old.
void ControllerServer::EndAfterBreak() {
  const auto could_not_run = breaks_.Take();
  if (!could_not_run || *could_not_run <= BreakWatch::kLong) return;
  for (const auto& robot : robots_) {
    Halt(*robot,
         fmt::format("this server could not run for {} s", ToMilliseconds(*could_not_run) / 1000));
  }
}

void ControllerServer::OnGoal(Robot& robot, const Goal& goal) {
  EndAfterBreak();  // of before this goal
  if (robot.goal) {
    const std::string why = "a newer goal has replaced the present one";
    Abort(robot, FollowCode::kUnknown, why);
    Log(LogLevel::kInfo, robot.config.name + ": " + why);
  }
  robot.goal = goal;
  robot.goal->Execute();
  robot.updates = 0;
  if (!permitted_) return Conclude(robot, {FollowCode::kUnknown, not_permitted_});
  const std::string& id = goal.goal().controller_id;
  if (!id.empty() && id != kControllerId) {
    return Conclude(robot, {FollowCode::kInvalidController,
                            "there is no controller of that controller_id, expected '' or '" +
                                std::string(kControllerId) + "'"});
  }
  const auto path = ToPath(goal.goal().path, config_.frame);
  if (!path) {
    const bool frame = Is(path.error(), Fault::kFrame);
    return Conclude(
        robot, {frame ? FollowCode::kTfError : FollowCode::kInvalidPath, path.error().message});
  }
  if (const auto unknown = ChooseCheckers(robot, goal.goal())) return Conclude(robot, *unknown);
  if (const auto refused = robot.drive.Start(path.value(), Now())) {
    return Conclude(robot, *refused);
  }
  if (!ticks_) ticks_ = dependencies_.clock.Every(kUpdatePeriod, [this] { Tick(); });
}

void ControllerServer::OnCancel(Robot& robot, Goal goal) {
  goal.Canceled({});
  if (!robot.goal || robot.goal->id() != goal.id()) return;
  robot.goal.reset();
  Stand(robot);
  Log(LogLevel::kInfo, robot.config.name + ": the drive is cancelled");
}

void ControllerServer::Tick() {
  EndAfterBreak();
  for (const auto& robot : robots_) {
    if (robot->drive.driving()) Update(*robot);
  }
  const bool drives = std::any_of(robots_.begin(), robots_.end(),
                                  [](const auto& robot) { return robot->drive.driving(); });
  if (!drives) ticks_.reset();
}

// A lost one is followed by the next.
void ControllerServer::Command(Robot& robot, const msg::Twist& twist) const {
  if (robot.command != nullptr) return static_cast<void>(robot.command->Publish(twist));
  msg::TwistStamped stamped;
  stamped.header.stamp = dependencies_.clock.Stamp();
  stamped.header.frame_id = "base_link";
  stamped.twist = twist;
  static_cast<void>(robot.stamped_command->Publish(stamped));
}

void ControllerServer::Update(Robot& robot) {
  LimitSpeed(robot);
  const PathDrive::Step step = robot.drive.Update(Now());
  if (step.begins) PublishTrajectory(robot);
  if (step.end) return Conclude(robot, *step.end);
  if (!step.held.empty()) Warn(robot, "gate", step.held);
  msg::Twist twist;
  twist.linear = {step.command.x_m_s, step.command.y_m_s, step.command.z_m_s};
  twist.angular.z = step.command.yaw_rad_s;
  Command(robot, twist);
  if (robot.goal && robot.updates++ % kUpdatesAFeedback == 0) {
    robot.goal->PublishFeedback(
        {static_cast<float>(step.distance_m), static_cast<float>(step.speed_m_s)});
  }
}

void ControllerServer::PublishTrajectory(Robot& robot) {
  msg::Header header;
  header.stamp = dependencies_.clock.Stamp();
  header.frame_id = config_.frame;
  static_cast<void>(robot.trajectory->Publish(ToMessage(robot.drive.trajectory(), header)));
}

void ControllerServer::Stand(Robot& robot) {
  robot.drive.Stop();
  Command(robot, {});  // without commands the robot stops as well
}

void ControllerServer::Abort(Robot& robot, std::uint16_t error_code, const std::string& why) {
  Action::Result result;
  result.error_code = error_code;
  result.error_msg = why;
  robot.goal->Abort(result);
  robot.goal.reset();
}

void ControllerServer::Conclude(Robot& robot, const DriveEnd& end) {
  Stand(robot);
  if (!robot.goal) return;
  if (end.error_code == FollowCode::kNone) {
    robot.goal->Succeed({});
    robot.goal.reset();
    return Log(LogLevel::kInfo, robot.config.name + ": it has arrived");
  }
  Abort(robot, end.error_code, end.reason);
  Warn(robot, fmt::format("end {}", end.error_code),
       fmt::format("the drive has ended: {} (error_code {})", end.reason, end.error_code));
}

void ControllerServer::Halt(Robot& robot, const std::string& why) {
  if (!robot.goal) return;
  Stand(robot);
  Abort(robot, FollowCode::kUnknown, why);
  Log(LogLevel::kInfo, robot.config.name + ": the drive has ended: " + why);
}

void ControllerServer::Permit(bool permitted, const std::string& why) {
  permitted_ = permitted;
  if (permitted) return;
  not_permitted_ = why;
  for (const auto& robot : robots_) Halt(*robot, why);
  ticks_.reset();
}

void ControllerServer::OnTimeJump(const std::string& why) {
  frames_.Forget();
  for (const auto& robot : robots_) {
    Halt(*robot, why);
    robot->drive.Forget();
  }
}

std::string ControllerServer::MissingOf(const Robot& robot) const {
  const std::string name = robot.config.name + ": ";
  if (const auto blind = robot.drive.Blind(Now())) return name + blind->reason;
  if (robot.drive.BlindBelow(Now())) {
    return name + "no recent range on " + robot.config.gate.down.topic;
  }
  const int readers = robot.command != nullptr ? robot.command->MatchedReaders()
                                               : robot.stamped_command->MatchedReaders();
  if (readers > 0) return "";
  return name + "no subscriber of " + robot.config.command;
}

SelfCheckResult ControllerServer::Check() const {
  SelfCheckResult result;
  for (const auto& robot : robots_) result.Add(MissingOf(*robot));
  return result;
}

}  // namespace musher::navigation
