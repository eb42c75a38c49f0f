#include "musher/modules/meilin/plan/segments_json.hpp"

#include <fmt/format.h>

#include <array>
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
    {"CLIMB", 0.4, 30, true, 0, 0},
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
  if (defaults.name == "CLIMB") segment.Require("climb_mode", "UP, DOWN or RECOVER");
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
  return reading;
}

}  // namespace musher::meilin
