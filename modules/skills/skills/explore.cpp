#include "musher/modules/skills/skills/explore.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "musher/modules/skills/skills/points_text.hpp"
#include "musher/navigation/planner/headings.hpp"

namespace musher::skills {
namespace {

using skill::Next;
using skill::Tick;
using Kind = TravelStep::Kind;

// The data of a run: how far on the path it is, with what it has left out, and where it began.
constexpr std::string_view kIndex = "index";
constexpr std::string_view kSkipped = "skipped_m";
constexpr std::string_view kBegin = "begin";

// From an obstacle on the path to the point at which the path is tried again.
constexpr double kSkipM = 1;
constexpr std::size_t kMostPoints = 200'000;

std::size_t IndexOf(const Tick& tick) {
  return static_cast<std::size_t>(tick.data.Get<std::int64_t>(kIndex, 0));
}

void SetIndex(Tick& tick, std::size_t index) {
  tick.data.Set(kIndex, static_cast<std::int64_t>(index));
}

coverage::Ring RingOf(const Points& points) {
  coverage::Ring ring;
  for (const navigation::Point& point : points) ring.push_back({point.x_m, point.y_m});
  return ring;
}

Error BadArea(std::string why) {
  return {kCodeParametersInvalid, std::move(why)};
}

Result<coverage::Region> RegionOf(const skill::Values& parameters) {
  const auto boundary = ParsePoints("boundary", parameters.Text("boundary"));
  if (!boundary) return boundary.error();
  const auto holes = ParseLists("holes", parameters.Text("holes"));
  if (!holes) return holes.error();
  coverage::Region region{RingOf(boundary.value()), {}};
  for (const Points& hole : holes.value()) region.holes.push_back(RingOf(hole));
  return region;
}

}  // namespace

void Explore::Declare(skill::Table& table) {
  initializing_ = table.State("INITIALIZING");
  to_start_ = table.State("NAVIGATING_TO_START", std::chrono::seconds(60));
  executing_ = table.State("EXECUTING", std::chrono::seconds(120));
  stopping_ = table.State("STOPPING");
  table.To(initializing_, to_start_, "the path is computed, the servers are reachable");
  table.To(to_start_, executing_, "at the start");
  table.To(executing_, skill::kSucceeded, "at the end of the path");
  for (const skill::StateId state : {to_start_, executing_}) {
    table.To(state, initializing_, "a server is lost, or has no map");
  }
  for (const skill::StateId state : {initializing_, to_start_, executing_}) {
    table.To(state, skill::kFailed, "failed");
    table.To(state, stopping_, "cancel");
  }
  table.To(stopping_, skill::kCancelled, "the robot stands");
  table.Limit({.run = skill::kNoLimit});
  table.MonotoneProgress();
  table.Does("Goes over an area in lanes, past holes and obstacles");
  table.Uses(kBase);
  table.Needs("boundary", skill::Kind::kText, "corners, m in the map: [[0, 0], [9, 0], [9, 9]]");
  table.Takes("holes", std::string(), "lists of corners, m in the map: [[[3, 3], [4, 3], [4, 4]]]");
  table.Takes("lane_width", 2.0, "m, from lane to lane");
  table.Takes("robot_radius", 0.5, "m, room to the boundary and the holes");
  table.Takes("interpolation_distance", 0.05, "m, from point to point of the path");
  table.Takes("interpolation_method", std::string("linear"), "linear");
  DeclareLostLimit(table);
  table.RefusesParameter("target_prim",
                         "it goes over an area, not to an object; detect finds an object");
}

Next Explore::Step(Tick& tick) {
  if (tick.state == stopping_) return Stop(tick);
  DoNotGiveWay();
  if (path_.empty()) {
    const Result<> limit = CheckLostLimit(tick.parameters);
    const Result<> made = limit ? MakePath(tick) : limit;
    if (!made) return Next::Fail(made.error().message);
  }
  tick.Detail("path_length", plan_.length_m);
  tick.Detail("skipped", tick.data.Number(kSkipped));
  tick.Detail("lanes", static_cast<std::int64_t>(plan_.lanes));
  if (tick.state == initializing_) return Initialize(tick);
  return tick.state == to_start_ ? GoToStart(tick) : Execute(tick);
}

Result<> Explore::MakePath(Tick& tick) {
  const auto region = RegionOf(tick.parameters);
  if (!region) return region.error();
  if (tick.parameters.Text("interpolation_method") != "linear") {
    return BadArea("interpolation_method is '" + tick.parameters.Text("interpolation_method") +
                   "'; expected linear");
  }
  const double distance_m = tick.parameters.Number("interpolation_distance");
  constexpr double kLeastM = 0.01;
  if (distance_m < kLeastM) {
    return BadArea(fmt::format("interpolation_distance is {:g} m; expected at least {:g} m",
                               distance_m, kLeastM));
  }
  // A run that was restored has the path with which it began.
  if (tick.data.Find(kBegin) == nullptr) {
    const auto pose = robot_.pose().value_or(navigation::Pose());
    tick.data.Set(kBegin, skill::Numbers{pose.at.x_m, pose.at.y_m, pose.at.z_m});
  }
  const auto begin = tick.data.Get<skill::Numbers>(kBegin, {0, 0, 0});
  const double height_m = robot_.flies() ? begin[2] : 0;
  if (robot_.pose()) {
    const Result<> flies = CheckInTheAir(robot_, height_m);
    if (!flies) return flies.error();
  }
  const auto plan = coverage::PlanCoverage(
      region.value(),
      {tick.parameters.Number("lane_width"), tick.parameters.Number("robot_radius")},
      coverage::GroundPoint{begin[0], begin[1]});
  if (!plan) return plan.error();
  if (plan.value().length_m / distance_m > static_cast<double>(kMostPoints)) {
    return BadArea(
        fmt::format("the path of {:.0f} m has more than {} points; expected a larger "
                    "interpolation_distance",
                    plan.value().length_m, kMostPoints));
  }
  plan_ = plan.value();
  std::vector<navigation::Point> points;
  for (const auto& point : coverage::Interpolated(plan_.corners, distance_m)) {
    points.push_back({point.x_m, point.y_m, height_m});
  }
  const auto direction = [](const navigation::Point& from, const navigation::Point& to) {
    return std::atan2(to.y_m - from.y_m, to.x_m - from.x_m);
  };
  const std::size_t count = points.size();
  path_ = navigation::WithHeadings(points, count < 2 ? 0 : direction(points[0], points[1]),
                                   count < 2 ? 0 : direction(points[count - 2], points[count - 1]),
                                   navigation::Heading::kAlong);
  SetIndex(tick, std::min(IndexOf(tick), path_.size() - 1));
  return Ok();
}

Next Explore::Initialize(Tick& tick) {
  if (const auto waits = WaitForParts(tick, 20, "", "Planning coverage path...")) return *waits;
  return Next::To(to_start_);
}

Next Explore::GoToStart(Tick& tick) {
  approaches_ = true;
  const TravelStep step = Approach(tick);
  if (travel_.driving()) NoteDriving(tick);
  if (!travel_.driving()) {
    tick.Report(40, "Planning path to the start...");
  } else {
    travel_.AddDetails(tick);
    tick.Report(60, fmt::format("Moving to the start... ({:.1f}s)", ToSeconds(tick.elapsed)));
  }
  if (step.kind == Kind::kDone) return Next::To(executing_);
  if (IsMostlyBlocked(tick)) return FailBlocked(tick);
  return After(tick, step);
}

Next Explore::Execute(Tick& tick) {
  if (!approaches_ && !travel_.driving()) {
    if (IndexOf(tick) + 1 >= path_.size()) return Finish(tick);
    BeginRest(tick);
  }
  if (approaches_) {
    const TravelStep step = Approach(tick);
    if (step.kind != Kind::kDone && step.kind != Kind::kPending) return After(tick, step);
  } else {
    const TravelStep step = travel_.Drive(tick.step);
    NoteProgress(tick);
    if (step.kind == Kind::kDone) return Finish(tick);
    if (step.kind == Kind::kBlocked) {
      Skip(tick, step.why);
    } else if (step.kind != Kind::kPending) {
      return After(tick, step);
    }
  }
  if (IsMostlyBlocked(tick)) return FailBlocked(tick);
  if (travel_.driving()) {
    NoteDriving(tick);
    travel_.AddDetails(tick);
  }
  tick.Report(65 + 30 * static_cast<double>(IndexOf(tick)) / static_cast<double>(path_.size()),
              fmt::format("{} ({:.1f}s)", approaches_ ? "Passing an obstacle..." : "Exploring...",
                          ToSeconds(tick.elapsed)));
  return Next::Stay();
}

void Explore::BeginRest(const Tick& tick) {
  const std::size_t index = IndexOf(tick);
  const auto pose = robot_.pose();
  if (pose && travel_.Apart(pose->at, path_[index].at) > kArrivedWithinM) {
    approaches_ = true;  // moved in a pause
    return;
  }
  navigation::Path rest;
  if (pose) rest.push_back({{pose->at.x_m, pose->at.y_m, path_[index].at.z_m}, pose->yaw_rad});
  rest.insert(rest.end(), path_.begin() + static_cast<std::ptrdiff_t>(index), path_.end());
  travel_.Begin(rest);
}

TravelStep Explore::Approach(Tick& tick) {
  const bool drives = travel_.driving();
  const navigation::Pose& target = path_[IndexOf(tick)];
  TravelStep step =
      drives ? travel_.Drive(tick.step) : travel_.Plan(target, std::nullopt, tick.step);
  if (step.kind == Kind::kDone && !drives) {
    travel_.Begin(travel_.planned());
    return {Kind::kPending};
  }
  if (step.kind == Kind::kDone) approaches_ = false;
  // The planner's path leads through the obstacle when none leads around it.
  const bool blocked = step.kind == Kind::kBlocked || (step.kind == Kind::kFailed && !drives);
  if (!blocked) return step;
  const bool begins = tick.state == to_start_ && IndexOf(tick) == 0;
  if (begins && drives && IsFarFrom(target)) return {Kind::kPending};
  const bool last = IndexOf(tick) + 1 >= path_.size();
  if (last && path_.size() == 1) return {Kind::kFailed, step.why};
  if (!last) {
    Skip(tick, step.why);
    return {Kind::kPending};
  }
  approaches_ = false;  // the end of the path is left out
  return {Kind::kDone};
}

// From there another way to the target may be seen, or the obstacle may leave.
bool Explore::IsFarFrom(const navigation::Pose& target) const {
  constexpr double kFarM = 2;
  const auto pose = robot_.pose();
  return pose && travel_.Apart(pose->at, target.at) > kFarM;
}

Next Explore::After(Tick& tick, const TravelStep& step) {
  if (step.kind == Kind::kPending) return Next::Stay();
  approaches_ = false;
  if (step.kind == Kind::kLost) return AfterLoss(tick, "", step.why);
  return Next::Fail(step.why);
}

void Explore::NoteProgress(Tick& tick) {
  const auto pose = robot_.pose();
  if (!pose) return;
  constexpr double kWindowM = 1;  // less than from lane to lane
  std::size_t index = IndexOf(tick);
  const std::size_t end = Ahead(index, kWindowM);
  for (std::size_t i = index; i <= end; ++i) {
    if (travel_.Apart(path_[i].at, pose->at) < travel_.Apart(path_[index].at, pose->at)) index = i;
  }
  SetIndex(tick, index);
}

std::size_t Explore::Ahead(std::size_t index, double distance_m) const {
  double passed_m = 0;
  while (index + 1 < path_.size() && passed_m < distance_m) {
    passed_m += navigation::Distance(path_[index].at, path_[index + 1].at);
    ++index;
  }
  return index;
}

void Explore::Skip(Tick& tick, const std::string& why) {
  const std::size_t to = Ahead(IndexOf(tick), kSkipM);
  double skipped_m = tick.data.Number(kSkipped);
  for (std::size_t i = IndexOf(tick); i < to; ++i) {
    skipped_m += navigation::Distance(path_[i].at, path_[i + 1].at);
  }
  tick.data.Set(kSkipped, skipped_m);
  SetIndex(tick, to);
  approaches_ = true;
  obstacle_ = why;
}

bool Explore::IsMostlyBlocked(const Tick& tick) const {
  return tick.data.Number(kSkipped) > plan_.length_m / 2;
}

Next Explore::FailBlocked(const Tick& tick) const {
  return Next::Fail(fmt::format("{:.1f} m of the path of {:.1f} m were blocked: {}",
                                tick.data.Number(kSkipped), plan_.length_m, obstacle_));
}

Next Explore::Finish(const Tick& tick) const {
  const double skipped_m = tick.data.Number(kSkipped);
  if (IsMostlyBlocked(tick)) return FailBlocked(tick);
  std::string message =
      fmt::format("Exploration completed ({:.1f} m in {} lanes", plan_.length_m, plan_.lanes);
  if (skipped_m > 0) message += fmt::format(", {:.1f} m blocked", skipped_m);
  if (plan_.cells_left_out > 0) {
    message += fmt::format(", {} parts cannot be reached", plan_.cells_left_out);
  }
  return Next::Succeed(message + ")");
}

Next Explore::OnLimit(Tick& tick) {
  if (tick.state == initializing_) return Next::Fail(WhyLost(tick));
  if (tick.state == to_start_) return Next::Fail("Navigate timeout: the start was not reached");
  const double done = static_cast<double>(IndexOf(tick)) / static_cast<double>(path_.size());
  return Next::Fail(fmt::format("Timeout: {:.0f} % of the path were explored", 100 * done));
}

}  // namespace musher::skills
