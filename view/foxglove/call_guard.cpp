#include "musher/view/foxglove/call_guard.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include "musher/messages/action_msgs/cancel_goal.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/musher_msgs/tree.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/service.hpp"

namespace musher::view::foxglove {
namespace {

constexpr std::array<std::string_view, 8> kReading = {
    "musher_msgs::srv::dds_::GetStatus_",       "musher_msgs::srv::dds_::GetPlan_",
    "musher_msgs::srv::dds_::GetSwitch_",       "musher_msgs::srv::dds_::GetHistory_",
    "musher_msgs::srv::dds_::GetCapabilities_", "musher_msgs::srv::dds_::GetBehavior_",
    "musher_msgs::srv::dds_::GetTree_",         "lifecycle_msgs::srv::dds_::GetState_"};

// Calls `use` with a request of the service of that type, if its requests name a machine.
template <class Use>
bool WithNamedMachine(std::string_view type, Use use) {
  const auto is = [&]<class S>(std::optional<S> /*service*/) {
    if (type != S::kTypeName) return false;
    use(typename S::Request{});
    return true;
  };
  return is(std::optional<msg::SetState>()) || is(std::optional<msg::RestartActuator>()) ||
         is(std::optional<msg::ReleaseEmergencyStop>()) ||
         is(std::optional<msg::RequestPolicy>()) || is(std::optional<msg::GetPlan>()) ||
         is(std::optional<msg::GetSwitch>()) || is(std::optional<msg::GetHistory>());
}

// The command of applications, which some take in any case.
bool IsStopCommand(std::string_view text) {
  return std::ranges::equal(text, std::string_view("STOP"), {},
                            [](unsigned char c) { return std::toupper(c); });
}

// The request, if it is one of that service.
template <class S>
std::optional<typename S::Request> RequestIn(std::string_view type,
                                             std::span<const std::byte> request) {
  typename S::Request typed;
  if (type != S::kTypeName || !transport::internal::DecodeEnvelope(request, typed)) return {};
  return typed;
}

// The message, if it is of that type.
template <class M>
std::optional<M> MessageIn(std::string_view type, std::span<const std::byte> message) {
  return type == M::kTypeName ? msg::Decode<M>(message) : std::nullopt;
}

// A transition is named by its label, or, without one, by its id.
bool Ends(const msg::Transition& transition) {
  constexpr std::uint8_t kConfigure = 1;
  constexpr std::uint8_t kActivate = 3;
  if (transition.label.empty()) return transition.id != kConfigure && transition.id != kActivate;
  return transition.label == "cleanup" || transition.label == "deactivate" ||
         transition.label == "shutdown";
}

// As the controller decides it of a request that may be late. Whether a keep of no time ends a stay
// is not known here.
bool LeadsOut(const msg::RequestPolicy::Request& policy) {
  const bool low_power = policy.request == "low-power" || policy.request == "low-power-store";
  return policy.request == "wake-up" || policy.request == "ota" || policy.request == "keep" ||
         (low_power && !policy.enable);
}

msg::Bytes WithId(const msg::RequestId& id, std::span<const std::byte> body) {
  // The id's 16 bytes leave the alignment of what follows as it is.
  msg::Bytes request = msg::Encode(id);
  request.insert(request.end(), body.begin(), body.end());
  return request;
}

}  // namespace

bool IsReading(std::string_view type) {
  return std::find(kReading.begin(), kReading.end(), type) != kReading.end();
}

bool NamesMachine(std::string_view type) {
  return WithNamedMachine(type, [](const auto& /*request*/) {});
}

bool IsStopping(std::string_view type, std::span<const std::byte> request) {
  if (type == msg::CancelSkill::kTypeName || type == msg::CancelGoal::kTypeName) return true;
  if (type != msg::PauseSkill::kTypeName) return false;
  msg::PauseSkill::Request pause;
  return transport::internal::DecodeEnvelope(request, pause) && pause.pause;
}

bool IsNeverLate(std::string_view type, std::span<const std::byte> request,
                 const SwitchLowers& only_lowers) {
  if (IsReading(type) || IsStopping(type, request)) return true;
  if (const auto to = RequestIn<msg::SetState>(type, request)) {
    return only_lowers(to->target, to->actuator);
  }
  if (const auto policy = RequestIn<msg::RequestPolicy>(type, request)) return !LeadsOut(*policy);
  if (const auto change = RequestIn<msg::ChangeState>(type, request)) {
    return Ends(change->transition);
  }
  if (const auto motion = RequestIn<msg::MotionResultCmd>(type, request)) {
    return motion->motion_id == msg::MotionId::kEmergencyStop;
  }
  if (const auto custom = RequestIn<msg::MotionCustomCmd>(type, request)) {
    return custom->cmd_type == msg::MotionCustomCmd::kExecution &&
           custom->motion_id == msg::MotionId::kEmergencyStop;
  }
  if (const auto program = RequestIn<msg::ManageProgram>(type, request)) {
    return program->operation != msg::ManageProgram::kRun;
  }
  const auto sent = RequestIn<msg::SendCommand>(type, request);
  return sent && IsStopCommand(sent->command);
}

bool IsMessageNeverLate(std::string_view type, std::span<const std::byte> message) {
  if (const auto text = MessageIn<msg::String>(type, message)) return IsStopCommand(text->data);
  if (const auto servo = MessageIn<msg::MotionServoCmd>(type, message)) {
    return servo->motion_id == msg::MotionId::kEmergencyStop ||
           servo->cmd_type == msg::MotionServoCmd::kEnd;
  }
  if (const auto stamped = MessageIn<msg::TwistStamped>(type, message)) {
    return stamped->twist == msg::Twist();
  }
  const auto twist = MessageIn<msg::Twist>(type, message);
  return twist && *twist == msg::Twist();
}

Result<msg::Bytes> RequestFor(const MachineIdentity& machine, std::string_view type,
                              const msg::RequestId& id, std::span<const std::byte> body) {
  Result<msg::Bytes> made = WithId(id, body);
  if (machine.name.empty() && machine.id.empty()) return made;
  const msg::Bytes request = made.value();
  WithNamedMachine(type, [&](auto typed) {
    if (!transport::internal::DecodeEnvelope(std::span<const std::byte>(request), typed)) {
      made = Error{kCodeParametersInvalid, "the request is malformed"};
      return;
    }
    const MachineIdentity named{typed.machine, typed.machine_id};
    if (!SameMachine(named, machine)) {
      if (IsReading(type)) return;
      made = Error{kCodeTargetBusy, "the request names " + MachineText(named) + ", but " +
                                        MachineText(machine) + " is followed. Nothing was done"};
      return;
    }
    typed.machine = machine.name;
    typed.machine_id = machine.id;
    made = transport::internal::EncodeEnvelope(id, typed);
  });
  return made;
}

}  // namespace musher::view::foxglove
