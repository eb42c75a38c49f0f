#include "musher/controller/cyberdog/requests.hpp"

#include "musher/controller/cyberdog/numbers.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"

namespace musher::cyberdog {
namespace {

constexpr std::int32_t kKeptAlready = -1;  // as CyberDog answers

// std_srvs has no field for a code, so it is part of the sentence.
template <class Response>
Response Told(const Result<>& result) {
  if (result) return {true, ""};
  return {false, WithCode(result.error().message, result.error().code)};
}

std::string NoState(std::uint8_t number) {
  return std::to_string(number) + " is the number of no state";
}

}  // namespace

Requests::Requests(transport::Endpoints& endpoints, ControllerShell& shell,
                   PowerSaving& power_saving)
    : shell_(shell), power_saving_(power_saving) {
  ServeStates(endpoints);
  ServePower(endpoints);
}

void Requests::ServeStates(transport::Endpoints& endpoints) {
  endpoints.Hear<msg::UInt8>("machine_state_switch",
                             [this](const msg::UInt8& wanted) { OnSwitch(wanted.data); });
  endpoints.Serve<msg::MachineState>(
      "machine_state_switch_keep",
      [this](const auto& request, const KeepReply& reply) { OnKeep(request, reply); });
  endpoints.Serve<msg::Trigger>("machine_state_valget", [this](const auto&, const auto& reply) {
    reply({true, std::string(TextOf(shell_.machine().state))});
  });
  endpoints.Serve<msg::SetBool>("ota_state_switch", [this](const auto& request, const auto& reply) {
    event::PolicyRequested asked;
    asked.what = PolicyRequest::kOta;
    asked.enable = request.data;
    Ask(asked, [reply](const Result<>& result) { reply(Told<msg::SetBool::Response>(result)); });
  });
}

void Requests::ServePower(transport::Endpoints& endpoints) {
  const auto enable = [&](const char* name, PolicyRequest what) {
    endpoints.Serve<msg::SetBool>(name, [this, what](const auto& request, const auto& reply) {
      event::PolicyRequested asked;
      asked.what = what;
      asked.enable = request.data;
      Ask(asked, [reply](const Result<>& result) { reply(Told<msg::SetBool::Response>(result)); });
    });
  };
  const auto trigger = [&](const char* name, PolicyRequest what) {
    endpoints.Serve<msg::Trigger>(name, [this, what](const auto&, const auto& reply) {
      event::PolicyRequested asked;
      asked.what = what;
      Ask(asked, [reply](const Result<>& result) { reply(Told<msg::Trigger::Response>(result)); });
    });
  };
  enable("low_power_enable", PolicyRequest::kLowPowerSwitch);
  enable("low_power_onoff", PolicyRequest::kLowPowerStore);
  trigger("low_power_exit", PolicyRequest::kWakeUp);
  trigger("poweroff", PolicyRequest::kPowerOff);
  trigger("reboot", PolicyRequest::kReboot);
  endpoints.Serve<msg::Trigger>("low_power_switch_state", [this](const auto&, const auto& reply) {
    const bool on = shell_.machine().policy.low_power;
    reply({on, on ? "on" : "off"});
  });
  endpoints.Hear<msg::Bool>("dog_wakeup", [this](const msg::Bool&) { OnWakeWord(); });
}

void Requests::Ask(const event::PolicyRequested& asked, const ControllerShell::OnAnswer& done) {
  const bool to_a_state =
      asked.what == PolicyRequest::kSwitch || asked.what == PolicyRequest::kKeep;
  const bool urgent = asked.state == kTearDown || asked.state == kError;
  const bool calls_off = asked.what == PolicyRequest::kKeep && asked.ticks == 0;
  const bool leads_out = asked.what == PolicyRequest::kWakeUp ||
                         asked.what == PolicyRequest::kOta ||
                         (to_a_state && asked.state != kLowPower && !urgent && !calls_off);
  const PolicyState& policy = shell_.machine().policy;
  const bool refused = policy.keep || policy.level >= BatteryLevel::kLowPower;  // by the policy
  if (shell_.machine().state != kLowPower || !leads_out || refused) {
    return shell_.AskPolicy(asked, done);
  }
  power_saving_.Leave([this, asked, done](const Result<>& left) {
    if (!left) return done(left);
    shell_.AskPolicy(asked, done);
  });
}

void Requests::OnSwitch(std::uint8_t number) {
  const auto state = StateOfNumber(number);
  if (!state) {
    return shell_.Remark(kCodeParametersInvalid, "machine_state_switch: " + NoState(number));
  }
  event::PolicyRequested asked;
  asked.what = PolicyRequest::kSwitch;
  asked.state = *state;
  Ask(asked, [](const Result<>&) {});  // a refusal is in the journal
}

void Requests::OnKeep(const msg::MachineState::Request& request, const KeepReply& reply) {
  const bool kept = shell_.machine().policy.keep.has_value();
  const bool calls_off = kept && request.ticks == 0;  // whatever state it names
  const auto state = StateOfNumber(request.state);
  if (!state && !calls_off) {
    shell_.Remark(kCodeParametersInvalid, "machine_state_switch_keep: " + NoState(request.state));
    return reply({false, kCodeParametersInvalid});
  }
  event::PolicyRequested asked;
  asked.what = PolicyRequest::kKeep;
  asked.state = state.value_or(shell_.machine().state);
  asked.ticks = request.ticks;
  Ask(asked, [reply, kept](const Result<>& result) {
    if (result) return reply({true, kCodeOk});
    if (kept) return reply({true, kKeptAlready});
    reply({false, result.error().code});
  });
}

// Heard all day long; it means something to a robot that rests.
void Requests::OnWakeWord() {
  const State& state = shell_.machine().state;
  if (state == kActive || state == kProtected || power_saving_.leaving()) return;
  event::PolicyRequested asked;
  asked.what = PolicyRequest::kWakeUp;
  Ask(asked, [](const Result<>&) {});  // a refusal is in the journal
}

}  // namespace musher::cyberdog
