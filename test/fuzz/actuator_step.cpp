// One actuator and anybody who commands it. Whoever has not announced itself as a controller moves
// nothing; whatever comes, epochs and numbers do not fall, an emergency stop holds, nothing runs
// that the actuator does not list, and everybody is answered at most once.

#include <map>
#include <set>

#include "musher/lifecycle/flow.hpp"
#include "musher/test/fuzz/stranger.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::fuzz {
namespace {

namespace event = actuator_event;

MachineConfig Config() {
  MachineConfig config = testing::MachineOf(1);
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
    Do(event::Started{});
    if (!input_.Bool()) Do(event::CallbackEnded{});
  }

  void Run() {
    for (int steps = 0; steps < 200 && !input_.empty() && !finished_; ++steps) Next();
    for (const RequestToken token : answered_) Require(token <= token_, "an answer has a question");
  }

 private:
  void Next() {
    switch (input_.Below(8)) {
      case 0: {
        const event::ControllerHeard heard{Anybody(),
                                           input_.Number(core_.report.epoch, kLastEpoch)};
        announced_.insert({heard.sender, heard.epoch});
        return Do(heard);
      }
      case 1:
      case 2: {
        const event::SwitchArrived arrived{++token_, AnyCommand(input_, core_.report, now_),
                                           Anybody()};
        return DoFrom(arrived.sender, arrived.command.epoch, arrived);
      }
      case 3: {
        const AskCommand ask{input_.Number(core_.report.epoch, kLastEpoch),
                             input_.Number(core_.report.number, kLastNumber), input_.Bool()};
        const event::AskArrived arrived{++token_, ask, Anybody()};
        return DoFrom(arrived.sender, ask.epoch, arrived);
      }
      case 4:
        return Do(event::ManagerCommand{++token_, AnyState(input_)});
      case 5:
        if (!core_.report.busy()) return;
        return Do(event::CallbackEnded{input_.Bool() ? input_.Take<std::int32_t>() : kCodeOk,
                                       std::string(input_.Text())});
      case 6:
        return Do(event::EmergencyStopHeard{input_.Number(core_.report.emergency_stop, 1),
                                            input_.Bool(), Anybody()});
      default:
        now_ += Milliseconds(input_.Take<std::uint16_t>());
        return Do(event::TimePassed{});
    }
  }

  // Who has not announced itself with the epoch is refused, whatever it says.
  void DoFrom(Sender sender, std::uint64_t epoch, const ActuatorEvent& what) {
    const ActuatorCore before = core_;
    Do(what);
    const bool known = sender == before.controller || announced_.count({sender, epoch}) > 0;
    if (!known) Require(core_ == before, "a stranger changes nothing");
  }

  void Do(const ActuatorEvent& what) {
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
      Require(answered_.insert(answer->token).second, "nobody is answered twice");
    } else if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
      const bool ended = std::holds_alternative<event::CallbackEnded>(what);
      Require(!before.report.busy() || ended, "one callback runs at a time");
      Require(config_.actuators[0].Lists(run->target), "only what it lists runs");
      const bool up = Rises(config_, before.report.state, run->target) &&
                      Rises(config_, core_.report.state, run->target);
      Require(before.report.emergency_stop == 0 || !up, "nothing goes up while it is stopped");
    } else if (std::holds_alternative<actuator_action::Finish>(action)) {
      finished_ = true;
    }
  }

  Sender Anybody() { return input_.Below(4); }

  const MachineConfig config_ = Config();
  Input& input_;
  ActuatorCore core_;
  Time now_ = Time(std::chrono::hours(1));
  RequestToken token_ = 0;
  bool finished_ = false;
  std::set<RequestToken> answered_;
  std::set<std::pair<Sender, std::uint64_t>> announced_;
};

}  // namespace
}  // namespace musher::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  musher::fuzz::Input input(data, size);
  musher::fuzz::Harness(input).Run();
  return 0;
}
