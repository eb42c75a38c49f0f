#include "musher/modules/motion/motion_command.hpp"

#include <algorithm>
#include <cmath>

#include "musher/base/words.hpp"
#include "musher/modules/motion/motion_source.hpp"
#include "musher/modules/motion/user_gait.hpp"

namespace musher::motion {
namespace {

constexpr std::int8_t kAllFeet = 15;
constexpr std::array<float, 2> kStepHeight = {0.05F, 0.05F};  // m, front and rear
// What the board of a CyberDog 2 takes.
constexpr float kMostTurnRad = 0.45F;  // roll, pitch and yaw of the body
constexpr float kLowestBodyM = 0.1F, kHighestBodyM = 0.32F;
constexpr float kHighestWalkStepM = 0.06F, kHighestStepM = 0.08F;
constexpr std::int64_t kGraceMs = 500;
constexpr std::int64_t kOpenTimeMs = 500;  // of a motion that does not end by itself

struct Field {
  const char* name;
  const std::vector<float>* values;
  std::size_t length;
};

std::array<Field, 7> FieldsOf(const MotionArguments& a) {
  return {{{"vel_des", &a.vel_des, 3},
           {"rpy_des", &a.rpy_des, 3},
           {"pos_des", &a.pos_des, 3},
           {"acc_des", &a.acc_des, 6},
           {"ctrl_point", &a.ctrl_point, 3},
           {"foot_pose", &a.foot_pose, 6},
           {"step_height", &a.step_height, 2}}};
}

template <std::size_t N>
std::array<float, N> Fixed(const std::vector<float>& values) {
  std::array<float, N> fixed{};
  if (values.size() == N) std::copy(values.begin(), values.end(), fixed.begin());
  return fixed;
}

BodyCommand UnlimitedCommand(const Motion& motion, const MotionArguments& arguments) {
  BodyCommand command;
  command.id = motion.id;
  command.mode = motion.mode;
  command.gait = motion.gait;
  command.contact = arguments.contact == 0 ? kAllFeet : static_cast<std::int8_t>(arguments.contact);
  command.vel = Fixed<3>(arguments.vel_des);
  command.rpy = Fixed<3>(arguments.rpy_des);
  command.pos = Fixed<3>(arguments.pos_des);
  command.acc = Fixed<6>(arguments.acc_des);
  command.ctrl_point = Fixed<3>(arguments.ctrl_point);
  command.foot_pose = Fixed<6>(arguments.foot_pose);
  command.step_height =
      arguments.step_height.empty() ? kStepHeight : Fixed<2>(arguments.step_height);
  command.value = arguments.value;
  command.duration_ms = arguments.duration_ms;
  return command;
}

// A height of zero is the board's own. In other motions than these the height is relative.
void LimitHeight(const Motion& motion, float& height_m) {
  const bool is_above_ground = motion.limit || motion.id == kForceControl;
  if (is_above_ground && height_m != 0)
    height_m = std::clamp(height_m, kLowestBodyM, kHighestBodyM);
}

}  // namespace

bool AllFinite(const MotionArguments& arguments) {
  for (const Field& field : FieldsOf(arguments)) {
    for (const float value : *field.values) {
      if (!std::isfinite(value)) return false;
    }
  }
  return true;
}

std::optional<std::string> WrongLength(const MotionArguments& arguments) {
  for (const Field& field : FieldsOf(arguments)) {
    const std::size_t size = field.values->size();
    if (size == 0 || size == field.length) continue;
    return std::string(field.name) + " has " + Counted(size, "value") + " instead of " +
           std::to_string(field.length);
  }
  return std::nullopt;
}

std::optional<std::string> WrongDuration(const Motion& motion, std::int32_t duration_ms) {
  const std::string given = std::to_string(duration_ms) + " ms given";
  if (motion.min_exec_time_ms > 0 && duration_ms != 0) {
    return "it has its own duration; 0 expected, " + given;
  }
  if (motion.min_exec_time_ms < 0 && duration_ms <= 0) {
    return "it needs a duration of more than 0 ms; " + given;
  }
  if (duration_ms < 0) return "its duration can't be negative; " + given;
  return std::nullopt;
}

std::optional<std::string> WrongContact(std::int32_t contact) {
  if (contact >= 0 && contact <= kAllFeet) return std::nullopt;
  return "contact must be from 0 to 15, it is " + std::to_string(contact);
}

BodyCommand MakeCommand(const Motion& motion, const MotionArguments& arguments) {
  BodyCommand command = UnlimitedCommand(motion, arguments);
  for (std::size_t i = 0; motion.limit && i < command.vel.size(); ++i) {
    const float most = motion.limit->at(i);
    command.vel.at(i) = std::clamp(command.vel.at(i), -most, most);
  }
  if (PlaysUserGait(motion)) return command;
  for (float& angle_rad : command.rpy) {
    angle_rad = std::clamp(angle_rad, -kMostTurnRad, kMostTurnRad);
  }
  LimitHeight(motion, command.pos[2]);
  for (float& height_m : command.step_height) {
    height_m = std::clamp(height_m, 0.0F, motion.limit ? kHighestWalkStepM : kHighestStepM);
  }
  return command;
}

std::string LimitedArrays(const Motion& motion, const MotionArguments& arguments) {
  const BodyCommand limited = MakeCommand(motion, arguments);
  const BodyCommand requested = UnlimitedCommand(motion, arguments);
  std::string names;
  const auto note = [&names](const char* name, bool is_limited) {
    if (is_limited) names += (names.empty() ? "" : ", ") + std::string(name);
  };
  note("vel_des", limited.vel != requested.vel);
  note("rpy_des", limited.rpy != requested.rpy);
  note("pos_des", limited.pos != requested.pos);
  note("step_height", limited.step_height != requested.step_height);
  return names;
}

Duration ExecutionTime(const Motion& motion, std::int32_t duration_ms) {
  const std::int64_t duration{duration_ms};
  if (motion.min_exec_time_ms > 0) return Milliseconds(motion.min_exec_time_ms);
  if (motion.min_exec_time_ms < 0) return Milliseconds(duration + kGraceMs);
  return Milliseconds(duration == 0 ? kOpenTimeMs : 2 * duration);
}

std::string SourceName(std::int32_t source) {
  switch (source) {
    case kFromMachine:
      return "FSM";
    case kFromDebug:
      return "Debug";
    case kFromApp:
      return "App";
    case kFromAudio:
      return "Audio";
    case kFromVision:
      return "Vis";
    case kFromBluetooth:
      return "BluTele";
    case kFromAlgorithm:
      return "Algo";
    default:
      return "source " + std::to_string(source);
  }
}

}  // namespace musher::motion
