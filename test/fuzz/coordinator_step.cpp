// A controller with its actuators, and an untrusted sender that publishes anything in their names.
// No actuator becomes more active than requested, an emergency stop holds, numbers stay in their
// bounds, and the loop never spins.

#include <algorithm>

#include "musher/test/fuzz/untrusted.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::fuzz {
namespace {

constexpr const char* kNames[] = {"a", "b", "c", "d"};

MachineConfig Config(std::uint8_t kind) {
  MachineConfig config = testing::MachineOf(4);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.command = {"run", actuator.name};
    actuator.restart.policy = RestartPolicy::kOnFailure;
    actuator.restart.limit = 3;
    actuator.on_lost = State(kLowPower);
  }
  config.actuators[0].critical = (kind & 1) != 0;
  config.actuators[1].after = {"a"};
  if ((kind & 2) != 0) config.actuators[1].binds_to = {"a"};
  if ((kind & 4) != 0) config.actuators[2].command.clear();
  if ((kind & 8) != 0) config.actuators[3].stage = 2;
  return config;
}

class Harness {
 public:
  explicit Harness(Input& input) : input_(input), harness_(Config(input.Byte())) {
    harness_.after_step = [this] { Check(); };
    const bool from_start = input_.Bool();
    harness_.Begin();
    if (from_start) return;
    harness_.RunFor(std::chrono::seconds(5));
    harness_.Set(State(kDeActive));
    harness_.ClearLog();
    allowed_ = *BuiltInRank(kDeActive);
  }

  void Run() {
    for (int steps = 0; steps < 40 && !input_.empty(); ++steps) {
      Next();
      harness_.RunFor(Milliseconds(input_.Byte()));
    }
    harness_.Rest(std::chrono::seconds(30));
  }

 private:
  void Next() {
    const std::size_t which = input_.Below(std::size(kNames));
    const ActuatorIndex i(which);
    const std::string name = kNames[which];
    const KnownActuator& known = harness_.RecordOf(name);
    switch (input_.Below(12)) {
      case 0:
      case 1:
      case 2:
        return harness_.Feed(event::StatusSeen{i, AnyReport(input_, known.report, harness_.now())});
      case 3: {
        const CommandNumber number = known.command ? known.command->number : known.report.number;
        const auto verdict = transport::VerdictFrom(input_.Byte());
        return harness_.Feed(event::Replied{
            i, input_.Bool() ? number : CommandNumber(input_.Take<std::uint64_t>()), input_.Bool(),
            verdict, input_.Take<std::int32_t>(), std::string(input_.Text()),
            AnyReport(input_, known.report, harness_.now())});
      }
      case 4:
        return harness_.Feed(
            event::Vanished{i, known.report.incarnation, input_.Bool(), "connection lost"});
      case 5:
        return harness_.Feed(event::HealthChanged{i, known.report.incarnation,
                                                  transport::WorkFrom(input_.Byte()), input_.Bool(),
                                                  "by its heartbeat"});
      case 6:
        return harness_.Feed(event::EmergencyStopSeen{
            {StopId(input_.Number(1, 2)), std::string(input_.Text()), std::string(input_.Text())}});
      case 7:
        harness_.Release();
        return;
      case 8:
        // A controller of the current epoch or a higher one leads from then on, which is correct.
        return harness_.Feed(event::RivalSeen{
            Epoch(input_.Number(harness_.machine().epoch.value() - 1, kLastEpoch.value()) |
                  (input_.Bool() ? kBeyond : 0)),
            "another", input_.Bool()});
      case 9:
        return harness_.Crash(name);
      case 10:
        harness_.Restart(name);
        return;
      default:
        return RequestSwitch(name);
    }
  }

  void RequestSwitch(const std::string& name) {
    constexpr BuiltInState targets[] = {kProtected, kDeActive, kLowPower, kSelfCheck, kError};
    const State target = targets[input_.Below(std::size(targets))];
    if (const auto rank = BuiltInRank(target)) allowed_ = std::max(allowed_, *rank);
    if (input_.Bool()) {
      harness_.RequestSwitch(target, name);
    } else {
      harness_.RequestSwitch(target);
    }
  }

  void Check() {
    const Machine& machine = harness_.machine();
    const MachineConfig& config = harness_.config();
    const auto deadline = NextDeadline(config, machine);
    // The loop reports the time at once; a start is given up with that event only.
    const bool starts = std::ranges::any_of(machine.actuators, [&](const KnownActuator& known) {
      return IsOverdue(known, harness_.now());
    });
    Require(!deadline || *deadline > harness_.now() || (starts && !harness_.was_timer),
            "no deadline is in the past");
    Require(machine.epoch <= kLastEpoch, "epochs stay in their bounds");
    // The commands of one input may follow the highest number that a report can raise it to.
    constexpr std::uint64_t kCommandsOfAnInput = 100'000;
    Require(machine.number < kLastNumber + kCommandsOfAnInput, "numbers stay in their bounds");
    Require(machine.state == kUninitialized || config.HasState(machine.state),
            "the machine is in one of its states");
    const auto rank = config.RankOf(machine.state);
    Require(!rank || *rank <= allowed_, "the machine switches up on request only");
    for (; callbacks_ < harness_.log().size(); ++callbacks_) {
      const std::string& run = harness_.log()[callbacks_];
      const auto target = config.RankOf(run.substr(run.find(':') + 1));
      Require(!target || *target <= allowed_, "actuators switch up on request only: " + run);
    }
    const bool both = rank_ && rank && stopped_ && machine.emergency.stop;
    Require(!both || *rank <= *rank_, "the machine does not switch up during an emergency stop");
    stopped_ = machine.emergency.stop.has_value();
    rank_ = rank;
  }

  static constexpr std::uint64_t kBeyond = kLastEpoch.value() << 1;  // of no controller

  Input& input_;
  testing::Harness harness_;
  Rank allowed_ = *BuiltInRank(kActive);
  std::size_t callbacks_ = 0;
  bool stopped_ = false;
  std::optional<Rank> rank_;
};

}  // namespace
}  // namespace musher::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  musher::fuzz::Input input(data, size);
  musher::fuzz::Harness(input).Run();
  return 0;
}
