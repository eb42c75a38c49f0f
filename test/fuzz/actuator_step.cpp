// One actuator and any senders of commands. A sender that has not announced itself as a controller
// changes nothing. For every input epochs and numbers do not fall, an emergency stop holds, only
// listed states run, and every request gets at most one reply.

#include <map>
#include <set>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/test/fuzz/untrusted.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::fuzz {
namespace {

namespace event = actuator_event;

MachineConfig Config() {
  MachineConfig config = testing::WithDancing(testing::MachineOf(1));
  ActuatorConfig& actuator = config.actuators[0];
  std::erase(actuator.states, State(kOta));
  actuator.times.assign(actuator.states.size(), Milliseconds(100));
  actuator.controller_lost = Milliseconds(1000);
  actuator.on_controller_lost = State(kLowPower);
  return config;
}

class Harness {
 public:
  explicit Harness(Input& input) : input_(input) {
    core_.report.incarnation = 77;
    StepWith(event::Started{});
    if (!input_.Bool()) StepWith(event::CallbackEnded{});
  }

  void Run() {
    for (int steps = 0; steps < 200 && !input_.empty() && !finished_; ++steps) Next();
    for (const RequestToken token : replied_) Require(token <= token_, "a reply has a request");
  }

 private:
  void Next() {
    switch (input_.Below(8)) {
      case 0: {
        const event::ControllerHeartbeatReceived heartbeat{
            AnySender(), Epoch(input_.Number(core_.report.epoch.value(), kLastEpoch.value()))};
        announced_.insert({heartbeat.sender, heartbeat.epoch});
        return StepWith(heartbeat);
      }
      case 1:
      case 2: {
        const event::SwitchArrived arrived{
            ++token_, AnyCommand(input_, core_.report, now_, "Dancing"), AnySender()};
        return StepFrom(arrived.sender, arrived.command.epoch, arrived);
      }
      case 3: {
        const QueryCommand query{
            Epoch(input_.Number(core_.report.epoch.value(), kLastEpoch.value())),
            CommandNumber(input_.Number(core_.report.number.value(), kLastNumber.value())),
            input_.Bool()};
        const event::QueryArrived arrived{++token_, query, AnySender()};
        return StepFrom(arrived.sender, query.epoch, arrived);
      }
      case 4:
        return StepWith(event::ManagerCommand{++token_, AnyState(input_, "Dancing")});
      case 5:
        if (!core_.report.busy()) return;
        return StepWith(event::CallbackEnded{input_.Bool() ? input_.Take<std::int32_t>() : kCodeOk,
                                             std::string(input_.Text())});
      case 6:
        return StepWith(event::EmergencyStopReceived{
            StopId(input_.Number(core_.report.emergency_stop.value(), 1)), input_.Bool(),
            AnySender()});
      default:
        now_ += Milliseconds(input_.Take<std::uint16_t>());
        return StepWith(event::TimePassed{});
    }
  }

  // A sender that has not announced itself with the epoch is refused.
  void StepFrom(Sender sender, Epoch epoch, const ActuatorEvent& what) {
    const ActuatorCore before = core_;
    StepWith(what);
    const bool known = sender == before.controller || announced_.count({sender, epoch}) > 0;
    if (!known) Require(core_ == before, "an unknown sender changes nothing");
  }

  void StepWith(const ActuatorEvent& what) {
    const ActuatorCore before = core_;
    const auto actions = Step(config_, 0, core_, what, now_);
    for (const ActuatorAction& action : actions) Check(action, before, what);
    const ActuatorReport& report = core_.report;
    Require(report.epoch >= before.report.epoch && report.epoch <= kLastEpoch, "epochs only grow");
    Require(report.number >= before.report.number, "numbers only grow");
    const auto deadline = NextDeadline(config_, 0, core_);
    if (std::holds_alternative<event::TimePassed>(what)) {
      Require(!deadline || *deadline > now_, "no deadline is in the past");
    }
  }

  void Check(const ActuatorAction& action, const ActuatorCore& before, const ActuatorEvent& what) {
    if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
      Require(replied_.insert(answer->token).second, "a request gets one reply");
    } else if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
      const bool ended = std::holds_alternative<event::CallbackEnded>(what);
      Require(!before.report.busy() || ended, "one callback runs at a time");
      Require(config_.actuators[0].Lists(run->target), "only listed states run");
      const bool up = MaySwitchOn(config_, before.report.state, run->target) &&
                      MaySwitchOn(config_, core_.report.state, run->target);
      Require(before.report.emergency_stop == 0 || !up, "nothing switches on during a stop");
    } else if (std::holds_alternative<actuator_action::Finish>(action)) {
      finished_ = true;
    }
  }

  Sender AnySender() { return Sender(input_.Below(4)); }

  const MachineConfig config_ = Config();
  Input& input_;
  ActuatorCore core_;
  Time now_ = Time(std::chrono::hours(1));
  RequestToken token_ = 0;
  bool finished_ = false;
  std::set<RequestToken> replied_;
  std::set<std::pair<Sender, Epoch>> announced_;
};

}  // namespace
}  // namespace musher::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  musher::fuzz::Input input(data, size);
  musher::fuzz::Harness(input).Run();
  return 0;
}
