#include "musher/simulation/scenario.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/simulation/path.hpp"

namespace musher::simulation {
namespace {

using transport::sim::Random;

constexpr Duration kForever = std::chrono::hours(24);

// A number that depends on these only.
std::uint64_t Scramble(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  Random random(a * 0x9e3779b97f4a7c15 + b * 0xbf58476d1ce4e5b9 + c);
  random.Next();
  return random.Next();
}

constexpr const char* kMachineId = "11111111-0000-4000-8000-000000000000";

// With a host for the other machine, which is not one of the robot, if there is one.
Layout LayoutOf(const MachineConfig& config, std::uint64_t seed, bool shared_processes,
                const Injections& injections) {
  Layout layout = SampleLayout(config, seed, shared_processes);
  layout.machine_id = kMachineId;
  const bool other = std::any_of(injections.begin(), injections.end(), [](const Injection& one) {
    return one.kind == InjectionKind::kOtherMachine;
  });
  if (other) layout.hosts.emplace_back("other");
  return layout;
}

// Nothing publishes /clock in a scenario: its time is the network's.
MachineConfig WithSteadyClock(MachineConfig config) {
  config.clock = ClockSource::kSteady;
  return config;
}

}  // namespace

Scenario::Scenario(const MachineConfig& config, std::uint64_t seed, Injections injections,
                   const ScenarioOptions& options)
    : config_(config),
      seed_(seed),
      injections_(std::move(injections)),
      options_(options),
      supervised_(Scramble(seed, 3, 3) % 2 == 0),
      fault_windows_(config.actuators.size()),
      callback_runs_(config.actuators.size()),
      robot_(
          seed, WithSteadyClock(config),
          [this](const std::string& name, const State& state) { return SampleAct(name, state); },
          LayoutOf(config, seed, options.shared_processes, injections_)),
      checker_(robot_) {
  for (const ActuatorIndex i : config.actuators.Indices()) {
    for (const State& state : config.actuators[i].states) {
      phase_timeout_ = std::max(phase_timeout_, config.TimeFor(i, state) + Milliseconds(500));
    }
  }
  robot_.on_killed = [this](const ControllerProcess& controller) {
    checker_.OnControllerKilled(controller);
  };
  robot_.on_record = [this](const action::Record& record) {
    Mix(record.message);
    checker_.OnRecord(record);
    if (listener.on_record) listener.on_record(robot_.network().now(), record);
  };
}

Scenario::~Scenario() = default;

void Scenario::UseModule(
    const std::string& actuator,
    std::function<std::unique_ptr<Module>(const ActSampler& sample_act)> make) {
  auto& make_module = robot_.processes().make_module;
  make_module = [this, actuator, make = std::move(make),
                 others = std::move(make_module)](const std::string& name) {
    if (name != actuator) return others(name);
    return make([this, name](const State& state) { return SampleAct(name, state); });
  };
}

Ending RunScenario(const MachineConfig& config, std::uint64_t seed, const Injections& injections,
                   const ScenarioOptions& options) {
  const CheckContext context("the scenario of seed " + std::to_string(seed));
  return Scenario(config, seed, injections, options).Run();
}

Ending Scenario::Run() {
  SwitchOn();
  if (!Over()) Inject();
  if (!Over()) EndFaults();
  if (!Over()) Settle();
  if (!Over()) Repair();
  if (!Over()) SwitchOff();
  ending_.violation = violation();
  if (ending_.violation && !checker_.violation()) {
    ending_.violation->what = "the other machine: " + ending_.violation->what;
  }
  ending_.checks = checker_.checks();
  ending_.steps = robot_.network().steps();
  ending_.simulated = robot_.age();
  return ending_;
}

const std::optional<Violation>& Scenario::violation() const {
  const bool of_other = other_ && !checker_.violation() && other_->checker().violation();
  return of_other ? other_->checker().violation() : checker_.violation();
}

void Scenario::Mix(const std::string& text) {
  for (const char c : text) {  // FNV-1a
    ending_.fingerprint = (ending_.fingerprint ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  }
  ending_.fingerprint ^=
      static_cast<std::uint64_t>(robot_.network().now().time_since_epoch().count());
}

// Some milliseconds, and never longer than its time limit, unless a fault is injected.
Act Scenario::SampleAct(const std::string& name, const State& state) {
  const ActuatorIndex i = *config_.IndexOf(name);
  Random random(Scramble(seed_, i.value(), ++callback_runs_[i]));
  const Duration limit = config_.TimeFor(i, state);
  Act act;
  act.takes = std::min(limit / 2, random.Between(std::chrono::microseconds(200), Milliseconds(40)));
  const Time now = robot_.network().now();
  const FaultWindow& window = fault_windows_[i];
  if (now < window.fails) act.error = {kCodeFailed, "injected"};
  if (now < window.slow) act.takes = random.Between(limit / 2, limit + limit / 4);
  if (now < window.hangs) act.takes = kForever;
  return act;
}

void Scenario::Later(Duration delay, std::function<void()> what) {
  later_.push_back({robot_.network().now() + delay, std::move(what)});
}

bool Scenario::RunUntil(const std::function<bool()>& done, Duration limit) {
  const Time end = robot_.network().now() + limit;
  for (;;) {
    const auto next =
        std::min_element(later_.begin(), later_.end(),
                         [](const TimedAction& a, const TimedAction& b) { return a.at < b.at; });
    const bool first = next != later_.end() && next->at <= end;
    const Time until = first ? next->at : end;
    bool reached = false;
    const auto stop = [&] {
      checker_.AfterEvent();
      if (other_) other_->checker().AfterEvent();
      if (listener.on_change) listener.on_change(robot_.network().now(), robot_);
      reached = done();
      return reached || Over();
    };
    if (robot_.network().RunUntil(stop, until)) return reached;
    if (!first) return false;
    const auto what = std::move(next->what);
    later_.erase(next);
    what();
    checker_.AfterEvent();
  }
}

void Scenario::RunFor(Duration duration) {
  RunUntil([] { return false; }, duration);
}

void Scenario::SwitchOn() {
  Random random(Scramble(seed_, 1, 1));
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    // Hosts are switched on at different times.
    robot_.hosts().SetUptime(host, random.Between(std::chrono::seconds(10), std::chrono::hours(1)));
  }
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (!IsByHand(i)) continue;
    Later(random.Between(Duration::zero(), Milliseconds(50)), [this, i] { StartByHand(i); });
  }
  StartController();
}

void Scenario::StartController(bool restarted) {
  robot_.LaunchController(0, !restarted, robot_.ListenTime(), restarted);
}

bool Scenario::IsByHand(ActuatorIndex actuator) const {
  return config_.actuators[actuator].command.empty() &&
         robot_.layout().ProcessOf(actuator) == actuator;
}

void Scenario::StartByHand(ActuatorIndex actuator) {
  const std::string& name = config_.actuators[actuator].name;
  if (!robot_.IsAlive(name)) robot_.StartActuator(name);
}

void Scenario::Inject() {
  for (const Injection& injection : injections_) {
    RunFor(injection.at - robot_.age());
    if (injection.when) RunUntil([&] { return Now() == *injection.when; }, phase_timeout_);
    if (Over()) return;
    ending_.coverage.Count(injection.kind, Now());
    if (listener.on_injection) listener.on_injection(robot_.network().now(), injection);
    Apply(injection);
    checker_.AfterEvent();
  }
  while (!later_.empty() && !Over()) {
    RunFor(later_.back().at - robot_.network().now());
  }
}

MachinePhase Scenario::Now() const {
  const ControllerProcess* leader = robot_.leader();
  return MachinePhaseOf(leader == nullptr ? nullptr : &leader->shell().machine());
}

// Ends all injected faults, and starts a controller if there is none.
void Scenario::EndFaults() {
  if (config_.policy)
    robot_.SetMotion(303);  // walking: a body that lies still goes to LowPower by itself
  robot_.EndStopPrograms();
  std::fill(fault_windows_.begin(), fault_windows_.end(), FaultWindow{});
  for (const ActuatorConfig& actuator : config_.actuators) {
    robot_.processes().Misconfigure(actuator.name, false);
  }
  if (!robot_.has_controller()) {
    Note("the operator starts the controller again");
    robot_.CrashController();
    StartController();
  }
}

void Scenario::Settle() {
  const Time faults_ended = robot_.network().now();
  if (!ReachStableState(std::to_string(ToMilliseconds(options_.bound)) +
                        " ms after the last fault")) {
    return;
  }
  ending_.rested = robot_.network().now() - faults_ended;
  // A fault may be detected only now.
  RunFor(std::chrono::seconds(15));
  if (ReachStableState("although it was before")) checker_.CheckRest(options_.provided);
  if (!Over()) SettleOtherMachine();
}

// Beside the robot, too, whatever happened to either, the other machine is as it should be.
void Scenario::SettleOtherMachine() {
  if (!other_) return;
  Checker& checker = other_->checker();
  if (other_->robot().leader() == nullptr) {
    other_->StartController(false);
    if (other_->robot().leader() == nullptr) RunFor(std::chrono::seconds(2));
  }
  const bool rests = RunUntil([&] { return checker.AtRest(); }, options_.bound);
  if (Over()) return;
  if (rests) return checker.CheckRest(false);
  checker.ReportViolation(Invariant::kReachesStableState,
                          "the other machine is not stable: " + checker.PendingActivity());
}

void Scenario::Note(const std::string& action) {
  if (listener.on_repair) listener.on_repair(robot_.network().now(), action);
}

}  // namespace musher::simulation
