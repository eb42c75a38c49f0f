#include "musher/cyberdog/requests.hpp"

#include "musher/cyberdog/interfaces.hpp"
#include "musher/cyberdog/numbers.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"

namespace musher::cyberdog {
namespace {

constexpr std::int32_t kKeptAlready = -1;  // as in CyberDog

// std_srvs has no field for a code, so the message contains it.
template <class Response>
Response ReplyFrom(const Result<>& result) {
  if (result) return {true, ""};
  return {false, WithCode(result.error().message, result.error().code)};
}

std::string NoState(std::uint8_t number) {
  return std::to_string(number) + " is not the number of a state";
}

}  // namespace

Requests::Requests(transport::Endpoints& endpoints, ControllerShell& shell,
                   PowerSaving& power_saving)
    : node_(endpoints.node()), shell_(shell), power_saving_(power_saving) {
  ServeStates(endpoints);
  ServePower(endpoints);
}

void Requests::ServeStates(transport::Endpoints& endpoints) {
  endpoints.SubscribeWithInfo<msg::UInt8>(
      kMachineStateSwitch,
      [this](const msg::UInt8& wanted, const transport::SampleInfo& info) {
        OnSwitch(wanted.data, info.participant);
      },
      {});
  endpoints.Serve<msg::MachineState>(
      kMachineStateSwitchKeep,
      [this](const auto& request, const KeepReply& reply, transport::ParticipantId caller) {
        OnKeep(request, reply, caller);
      });
  endpoints.Serve<msg::Trigger>(kMachineStateValget, [this](const auto&, const auto& reply) {
    reply({true, std::string(TextOf(shell_.machine().state))});
  });
  ServeSetBool(endpoints, kOtaStateSwitch, PolicyRequest::kOta);
}

void Requests::ServeSetBool(transport::Endpoints& endpoints, const char* name, PolicyRequest what) {
  endpoints.Serve<msg::SetBool>(
      name, [this, what](const auto& request, const auto& reply, transport::ParticipantId caller) {
        event::PolicyRequested requested;
        requested.what = what;
        requested.enable = request.data;
        requested.by = NameOf(caller);
        Request(requested, caller, [reply](const Result<>& result) {
          reply(ReplyFrom<msg::SetBool::Response>(result));
        });
      });
}

void Requests::ServePower(transport::Endpoints& endpoints) {
  const auto trigger = [&](const char* name, PolicyRequest what) {
    endpoints.Serve<msg::Trigger>(
        name, [this, what](const auto&, const auto& reply, transport::ParticipantId caller) {
          event::PolicyRequested requested;
          requested.what = what;
          requested.by = NameOf(caller);
          Request(requested, caller, [reply](const Result<>& result) {
            reply(ReplyFrom<msg::Trigger::Response>(result));
          });
        });
  };
  ServeSetBool(endpoints, kLowPowerEnable, PolicyRequest::kLowPowerSwitch);
  ServeSetBool(endpoints, kLowPowerOnoff, PolicyRequest::kLowPowerStore);
  trigger(kLowPowerExit, PolicyRequest::kWakeUp);
  trigger(kPoweroff, PolicyRequest::kPowerOff);
  trigger(kReboot, PolicyRequest::kReboot);
  endpoints.Serve<msg::Trigger>(kLowPowerSwitchState, [this](const auto&, const auto& reply) {
    const bool on = shell_.machine().policy.low_power;
    reply({on, on ? "on" : "off"});
  });
  endpoints.SubscribeWithInfo<msg::Bool>(
      kDogWakeup,
      [this](const msg::Bool&, const transport::SampleInfo& info) { OnWakeWord(info.participant); },
      {});
}

void Requests::Request(const event::PolicyRequested& requested, transport::ParticipantId caller,
                       const ControllerShell::OnAnswer& done) {
  if (const auto other = shell_.MeantForAnother(caller)) {
    shell_.Remark(other->code, (requested.by.empty() ? "" : requested.by + ": ") + other->message);
    return done(*other);
  }
  const bool to_a_state =
      requested.what == PolicyRequest::kSwitch || requested.what == PolicyRequest::kKeep;
  const bool urgent = requested.state == kTearDown || requested.state == kError;
  // Without a stay that it ends, a keep of no time is a switch.
  const bool cancels = requested.what == PolicyRequest::kKeep && requested.ticks == 0 &&
                       shell_.machine().policy.keep.has_value();
  const bool leads_out = requested.what == PolicyRequest::kWakeUp ||
                         requested.what == PolicyRequest::kOta ||
                         (to_a_state && requested.state != kLowPower && !urgent && !cancels);
  const auto late =
      to_a_state ? shell_.MayBeLate(requested.state, std::nullopt) : shell_.MayBeLate();
  if (late && (leads_out || WakesUp(requested.what, requested.enable))) {
    shell_.RecordLate(requested, *late);
    return done(*late);
  }
  const PolicyState& policy = shell_.machine().policy;
  const bool refused = policy.keep || policy.level >= BatteryLevel::kLowPower;  // by the policy
  if (shell_.machine().state != kLowPower || !leads_out || refused) {
    return shell_.SendPolicyRequest(requested, done);
  }
  power_saving_.Leave([this, requested, done](const Result<>& left) {
    if (!left) return done(left);
    const Machine& machine = shell_.machine();
    // The board takes seconds: what has switched the machine since then is newer.
    if (machine.state != kLowPower && !machine.current) {
      return done(
          Error{kCodeStateInvalid, "the machine was switched to " + machine.state + " meanwhile"});
    }
    shell_.SendPolicyRequest(requested, done);
  });
}

void Requests::OnSwitch(std::uint8_t number, transport::ParticipantId caller) {
  const auto state = StateOfNumber(number);
  if (!state) {
    return shell_.Remark(kCodeParametersInvalid,
                         std::string(kMachineStateSwitch) + ": " + NoState(number));
  }
  event::PolicyRequested requested;
  requested.what = PolicyRequest::kSwitch;
  requested.state = *state;
  requested.by = NameOf(caller);
  Request(requested, caller, [](const Result<>&) {});  // a refusal is in the journal
}

void Requests::OnKeep(const msg::MachineState::Request& request, const KeepReply& reply,
                      transport::ParticipantId caller) {
  const bool kept = shell_.machine().policy.keep.has_value();
  const bool cancels = kept && request.ticks == 0;  // in whichever state
  const auto state = StateOfNumber(request.state);
  if (!state && !cancels) {
    shell_.Remark(kCodeParametersInvalid,
                  std::string(kMachineStateSwitchKeep) + ": " + NoState(request.state));
    return reply({false, kCodeParametersInvalid});
  }
  event::PolicyRequested requested;
  requested.what = PolicyRequest::kKeep;
  requested.state = state.value_or(shell_.machine().state);
  requested.ticks = request.ticks;
  requested.by = NameOf(caller);
  Request(requested, caller, [reply, kept](const Result<>& result) {
    if (result) return reply({true, kCodeOk});
    if (kept) return reply({true, kKeptAlready});
    reply({false, result.error().code});
  });
}

// Received all day long; only a resting robot wakes up by it.
void Requests::OnWakeWord(transport::ParticipantId caller) {
  const State& state = shell_.machine().state;
  if (state == kActive || state == kProtected || power_saving_.leaving()) return;
  event::PolicyRequested requested;
  requested.what = PolicyRequest::kWakeUp;
  requested.by = "the wake word";
  Request(requested, caller, [](const Result<>&) {});  // a refusal is in the journal
}

}  // namespace musher::cyberdog
