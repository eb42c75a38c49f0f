#include "musher/modules/motion/motion_sequence.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "musher/modules/motion/motion_code.hpp"
#include "musher/modules/motion/motion_wire.hpp"
#include "musher/modules/motion/user_gait.hpp"

namespace musher::motion {
namespace {

Error UnSupport(const std::string& why) {
  return {MotionCode(KeyCode::kUnSupport), why};
}
Error Undefined(const std::string& why) {
  return {MotionCode(MotionKey::kSequenceDefinition), why};
}

Result<MotionRequest> RequestOf(const msg::MotionSequencePace& pace, std::size_t number) {
  const std::string which = "pace " + std::to_string(number) + ": ";
  if (pace.duration <= 0 || pace.duration > std::numeric_limits<std::int32_t>::max()) {
    return Undefined(which + "its duration must be more than 0 ms, it is " +
                     std::to_string(pace.duration));
  }
  if (!IsWalk(pace)) {
    return UnSupport(which +
                     "this board walks by speed (twist x, y and yaw) and duration; it takes no "
                     "centroid, feet, weights or friction");
  }
  MotionRequest requested{kUserTrot, {}};
  requested.arguments.vel_des = {static_cast<float>(pace.twist.linear.x),
                                 static_cast<float>(pace.twist.linear.y),
                                 static_cast<float>(YawRateOf(pace.twist))};
  requested.arguments.duration_ms = static_cast<std::int32_t>(pace.duration);
  return requested;
}

}  // namespace

Result<MotionRequests> RequestsOf(const MotionTable& table,
                                  const msg::MotionQueueCustomCmd::Request& queue) {
  MotionRequests requests;
  for (const msg::MotionCustomCommand& command : queue.cmds) {
    const Motion* motion = table.Find(command.mode, command.gait_id);
    if (motion == nullptr) {
      return UnSupport("command " + std::to_string(requests.size() + 1) +
                       ": there is no motion of mode " + std::to_string(command.mode) +
                       " with gait " + std::to_string(command.gait_id));
    }
    requests.push_back({motion->id, FromWire(command)});
  }
  return requests;
}

Result<MotionRequests> RequestsOf(const msg::MotionSequenceShow::Request& sequence) {
  const bool walks_only = std::all_of(sequence.pace_list.begin(), sequence.pace_list.end(), IsWalk);
  if (HasUserGait(sequence) && walks_only) {
    return UnSupport(
        "gaits by foot and TOML definitions need a motion board on LCM, which takes them; this one "
        "plays motions of its table and paces of speed and duration");
  }
  if (sequence.pace_list.empty()) {
    if (sequence.motion_id == kEmergencyStop) {
      return Undefined("the sequence has no paces and names no motion");
    }
    MotionRequest requested{sequence.motion_id, {}};
    if (sequence.duration < 0 || sequence.duration > std::numeric_limits<std::int32_t>::max()) {
      return Undefined("its duration can't be " + std::to_string(sequence.duration) + " ms");
    }
    requested.arguments.duration_ms = static_cast<std::int32_t>(sequence.duration);
    return MotionRequests{requested};
  }
  MotionRequests requests;
  for (const msg::MotionSequencePace& pace : sequence.pace_list) {
    const auto requested = RequestOf(pace, requests.size() + 1);
    if (!requested) return requested.error();
    requests.push_back(requested.value());
  }
  return requests;
}

Result<MotionRequests> RequestsOf(const msg::MotionCustomCmd::Request& custom) {
  if (custom.cmd_type == msg::MotionCustomCmd::kDefinition) {
    return UnSupport(
        "this board plays the motions of its table; one on LCM takes definitions of gaits");
  }
  if (custom.cmd_type != msg::MotionCustomCmd::kExecution) {
    return Error{MotionCode(KeyCode::kParametersInvalid),
                 "cmd_type must be 0 or 1, it is " + std::to_string(custom.cmd_type)};
  }
  return MotionRequests{{custom.motion_id, {}}};
}

}  // namespace musher::motion
