#include "musher/modules/navigation/planner_server/planner_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/navigation/server/robot_endpoints.hpp"
#include "musher/modules/navigation/server/thread_background.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr Duration kQuietTime = std::chrono::seconds(2);      // between warnings of one kind
constexpr Duration kGoesOnWithin = std::chrono::seconds(60);  // with the last path to a goal
constexpr const char* kPlannerId = "GridBased";               // nav2's default name

// How long a search takes is real time, also where /clock is slower or faster.
Time SteadyNow() {
  return std::chrono::steady_clock::now();
}

}  // namespace

PlannerServer::PlannerServer(const Dependencies& dependencies, PlannerConfig config)
    : dependencies_(dependencies),
      config_(std::move(config)),
      frames_(config_.tf.stale),
      warnings_([this](const std::string& line) { Log(LogLevel::kWarning, line); }, kQuietTime),
      endpoints_(dependencies.node, dependencies.name_space) {}

PlannerServer::~PlannerServer() {
  // Ends the searches, for whose threads the destructors of the robots wait.
  Permit(false, "the server ends");
}

Result<std::unique_ptr<PlannerServer>> PlannerServer::Make(const Dependencies& dependencies,
                                                           const PlannerConfig& config,
                                                           const MakeBackground& background) {
  std::unique_ptr<PlannerServer> server(new PlannerServer(dependencies, config));
  const auto thread = [&dependencies]() -> std::unique_ptr<Background> {
    return std::make_unique<ThreadBackground>(dependencies.node.loop());
  };
  const Result<> opened = server->Open(background ? background : MakeBackground(thread));
  if (!opened) return opened.error();
  return server;
}

Result<> PlannerServer::Open(const MakeBackground& background) {
  bool ground = false, air = false;
  for (const PlannerRobot& config : config_.robots) {
    robots_.push_back(std::make_unique<Robot>());
    Robot& robot = *robots_.back();
    robot.config = &config;
    robot.background = background();
    (config.flies ? air : ground) = true;
    OpenRobot(robot);
  }
  if (ground) {
    endpoints_.Subscribe<msg::OccupancyGrid>(
        config_.map,
        [this](msg::OccupancyGrid&& map) {
          const auto grid = std::make_shared<const msg::OccupancyGrid>(std::move(map));
          for (const auto& robot : robots_) {
            if (robot->config->flies) continue;
            OnMap(*robot, [grid, config = config_, of = *robot->config](const CellMap* keep_out) {
              return MakePlanner(*grid, config, of, keep_out);
            });
          }
        },
        transport::kLatchedQos);
  }
  if (air) {
    endpoints_.Subscribe<msg::PointCloud2>(
        config_.cloud,
        [this](msg::PointCloud2&& map) {
          const auto cloud = std::make_shared<const msg::PointCloud2>(std::move(map));
          for (const auto& robot : robots_) {
            if (!robot->config->flies) continue;
            OnMap(*robot, [cloud, config = config_, of = *robot->config](const CellMap* keep_out) {
              return MakePlanner(*cloud, config, of, keep_out);
            });
          }
        },
        transport::kLatchedQos);
  }
  if (!config_.keep_out.empty()) {
    masks_ = std::make_unique<MaskSource>(
        endpoints_, config_.keep_out, dependencies_.name_space, config_.frame,
        MaskSource::Handlers{
            [this](std::uint8_t type, const FilterMask& mask) { OnKeepOut(type, mask); },
            [this](const std::string& why) {
              warnings_.Log("mask", "a mask is not used: " + why, dependencies_.node.loop().Now());
            }});
  }
  SubscribeFrames(endpoints_, config_.tf, dependencies_.clock, frames_);
  auto& loop = dependencies_.node.loop();
  ticks_ = loop.Every(kQuietTime, [this, &loop] { warnings_.Tick(loop.Now()); });
  return endpoints_.opened();
}

void PlannerServer::OpenRobot(Robot& robot) {
  const PlannerRobot& config = *robot.config;
  robot.path = endpoints_.Advertise<msg::Path>(config.path, transport::kLatchedQos);
  RobotHandlers<Action> handlers;
  handlers.on_odometry = [this, &robot](const auto& odometry) { OnOdometry(robot, odometry); };
  robot.scanners = std::vector<ScanView>(config.scanners.begin(), config.scanners.end());
  robot.seen.emplace(config_.memory);
  handlers.on_scan = [this, &robot](std::size_t scanner, const auto& scan) {
    OnScan(robot, scanner, scan);
  };
  handlers.clear_memory = [this, &robot] {
    robot.seen->Clear();
    Log(LogLevel::kInfo, robot.config->name + ": what it has seen is forgotten");
  };
  handlers.accept = [this, &robot] {
    if (!permitted_) Warn(robot, "state", "a goal is rejected: " + not_permitted_);
    return permitted_;
  };
  handlers.start = [this, &robot](const Goal& goal) { OnGoal(robot, goal); };
  handlers.cancel = [this, &robot](Goal goal) { OnCancel(robot, std::move(goal)); };
  OpenRobotEndpoints(endpoints_, config, config.action, dependencies_.clock, std::move(handlers));
  endpoints_.Serve<Refuge>(config.refuge, [this, &robot](const auto& request, auto reply) {
    FindRefugeOf(robot, request, reply);
  });
}

void PlannerServer::Warn(const Robot& robot, const std::string& kind, const std::string& what) {
  warnings_.Log(robot.config->name + kind, robot.config->name + ": " + what,
                dependencies_.node.loop().Now());
}

void PlannerServer::OnMap(Robot& robot, MakeFromMap make) {
  robot.make = std::move(make);
  Convert(robot);
}

void PlannerServer::OnKeepOut(std::uint8_t type, const FilterMask& mask) {
  if (type != msg::CostmapFilterInfo::kKeepout) {
    return warnings_.Log("mask",
                         fmt::format("a mask is not used: its type is {}, expected 0", type),
                         dependencies_.node.loop().Now());
  }
  keep_out_ = std::make_shared<const CellMap>(KeepOutCells(mask, config_.blocked_from));
  const auto cells = std::ranges::count(keep_out_->blocked, 1);
  Log(LogLevel::kInfo,
      fmt::format("{} cells of {:.2f} m to keep out of", cells, keep_out_->resolution_m));
  for (const auto& robot : robots_) Convert(*robot);
}

void PlannerServer::Convert(Robot& robot) {
  if (!robot.make) return;
  robot.outdated = robot.converting;
  if (robot.converting) return;
  robot.converting = true;
  robot.background->Do([this, &robot, make = robot.make, keep_out = keep_out_] {
    auto planner = std::make_shared<Result<Planner>>(make(keep_out.get()));
    return [this, &robot, planner] { OnConverted(robot, std::move(*planner)); };
  });
}

void PlannerServer::OnConverted(Robot& robot, Result<Planner> planner) {
  robot.converting = false;
  if (planner) {
    robot.planner = std::make_shared<const Planner>(std::move(planner).value());
    const CellMap& map = robot.planner->clearance().map();
    Log(LogLevel::kInfo, fmt::format("{}: a map of {} cells of {:.2f} m, {}", robot.config->name,
                                     map.count(), map.resolution_m, map.ExtentText()));
  } else {
    Warn(robot, "map",
         "a map is not used: " + planner.error().message +
             (robot.planner ? "; the one before stays" : ""));
  }
  if (robot.outdated) Convert(robot);
}

void PlannerServer::OnOdometry(Robot& robot, const msg::Odometry& odometry) {
  auto motion = ToMotion(odometry, config_.frame, frames_, Now());
  if (!motion) return Warn(robot, "odometry", "refused: " + motion.error().message);
  if (!robot.poses.Add(motion.value().pose, msg::FromStamp(odometry.header.stamp))) return;
  robot.seen->NotePlace(motion.value().pose.at);
  robot.motion = motion.value();
  robot.motion_at = Now();
  robot.frame = odometry.child_frame_id;
}

void PlannerServer::OnScan(Robot& robot, std::size_t scanner, const msg::LaserScan& scan) {
  ScanView& view = robot.scanners[scanner];
  if (!view.mount().given) {
    const auto mount = frames_.Find(robot.frame, scan.header.frame_id, Now());
    if (mount) view.Mount(mount.value().pose, mount.value().upside_down);
  }
  const Duration stamp = msg::FromStamp(scan.header.stamp);
  if (!view.Take(ToScan(scan), stamp, Now())) return;
  if (robot.poses.empty() || !IsFresh(robot.motion_at)) return;
  robot.seen->Add(CountedBy(view.mount(), ToScan(scan)),
                  PlacedAt(robot.poses.At(stamp), view.mount().on_body), Now());
}

void PlannerServer::OnTimeJump(const std::string& why) {
  frames_.Forget();
  for (const auto& robot : robots_) {
    robot->motion.reset();
    robot->poses.Clear();
    for (ScanView& view : robot->scanners) view.Forget();
    robot->seen->Clear();
    Drop(*robot, why);
  }
}

void PlannerServer::Permit(bool permitted, const std::string& why) {
  permitted_ = permitted;
  if (permitted) return;
  not_permitted_ = why;
  for (const auto& robot : robots_) Drop(*robot, why);
}

void PlannerServer::Drop(Robot& robot, const std::string& why) {
  if (!robot.request) return;
  *robot.request->stop = true;
  Action::Result result;
  result.error_code = PathCode::kUnknown;
  result.error_msg = why;
  robot.request->goal.Abort(result);
  robot.request.reset();
  Log(LogLevel::kInfo, robot.config->name + ": planning has ended: " + why);
}

void PlannerServer::OnCancel(Robot& robot, Goal goal) {
  goal.Canceled({});
  if (!robot.request || robot.request->goal.id() != goal.id()) return;
  *robot.request->stop = true;
  robot.request.reset();
}

void PlannerServer::OnGoal(Robot& robot, const Goal& goal) {
  Drop(robot, "a newer goal has replaced this one");
  robot.request.emplace(Request{goal, {}, std::make_shared<std::atomic<bool>>(false), SteadyNow()});
  robot.request->goal.Execute();
  if (!permitted_) return Refuse(robot, MakeError(Fault::kInput, not_permitted_));
  auto request = RequestOf(robot, goal.goal());
  if (!request) return Refuse(robot, request.error());
  Plan(robot, std::move(request).value());
}

Result<> PlannerServer::CheckPlace(const Robot& robot) const {
  if (robot.motion && IsFresh(robot.motion_at)) return Ok();
  return MakeError(
      Fault::kOdometry,
      fmt::format(
          "the place of the robot is not known: no odometry on {} {}", robot.config->odometry,
          robot.motion ? fmt::format("for {:.1f} s", ToSeconds(Now() - robot.motion_at)) : "yet"));
}

Result<> PlannerServer::CheckMap(const Robot& robot) const {
  if (robot.planner) return Ok();
  return MakeError(Fault::kMap, "there is no map yet, on " +
                                    (robot.config->flies ? config_.cloud : config_.map));
}

Result<PathRequest> PlannerServer::RequestOf(const Robot& robot, const Action::Goal& goal) const {
  if (!goal.planner_id.empty() && goal.planner_id != kPlannerId) {
    return MakeError(
        Fault::kIdentifier,
        "there is no planner of that planner_id, expected '' or '" + std::string(kPlannerId) + "'");
  }
  auto to = ToPose(goal.goal, config_.frame, "goal");
  if (!to) return to.error();
  PathRequest request;
  request.goal = to.value();
  const bool knows_place = robot.motion && IsFresh(robot.motion_at);
  if (goal.use_start) {
    auto from = ToPose(goal.start, config_.frame, "start");
    if (!from) return from.error();
    request.start = from.value();
  } else if (auto checked = CheckPlace(robot); !checked) {
    return checked.error();
  } else {
    request.start = robot.motion->pose;
  }
  if (auto checked = CheckMap(robot); !checked) return checked.error();
  if (knows_place) request.seen = robot.seen->Points(Now());
  const bool goes_on = robot.last && robot.last->planner == robot.planner &&
                       robot.last->goal == request.goal && Now() - robot.last->at <= kGoesOnWithin;
  if (goes_on && !goal.use_start) request.before = robot.last->path;
  return request;
}

void PlannerServer::Plan(Robot& robot, PathRequest request) {
  const auto stop = robot.request->stop;
  robot.request->to = request.goal;
  const Time deadline = robot.request->begin + config_.limit;
  robot.background->Do([this, &robot, planner = robot.planner, request = std::move(request),
                        config = config_, of = *robot.config, stop, deadline] {
    const auto reply = std::make_shared<const PathReply>(
        FindPath(*planner, request, config, of, [&] { return *stop || SteadyNow() >= deadline; }));
    return [this, &robot, reply, stop] {
      // A request that was cancelled or replaced has ended.
      if (robot.request && robot.request->stop == stop) OnReply(robot, *reply);
    };
  });
}

Result<RefugeRequest> PlannerServer::RequestOf(const Robot& robot,
                                               const Refuge::Request& request) const {
  if (!permitted_) return MakeError(Fault::kInput, not_permitted_);
  if (auto checked = CheckPlace(robot); !checked) return checked.error();
  if (auto checked = CheckMap(robot); !checked) return checked.error();
  RefugeRequest wanted{robot.motion->pose, robot.seen->Points(Now()), {}};
  for (const msg::RobotPath& path : request.robots) {
    auto other = ToIntent(path, config_.frame);
    if (!other) return other.error();
    wanted.others.push_back(std::move(other).value());
  }
  return wanted;
}

void PlannerServer::FindRefugeOf(Robot& robot, const Refuge::Request& request,
                                 const std::function<void(const Refuge::Response&)>& reply) {
  const auto answer = [this, &robot, reply](const Result<navigation::Plan>& plan) {
    Refuge::Response response;
    response.success = plan.ok();
    if (!plan) {
      response.message = plan.error().message;
      Warn(robot, "refuge", "it has no place to give way to: " + plan.error().message);
      return reply(response);
    }
    msg::Header header;
    header.stamp = dependencies_.clock.Stamp();
    header.frame_id = config_.frame;
    response.path = ToMessage(plan.value().path, header);
    reply(response);
  };
  auto wanted = RequestOf(robot, request);
  if (!wanted) return answer(wanted.error());
  const Time deadline = SteadyNow() + config_.limit;
  robot.background->Do([planner = robot.planner, wanted = std::move(wanted).value(),
                        of = *robot.config, deadline, answer] {
    const auto plan = std::make_shared<const Result<navigation::Plan>>(
        FindRefuge(*planner, wanted, of, [&] { return SteadyNow() >= deadline; }));
    return [plan, answer] { answer(*plan); };
  });
}

void PlannerServer::OnReply(Robot& robot, const PathReply& reply) {
  if (!reply.plan) return Refuse(robot, reply.plan.error());
  const navigation::Plan& plan = reply.plan.value();
  const Duration took = SteadyNow() - robot.request->begin;
  msg::Header header;
  header.stamp = dependencies_.clock.Stamp();
  header.frame_id = config_.frame;
  Action::Result result;
  result.path = ToMessage(plan.path, header);
  const msg::Stamp span = msg::ToStamp(took);
  result.planning_time = {span.sec, span.nanosec};
  static_cast<void>(robot.path->Publish(result.path));  // latched; the result has it as well
  robot.request->goal.Succeed(result);
  robot.last = Robot::LastPath{robot.planner, robot.request->to, plan.path, Now()};
  robot.request.reset();
  const Point& goal = plan.path.back().at;
  Log(LogLevel::kInfo,
      fmt::format("{}: a path of {:.2f} m to ({:.2f}, {:.2f}, {:.2f}), {:.0f} ms{}",
                  robot.config->name, plan.length_m, goal.x_m, goal.y_m, goal.z_m,
                  std::chrono::duration<double, std::milli>(took).count(),
                  reply.around_seen ? ", around what its scan sees" : ""));
}

void PlannerServer::Refuse(Robot& robot, const Error& error) {
  Action::Result result;
  result.error_code = ErrorCodeOf(error);
  result.error_msg = error.message;
  robot.request->goal.Abort(result);
  robot.request.reset();
  Warn(robot, fmt::format("refused {}", error.code),
       fmt::format("no path: {} (error_code {})", WithCode(error.message, error.code),
                   result.error_code));
}

std::string PlannerServer::MissingOf(const Robot& robot) const {
  const PlannerRobot& config = *robot.config;
  if (!robot.planner) {
    return config.name + ": no map on " + (config.flies ? config_.cloud : config_.map);
  }
  const bool knows_place = robot.motion && IsFresh(robot.motion_at);
  return knows_place ? "" : config.name + ": no odometry on " + config.odometry;
}

SelfCheckResult PlannerServer::Check() const {
  SelfCheckResult result;
  for (const auto& robot : robots_) result.Add(MissingOf(*robot));
  return result;
}

}  // namespace musher::navigation
