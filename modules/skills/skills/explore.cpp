#include "musher/modules/skills/skills/explore.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "musher/modules/skills/skills/points_text.hpp"
#include "musher/navigation/planner/cell_map.hpp"
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
constexpr std::string_view kCuts = "cuts";  // points that the map has as blocked, from and to
constexpr std::string_view kLacksMap = "lacks_map";
constexpr std::string_view kAtEnd = "at_end";         // of the path
constexpr std::string_view kParts = "skipped_parts";  // of the path, from index to index

// From an obstacle on the path to the point at which the path is tried again.
constexpr double kSkipM = 1;
constexpr std::size_t kMostPoints = 200'000;
constexpr double kMapMarginM = 0.1;   // of the body to what the map has, as planners keep it
constexpr double kLeastPieceM = 0.3;  // of a lane between two things of the map
constexpr std::size_t kMostAreas = 2500;
constexpr std::size_t kCornersAStep = 40;  // ten strips, or one area of more corners
constexpr double kLeastCovered = 0.9;

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

Result<std::vector<coverage::Region>> RegionsOf(const skill::Values& parameters) {
  const std::string text = parameters.Text("boundary");
  const auto holes = ParseLists("holes", parameters.Text("holes"));
  std::vector<coverage::Region> regions;
  if (HasLists(text)) {
    const auto boundaries = ParseLists("boundary", text);
    if (!boundaries) return boundaries.error();
    for (const Points& boundary : boundaries.value()) regions.push_back({RingOf(boundary), {}});
  } else {
    const auto boundary = ParsePoints("boundary", text);
    if (!boundary) return boundary.error();
    regions.push_back({RingOf(boundary.value()), {}});
  }
  if (!holes) return holes.error();
  if (regions.size() > 1 && !holes.value().empty()) {
    return BadArea("holes belong to one area, and boundary has " + std::to_string(regions.size()));
  }
  if (regions.size() > kMostAreas) {
    return BadArea(
        fmt::format("boundary has {} areas; expected at most {}", regions.size(), kMostAreas));
  }
  for (const Points& hole : holes.value()) regions.front().holes.push_back(RingOf(hole));
  return regions;
}

std::size_t CornersOf(const coverage::Region& region) {
  std::size_t corners = region.boundary.size();
  for (const coverage::Ring& hole : region.holes) corners += hole.size();
  return corners;
}

double LengthOf(const std::vector<coverage::Edge>& lines) {
  double length_m = 0;
  for (const coverage::Edge& line : lines) length_m += coverage::Distance(line.from, line.to);
  return length_m;
}

// Lines that go on from each other in one direction are one.
void AddLine(std::vector<coverage::Edge>& lines, const coverage::Edge& line) {
  constexpr double kSameM = 1e-6;
  const bool goes_on = !lines.empty() && coverage::Distance(lines.back().to, line.from) < kSameM &&
                       coverage::Distance(line.from, {lines.back().from, line.to}) < kSameM;
  if (goes_on) {
    lines.back().to = line.to;
  } else {
    lines.push_back(line);
  }
}

// The strip around a piece of a lane, so that a run over it has the same lane again: it is narrower
// than two lanes and, at its ends, longer by the room that a run keeps to its boundary.
Points StripOf(const coverage::Edge& lane, double lane_width_m, double radius_m) {
  constexpr double kRoundedM = 0.02;  // its text has centimetres
  const double half_m = std::max(lane_width_m / 2 - kRoundedM, radius_m + kRoundedM);
  const double more_m = radius_m + kRoundedM;
  const double length_m = coverage::Distance(lane.from, lane.to);
  const double x = length_m > 0 ? (lane.to.x_m - lane.from.x_m) / length_m : 1;
  const double y = length_m > 0 ? (lane.to.y_m - lane.from.y_m) / length_m : 0;
  const auto corner = [&](const coverage::GroundPoint& at, double along_m, double left_m) {
    return navigation::Point{at.x_m + along_m * x - left_m * y, at.y_m + along_m * y + left_m * x,
                             0};
  };
  return {corner(lane.from, -more_m, -half_m), corner(lane.to, more_m, -half_m),
          corner(lane.to, more_m, half_m), corner(lane.from, -more_m, half_m)};
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
  table.Needs("boundary", skill::Kind::kText,
              "corners, m in the map: [[0, 0], [9, 0], [9, 9]], or several such lists");
  table.Takes("holes", std::string(), "lists of corners, m in the map: [[[3, 3], [4, 3], [4, 4]]]");
  table.Takes("least_covered", kLeastCovered, "of the lanes, 0 to 1, so that it is completed");
  table.Takes("lane_width", 2.0, "m, from lane to lane");
  table.Takes("robot_radius", 0.5, "m, room to the boundary and the holes");
  table.Takes("interpolation_distance", 0.05, "m, from point to point of the path");
  table.Takes("interpolation_method", std::string("linear"), "linear");
  DeclareLostLimit(table);
  table.RefusesParameter("target_prim",
                         "it goes over an area, not to an object; detect finds an object");
}

Next Explore::Step(Tick& tick) {
  return AtEnd(tick, Go(tick));
}

Next Explore::Go(Tick& tick) {
  if (tick.state == stopping_) return Stop(tick);
  if (const Result<> may = CheckAfterPause(); !may) return Next::Fail(may.error().message);
  DoNotGiveWay();
  if (!made_) {
    if (const auto next = MakePath(tick)) return *next;
  }
  tick.Detail("path_length", plan_.length_m);
  tick.Detail("left_out_by_map", cut_m_);
  tick.Detail("skipped", tick.data.Number(kSkipped));
  tick.Detail("lanes", static_cast<std::int64_t>(plan_.lanes));
  if (tick.state == initializing_) return Initialize(tick);
  return tick.state == to_start_ ? GoToStart(tick) : Execute(tick);
}

std::optional<Next> Explore::MakePath(Tick& tick) {
  if (left_.empty()) {
    // A run that was restored has the cuts with which it began, or, of an older version, none.
    const bool maps = !robot_.flies() && tick.data.Find(kBegin) == nullptr;
    const GroundMap map = maps ? robot_.map() : GroundMap{};
    if (map.awaited && map.cells == nullptr) {
      tick.Report(10, "Waiting for the map");
      return Next::Stay();
    }
    map_ = map.cells;
    lacks_map_ = map.expected && map.cells == nullptr;
    const Result<> begun = BeginPath(tick);
    if (!begun) return Next::Fail(begun.error().message);
  }
  for (std::size_t corners = 0; !left_.empty() && corners < kCornersAStep;) {
    const auto added = AddNearest(tick);
    if (!added) return Next::Fail(added.error().message);
    corners += added.value();
  }
  if (!left_.empty()) {
    tick.Report(15, "Planning coverage path...");
    return Next::Stay();
  }
  const Result<> ended = EndPath(tick);
  return ended ? std::nullopt : std::optional(Next::Fail(ended.error().message));
}

Result<> Explore::BeginPath(const Tick& tick) {
  if (const Result<> limit = CheckLostLimit(tick.parameters); !limit) return limit.error();
  const auto regions = RegionsOf(tick.parameters);
  if (!regions) return regions.error();
  const double least = tick.parameters.Number("least_covered");
  if (!(least >= 0 && least <= 1)) {
    return BadArea(fmt::format("least_covered is {:g}; expected 0 to 1", least));
  }
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
  const auto pose = robot_.pose().value_or(navigation::Pose());
  begin_ = tick.data.Get<skill::Numbers>(kBegin, {pose.at.x_m, pose.at.y_m, pose.at.z_m});
  begin_.resize(3);
  cuts_ = tick.data.Get<skill::Numbers>(kCuts, {});
  if (robot_.pose()) {
    const Result<> flies = CheckInTheAir(robot_, pose.at.z_m);
    if (!flies) return flies.error();
  }
  left_ = regions.value();
  return Ok();
}

Result<std::size_t> Explore::AddNearest(const Tick& tick) {
  const coverage::GroundPoint here =
      path_.empty() ? coverage::GroundPoint{begin_[0], begin_[1]}
                    : coverage::GroundPoint{path_.back().at.x_m, path_.back().at.y_m};
  const auto nearest = std::ranges::min_element(left_, {}, [&](const coverage::Region& region) {
    double away_m = std::numeric_limits<double>::infinity();
    for (const auto& corner : region.boundary) {
      away_m = std::min(away_m, coverage::Distance(here, corner));
    }
    return away_m;
  });
  const coverage::Region region = std::move(*nearest);
  left_.erase(nearest);
  const Result<> added = AddPath(region, here, tick);
  if (!added) return added.error();
  return CornersOf(region);
}

// What is saved before the path is complete would be the half of one.
Result<> Explore::EndPath(Tick& tick) {
  map_.reset();
  if (path_.empty()) return BadArea("the map leaves no room for the robot in the boundary");
  tick.data.Set(kBegin, begin_);
  tick.data.Set(kCuts, cuts_);
  if (lacks_map_) tick.data.Set(kLacksMap, true);
  SetIndex(tick, std::min(IndexOf(tick), path_.size() - 1));
  made_ = true;
  return Ok();
}

Result<> Explore::AddPath(const coverage::Region& region, const coverage::GroundPoint& start,
                          const Tick& tick) {
  const double height_m = robot_.flies() ? begin_[2] : 0;
  const double distance_m = tick.parameters.Number("interpolation_distance");
  const auto plan = coverage::PlanCoverage(
      region, {tick.parameters.Number("lane_width"), tick.parameters.Number("robot_radius")},
      start);
  if (!plan) return plan.error();
  const coverage::Plan& area = plan.value();
  const double whole_m = plan_.length_m + cut_m_ + area.length_m;
  if (whole_m / distance_m > static_cast<double>(kMostPoints)) {
    return BadArea(
        fmt::format("the path of {:.0f} m has more than {} points; expected a larger "
                    "interpolation_distance",
                    whole_m, kMostPoints));
  }
  plan_.length_m += area.length_m;
  plan_.lanes += area.lanes;
  plan_.cells_left_out += area.cells_left_out;
  plan_.lanes_left_out.insert(plan_.lanes_left_out.end(), area.lanes_left_out.begin(),
                              area.lanes_left_out.end());
  std::vector<navigation::Point> points;
  std::vector<bool> on_lane;  // the line to each point
  for (std::size_t i = 0; i < area.corners.size(); ++i) {
    if (i == 0) {
      points.push_back({area.corners[0].x_m, area.corners[0].y_m, height_m});
      on_lane.push_back(false);
      continue;
    }
    const auto line = coverage::Interpolated({area.corners[i - 1], area.corners[i]}, distance_m);
    for (std::size_t k = 1; k < line.size(); ++k) {
      points.push_back({line[k].x_m, line[k].y_m, height_m});
      on_lane.push_back(area.on_lane[i - 1]);
    }
  }
  const auto direction = [](const navigation::Point& from, const navigation::Point& to) {
    return std::atan2(to.y_m - from.y_m, to.x_m - from.x_m);
  };
  const std::size_t count = points.size();
  const navigation::Path path = navigation::WithHeadings(
      points, count < 2 ? 0 : direction(points[0], points[1]),
      count < 2 ? 0 : direction(points[count - 2], points[count - 1]), navigation::Heading::kAlong);
  std::vector<bool> along;  // the line from each pose to the next one is on a lane
  std::size_t point = 0;    // a pose more at a place where the body turns
  for (const navigation::Pose& pose : path) {
    if (!(pose.at == points[point]) && point + 1 < count) ++point;
    along.push_back(point + 1 < count && on_lane[point + 1]);
  }
  if (map_) NoteCuts(*map_, path, along);
  AddUncut(path, along);
  return Ok();
}

bool Explore::Fits(const navigation::CellMap& map, const navigation::Point& at) const {
  const double keep_m = robot_.radius_m() + kMapMarginM;
  const int cells = static_cast<int>(std::ceil(keep_m / map.resolution_m));
  const navigation::Cell middle = map.CellOf(at);
  for (int x = middle.x - cells; x <= middle.x + cells; ++x) {
    for (int y = middle.y - cells; y <= middle.y + cells; ++y) {
      const navigation::Cell cell{x, y, 0};
      if (!map.Has(cell) || map.blocked[map.IndexOf(cell)] == 0) continue;
      const navigation::Point centre = map.CentreOf(cell);
      if (std::hypot(centre.x_m - at.x_m, centre.y_m - at.y_m) < keep_m) return false;
    }
  }
  return true;
}

void Explore::NoteCuts(const navigation::CellMap& map, const navigation::Path& path,
                       const std::vector<bool>& on_lane) {
  std::vector<bool> fits;
  for (const navigation::Pose& pose : path) fits.push_back(Fits(map, pose.at));
  if (std::ranges::find(fits, false) == fits.end()) return;
  const auto cut = [&](std::size_t from, std::size_t to) {
    const auto first = static_cast<double>(uncut_ + from), end = static_cast<double>(uncut_ + to);
    if (!cuts_.empty() && cuts_.back() == first) {
      cuts_.back() = end;
    } else {
      cuts_.insert(cuts_.end(), {first, end});
    }
  };
  for (std::size_t from = 0; from < path.size();) {
    std::size_t to = from;
    double lane_m = 0;
    for (; to < path.size() && fits[to] == fits[from]; ++to) {
      const bool goes_on = to + 1 < path.size() && fits[to + 1] == fits[from];
      if (goes_on && on_lane[to]) lane_m += navigation::Distance(path[to].at, path[to + 1].at);
    }
    if (!fits[from] || lane_m < kLeastPieceM) cut(from, to);
    from = to;
  }
}

void Explore::AddUncut(const navigation::Path& path, const std::vector<bool>& on_lane) {
  std::vector<bool> is_cut;
  std::size_t cut = 0;  // in ascending order, from and to
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto index = static_cast<double>(uncut_ + i);
    while (cut + 1 < cuts_.size() && cuts_[cut + 1] <= index) cut += 2;
    is_cut.push_back(cut + 1 < cuts_.size() && cuts_[cut] <= index);
  }
  CountCuts(path, on_lane, is_cut);
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (is_cut[i]) {
      CloseArea();
      continue;
    }
    path_.push_back(path[i]);
    on_lane_.push_back(on_lane[i]);
  }
  CloseArea();
  uncut_ += path.size();
}

void Explore::CountCuts(const navigation::Path& path, const std::vector<bool>& on_lane,
                        const std::vector<bool>& is_cut) {
  double cut_m = 0;
  bool in_lane = false, has_rest = false;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool last = i + 1 == path.size();
    const bool cut = !last && (is_cut[i] || is_cut[i + 1]);
    if (cut) cut_m += navigation::Distance(path[i].at, path[i + 1].at);
    const bool lane = !last && on_lane[i];
    if (in_lane && !lane && !has_rest && plan_.lanes > 0) --plan_.lanes;
    has_rest = lane && ((in_lane && has_rest) || !cut);
    in_lane = lane;
  }
  cut_m_ += cut_m;
  plan_.length_m = std::max(plan_.length_m - cut_m, 0.0);
}

void Explore::CloseArea() {
  if (path_.empty()) return;
  on_lane_.back() = false;
  if (!last_of_areas_.empty() && last_of_areas_.back() == path_.size() - 1) return;
  last_of_areas_.push_back(path_.size() - 1);
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
    if (IndexOf(tick) == EndOf(IndexOf(tick)) && !BeginNextArea(tick)) return Finish(tick);
    if (!approaches_) BeginRest(tick);
  }
  if (approaches_) {
    const TravelStep step = Approach(tick);
    if (step.kind != Kind::kDone && step.kind != Kind::kPending) return After(tick, step);
  } else {
    const TravelStep step = travel_.Drive(tick.step);
    NoteProgress(tick);
    if (step.kind == Kind::kDone && !BeginNextArea(tick)) return Finish(tick);
    if (step.kind == Kind::kBlocked) {
      Skip(tick, step.why);
    } else if (step.kind != Kind::kPending && step.kind != Kind::kDone) {
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
  rest.insert(rest.end(), path_.begin() + static_cast<std::ptrdiff_t>(index),
              path_.begin() + static_cast<std::ptrdiff_t>(EndOf(index) + 1));
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

std::size_t Explore::EndOf(std::size_t index) const {
  return *std::ranges::lower_bound(last_of_areas_, index);
}

bool Explore::BeginNextArea(Tick& tick) {
  const std::size_t next = EndOf(IndexOf(tick)) + 1;
  if (next >= path_.size()) return false;
  SetIndex(tick, next);
  approaches_ = true;
  return true;
}

std::size_t Explore::Ahead(std::size_t index, double distance_m) const {
  const std::size_t end = EndOf(index);
  double passed_m = 0;
  while (index < end && passed_m < distance_m) {
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
  skill::Numbers parts = tick.data.Get<skill::Numbers>(kParts, {});
  const auto from = static_cast<double>(IndexOf(tick));
  if (!parts.empty() && parts.back() == from) {
    parts.back() = static_cast<double>(to);
  } else {
    parts.push_back(from);
    parts.push_back(static_cast<double>(to));
  }
  tick.data.Set(kParts, parts);
  SetIndex(tick, to == EndOf(to) && to + 1 < path_.size() ? to + 1 : to);
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

std::vector<coverage::Edge> Explore::Uncovered(const Tick& tick, bool at_end) const {
  std::vector<coverage::Edge> lines = plan_.lanes_left_out;
  const auto add = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < std::min(to, path_.size() - 1); ++i) {
      const navigation::Point &a = path_[i].at, &b = path_[i + 1].at;
      if (on_lane_[i] && !(a == b)) AddLine(lines, {{a.x_m, a.y_m}, {b.x_m, b.y_m}});
    }
  };
  const auto parts = tick.data.Get<skill::Numbers>(kParts, {});
  for (std::size_t i = 0; i + 1 < parts.size(); i += 2) {
    add(static_cast<std::size_t>(parts[i]), static_cast<std::size_t>(parts[i + 1]));
  }
  if (!at_end) add(IndexOf(tick), path_.size());
  return lines;
}

double Explore::ShareCovered(const std::vector<coverage::Edge>& uncovered) const {
  double lanes_m = LengthOf(plan_.lanes_left_out);
  for (std::size_t i = 0; i + 1 < path_.size(); ++i) {
    if (on_lane_[i]) lanes_m += navigation::Distance(path_[i].at, path_[i + 1].at);
  }
  return lanes_m > 0 ? std::clamp(1 - LengthOf(uncovered) / lanes_m, 0.0, 1.0) : 1;
}

Next Explore::AtEnd(Tick& tick, Next next) const {
  const bool succeeds = next.kind() == Next::Kind::kSucceed;
  const bool ends =
      succeeds || next.kind() == Next::Kind::kFail || next.kind() == Next::Kind::kCancel;
  if (!ends || !made_) return next;
  const bool at_end = succeeds || tick.data.Get(kAtEnd, false);
  const std::vector<coverage::Edge> uncovered = Uncovered(tick, at_end);
  tick.Detail("covered", 100 * ShareCovered(uncovered));
  std::vector<Points> strips;
  strips.reserve(uncovered.size());
  for (const coverage::Edge& lane : uncovered) {
    strips.push_back(StripOf(lane, tick.parameters.Number("lane_width"),
                             tick.parameters.Number("robot_radius")));
  }
  if (!strips.empty()) tick.Detail("uncovered", ListsText(strips));
  return next;
}

Next Explore::Finish(Tick& tick) const {
  const double skipped_m = tick.data.Number(kSkipped);
  tick.data.Set(kAtEnd, true);
  if (IsMostlyBlocked(tick)) return FailBlocked(tick);
  const double covered = ShareCovered(Uncovered(tick, true));
  std::string what = fmt::format("({:.1f} m in {} lanes", plan_.length_m, plan_.lanes);
  constexpr double kLeastSaidM = 0.05;
  if (cut_m_ >= kLeastSaidM) what += fmt::format(", {:.1f} m left out by the map", cut_m_);
  if (tick.data.Get(kLacksMap, false)) what += ", without a map";
  if (skipped_m > 0) what += fmt::format(", {:.1f} m blocked", skipped_m);
  if (plan_.cells_left_out > 0) {
    what += fmt::format(", {} parts cannot be reached", plan_.cells_left_out);
  }
  what += ")";
  if (covered < tick.parameters.Number("least_covered")) {
    return Next::Fail(
        fmt::format("Partial exploration: {:.0f} % of the lanes are covered {}; the "
                    "detail uncovered has the others, as a boundary",
                    100 * covered, what));
  }
  return Next::Succeed("Exploration completed " + what);
}

Next Explore::OnLimit(Tick& tick) {
  if (tick.state == initializing_) return AtEnd(tick, Next::Fail(WhyLost(tick)));
  if (tick.state == to_start_) {
    return AtEnd(tick, Next::Fail("Navigate timeout: the start was not reached"));
  }
  if (!made_) return Next::Fail("Timeout: the path was not computed");
  const double done = static_cast<double>(IndexOf(tick)) / static_cast<double>(path_.size());
  return AtEnd(tick, Next::Fail(fmt::format("Timeout: {:.0f} % of the path were explored; the "
                                            "detail uncovered has the others, as a boundary",
                                            100 * done)));
}

}  // namespace musher::skills
