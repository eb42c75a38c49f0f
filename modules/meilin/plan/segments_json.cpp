#include "musher/modules/meilin/plan/segments_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "musher/modules/meilin/plan/action_sequence.hpp"
#include "musher/modules/meilin/plan/json_reader.hpp"

namespace musher::meilin {
namespace {

struct OldType {
  std::string_view name;
  double speed_m_s = 0;  // 0: the segment drives to no pose
  double timeout_s = 30;
  bool waits = true;  // for the end of the arm
  int arm = 0;        // commands of the actions
  int spear = 0;
};

constexpr Cell kOutside{-1, -1};
constexpr std::string_view kClimbType = "CLIMB";
constexpr int kClimbUp = 1;  // values of climb_mode
constexpr int kClimbDown = 2;
constexpr int kSafePose = 7;    // an arm command of old plans
constexpr int kHighestArm = 6;  // that the arm's server takes
constexpr int kHighestOldArm = 8;

constexpr std::array<OldType, 14> kOldTypes = {{
    {"SPEAR_PREP", 0.4, 30, true, 0, 1},
    {"SPEAR_GRASP", 0, 5, true, 0, 2},
    {"ALIGN", 0.4, 30, true, 0, 0},
    {"DOCK", 0, 10, true, 0, 3},
    {"MOVE2", 0.5, 30, true, 0, 0},
    {"GRASP", 0, 30, true, 1, 0},
    {kClimbType, 0.4, 30, true, 0, 0},
    {"STORE1", 0, 30, false, 2, 0},
    {"STORE2", 0, 30, false, 3, 0},
    {"EXIT", 0.6, 30, true, kSafePose, 0},
    {"FINAL_MOVE2", 0.4, 30, true, 0, 0},
    {"PLACE_MID", 0, 30, true, 5, 0},
    {"PLACE_HIGH", 0, 30, true, 6, 0},
    {"FINISH", 0, 30, true, kSafePose, 0},
}};

constexpr double kFarthestM = 1000;
constexpr double kLongestS = 3600;
constexpr double kHighestMm = 2000;

void ReadTarget(JsonObject& segment, const nlohmann::json& value, JsonFaults& faults, Segment& to) {
  JsonObject target(value, segment.PathOf("move_target"), faults);
  target.Require("x", "metres");
  target.Require("y", "metres");
  to.target_x = target.Number("x", -kFarthestM, kFarthestM).value_or(0);
  to.target_y = target.Number("y", -kFarthestM, kFarthestM).value_or(0);
  to.target_yaw = target.Number("yaw", -100, 100).value_or(0);
  target.RefuseOthers();
}

Segment ReadSegment(const nlohmann::json& value, int index, JsonFaults& faults,
                    std::vector<std::string>& warnings) {
  Segment to;
  to.index = index;
  JsonObject segment(value, fmt::format("segments[{}]", index), faults);
  segment.Require("segment_type", "the type of the segment, as \"ALIGN\"");
  const auto type = segment.Choice("segment_type", OldSegmentTypes());
  const OldType defaults = type ? kOldTypes.at(*type) : OldType{};
  to.segment_type = defaults.name;
  to.debug_name = fmt::format("{} {}", defaults.name, index);
  to.spear_command = defaults.spear;
  const nlohmann::json* target = segment.Get("move_target");
  if (target != nullptr) ReadTarget(segment, *target, faults, to);
  if (target == nullptr && defaults.speed_m_s > 0) {
    segment.Fault("move_target", fmt::format("missing, {} drives to a pose", defaults.name));
  }
  to.max_speed = segment.Number("max_speed", 0.01, 5)
                     .value_or(defaults.speed_m_s > 0 ? defaults.speed_m_s : to.max_speed);
  to.timeout_sec = segment.Number("timeout_sec", 0, kLongestS).value_or(defaults.timeout_s);
  to.suspension_timeout_sec =
      segment.Number("suspension_timeout_sec", 0, kLongestS).value_or(to.suspension_timeout_sec);
  const auto mode = segment.Choice("climb_mode", {"UP", "DOWN", "RECOVER"});
  if (mode) to.climb_mode = static_cast<int>(*mode) + 1;
  const auto direction =
      segment.Choice("climb_direction", {"FORWARD", "LEFT", "RIGHT", "BACKWARD"});
  if (direction) to.climb_direction = static_cast<int>(*direction);
  if (defaults.name == kClimbType) segment.Require("climb_mode", "UP, DOWN or RECOVER");
  to.climb_height = segment.Number("climb_height", 0, kHighestMm).value_or(0);
  to.height_diff = segment.Number("height_diff", -kHighestMm, kHighestMm).value_or(0);
  to.arm_command = segment.Integer("arm_command", 0, kHighestOldArm).value_or(defaults.arm);
  to.wait_result = segment.Bool("wait_result").value_or(defaults.waits);
  segment.RefuseOthers();
  if (to.arm_command > kHighestArm) {
    warnings.push_back(fmt::format("{}: the arm rejects {}, which is above {}",
                                   segment.PathOf("arm_command"), to.arm_command, kHighestArm));
  }
  return to;
}

}  // namespace

std::vector<std::string_view> OldSegmentTypes() {
  std::vector<std::string_view> names;
  names.reserve(kOldTypes.size());
  for (const OldType& type : kOldTypes) names.push_back(type.name);
  return names;
}

SegmentsReading ReadSegmentsJson(std::string_view text) {
  SegmentsReading reading;
  JsonFaults faults;
  const auto document = ParseJson(text, faults);
  if (document) {
    JsonObject plan(*document, "", faults);
    reading.stage = plan.String("stage").value_or("");
    reading.plan_id = plan.String("plan_id").value_or("");
    plan.Require("segments", "an array of segments");
    const nlohmann::json* segments = plan.Get("segments");
    plan.RefuseOthers();
    if (segments != nullptr && !segments->is_array()) {
      plan.Fault("segments", fmt::format("expected an array, found {}", JsonTypeName(*segments)));
    } else if (segments != nullptr && segments->empty()) {
      plan.Fault("segments", "a plan has at least one segment");
    } else if (segments != nullptr && segments->size() > kMostSteps) {
      plan.Fault("segments",
                 fmt::format("{} segments, expected at most {}", segments->size(), kMostSteps));
    } else if (segments != nullptr) {
      int index = 0;
      for (const nlohmann::json& segment : *segments) {
        reading.segments.push_back(ReadSegment(segment, index++, faults, reading.warnings));
      }
    }
  }
  reading.faults = faults.list();
  if (!reading.faults.empty()) reading.segments.clear();
  if (reading.ok()) reading.text = document->dump(-1, ' ', true);
  return reading;
}

namespace {

double HeightAt(const Grid& grid, Point2 at) {
  const std::optional<Cell> cell = grid.CellAt(at);
  return cell ? grid.HeightMm(*cell) : 0;
}

bool Climbs(const Segment& segment) {
  return segment.segment_type == kClimbType &&
         (segment.climb_mode == kClimbUp || segment.climb_mode == kClimbDown);
}

std::string WhyNoClimb(const Segment& segment, const Grid& grid, double tolerance_mm, Point2 from,
                       Point2 to) {
  const Cell here = grid.CellAt(from).value_or(kOutside);
  const Cell there = grid.CellAt(to).value_or(kOutside);
  const bool inside = IsInside(here) && IsInside(there);
  const auto way = inside ? DirectionTo(here, there) : std::nullopt;
  if (!way) {
    return fmt::format(
        "the way from x {:.2f} m, y {:.2f} m to x {:.2f} m, y {:.2f} m is not between "
        "two cells of the field that share an edge",
        from.x_m, from.y_m, to.x_m, to.y_m);
  }
  const double step_mm = HeightAt(grid, to) - HeightAt(grid, from);
  const double expected_mm = segment.climb_mode == kClimbUp ? step_mm : -step_mm;
  const bool any = segment.climb_height == 0;
  if (expected_mm <= tolerance_mm ||
      (!any && std::abs(expected_mm - segment.climb_height) > tolerance_mm)) {
    return fmt::format("{}{}, and from {} to {} it is {:g} mm {}",
                       segment.climb_mode == kClimbUp ? "UP" : "DOWN",
                       any ? "" : fmt::format(" by {:g} mm", segment.climb_height), CellText(here),
                       CellText(there), std::abs(step_mm), step_mm < 0 ? "down" : "up");
  }
  const Direction body = NearestDirection(NormalizeYaw(YawOf(*way) - segment.target_yaw));
  if (CodeOf(body) == segment.climb_direction) return "";
  return fmt::format(
      "climb_direction is {}, and with a yaw of {:.2f} rad the way from {} to {} is {}",
      DirectionText(kDirections.at(static_cast<std::size_t>(segment.climb_direction))),
      segment.target_yaw, CellText(here), CellText(there), DirectionText(body));
}

std::string WhyNoDrive(const Grid& grid, double tolerance_mm, Point2 from, Point2 to) {
  const double height_mm = HeightAt(grid, from);
  if (const auto other = grid.OtherHeightOnLine(from, to, height_mm, tolerance_mm)) {
    return fmt::format(
        "the straight way from x {:.2f} m, y {:.2f} m, {:g} mm high, to x {:.2f} m, "
        "y {:.2f} m crosses {}, which has {} mm",
        from.x_m, from.y_m, height_mm, to.x_m, to.y_m, CellText(*other), grid.HeightMm(*other));
  }
  if (grid.CellAt(to) || height_mm <= tolerance_mm) return "";
  return fmt::format("the way to x {:.2f} m, y {:.2f} m leads off the field, from {:g} mm", to.x_m,
                     to.y_m, height_mm);
}

}  // namespace

bool DrivesToPose(std::string_view type) {
  const auto* found = std::ranges::find(kOldTypes, type, &OldType::name);
  return found != kOldTypes.end() && found->speed_m_s > 0;
}

bool IsClimbTo(const Segment& segment, const Grid& grid, Point2 at) {
  const auto to = grid.CellAt({segment.target_x, segment.target_y});
  return Climbs(segment) && to && grid.CellAt(at) == to;
}

std::string WhyNoWay(const std::vector<Segment>& segments, const Grid& grid, double tolerance_mm,
                     const std::optional<Point2>& start) {
  std::optional<Point2> at = start;
  for (const Segment& segment : segments) {
    if (!DrivesToPose(segment.segment_type)) continue;
    const Point2 to{segment.target_x, segment.target_y};
    const std::string why = !at               ? ""
                            : Climbs(segment) ? WhyNoClimb(segment, grid, tolerance_mm, *at, to)
                                              : WhyNoDrive(grid, tolerance_mm, *at, to);
    if (!why.empty()) {
      return fmt::format("segments[{}], {}: {}", segment.index, segment.segment_type, why);
    }
    at = to;
  }
  return "";
}

}  // namespace musher::meilin
