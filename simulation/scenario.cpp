#include "musher/simulation/scenario.hpp"

#include <signal.h>

#include <algorithm>
#include <deque>
#include <map>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/lifecycle/config/flow.hpp"

namespace musher::simulation {

using transport::sim::LinkFaults;

namespace {

using transport::sim::Random;

constexpr Duration kForever = std::chrono::hours(24);

// A number that depends on these only.
std::uint64_t Scramble(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  Random random(a * 0x9e3779b97f4a7c15 + b * 0xbf58476d1ce4e5b9 + c);
  random.Next();
  return random.Next();
}

// The first injected event of that kind; null: there is none.
const Injection* FirstOf(const Injections& injections, InjectionKind kind) {
  const auto found = std::find_if(injections.begin(), injections.end(),
                                  [kind](const Injection& one) { return one.kind == kind; });
  return found == injections.end() ? nullptr : &*found;
}

constexpr const char* kMachineId = "11111111-0000-4000-8000-000000000000";

// With a host for the other machine, which is not one of the robot, if there is one.
Layout LayoutOf(const MachineConfig& config, std::uint64_t seed, bool shared_processes,
                const Injections& injections) {
  Layout layout = SampleLayout(config, seed, shared_processes);
  layout.machine_id = kMachineId;
  for (const ActuatorIndex i : config.actuators.Indices()) {
    const std::string& host = config.actuators[i].host;
    const auto named = std::ranges::find(layout.hosts, host);
    if (!host.empty()) layout.host_of[i] = static_cast<std::size_t>(named - layout.hosts.begin());
  }
  if (FirstOf(injections, InjectionKind::kOtherMachine) != nullptr)
    layout.hosts.emplace_back("other");
  return layout;
}

// Something publishes /clock where an injected event concerns it; otherwise the policy's time is
// the network's. The same with permits to move.
MachineConfig ForScenario(MachineConfig config, const Injections& injections) {
  if (FirstOf(injections, InjectionKind::kClockFault) == nullptr) {
    config.clock = ClockSource::kSteady;
  }
  if (FirstOf(injections, InjectionKind::kPermitFault) == nullptr) config.permit.reset();
  return config;
}

constexpr std::int32_t kLying = 0;
constexpr std::int32_t kWalking = 303;
constexpr int kMostBattery = 100;
constexpr std::size_t kFirstProgram = 100;  // that engages stops, beside the panels
constexpr Duration kLatestPermit = Milliseconds(400);
constexpr std::int64_t kRealTime = 1000;  // permille: /clock is as fast as the network's time
constexpr Duration kShutsDownWithin = std::chrono::seconds(1);  // a host
// A start that a lost connection still holds is not carried out after this.
constexpr Duration kUntilNothingStarts = std::chrono::seconds(30);
constexpr Duration kWalkPeriod = Milliseconds(300);  // of the samples of a battery that jitters

// After this all hosts have noticed the end of a process that no controller of its host monitors.
constexpr Duration kUntilMissed = std::chrono::seconds(12);

// The path of a machine, switch by switch, as an operator takes it: the fewest switches that lead
// from `from` to `to`, without TearDown; nullopt: there is none.
std::optional<std::vector<State>> FindPath(const MachineConfig& config, const State& from,
                                           const State& to) {
  std::map<State, State> before = {{from, from}};
  std::deque<State> open = {from};
  while (!open.empty() && !before.contains(to)) {
    const State at = open.front();
    open.pop_front();
    for (const State& next : Reachable(config, at)) {
      // A self-check changes the state only during the start and in Error.
      const bool stays = next == kSelfCheck && config.RankOf(at) && at != kError;
      if (stays || next == kTearDown || before.contains(next)) continue;
      before[next] = at;
      open.push_back(next);
    }
  }
  if (!before.contains(to)) return std::nullopt;
  std::vector<State> path;
  for (State at = to; at != from; at = before.at(at)) path.push_back(at);
  std::reverse(path.begin(), path.end());
  return path;
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
          seed, ForScenario(config, injections_),
          [this](const std::string& name, const State& state) { return SampleAct(name, state); },
          LayoutOf(config, seed, options.shared_processes, injections_)),
      checker_(robot_) {
  checker_.SetUserRules(options.rules);
  for (const std::size_t controller : {0U, 1U}) {
    robot_.disk(controller).rules = options.rules;
  }
  for (const ActuatorIndex i : config.actuators.Indices()) {
    for (const State& state : config.actuators[i].states) {
      phase_timeout_ = std::max(phase_timeout_, config.TimeFor(i, state) + Milliseconds(500));
    }
  }
  robot_.on_killed = [this](const SimulatedController& controller) {
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

ScenarioEnd RunScenario(const MachineConfig& config, std::uint64_t seed,
                        const Injections& injections, const ScenarioOptions& options) {
  const CheckContext context("the scenario of seed " + std::to_string(seed));
  return Scenario(config, seed, injections, options).Run();
}

ScenarioEnd Scenario::Run() {
  SwitchOn();
  if (!Over()) Inject();
  if (!Over()) EndFaults();
  if (!Over()) AwaitStableState();
  if (!Over()) Repair();
  if (!Over()) SwitchOff();
  ending_.violation = violation();
  if (ending_.violation && !checker_.violation()) {
    ending_.violation->what = "the other machine: " + ending_.violation->what;
  }
  ending_.checks = checker_.checks();
  ending_.rule_coverage = checker_.user_rules_coverage();
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
  const Injection* of_permits = FirstOf(injections_, InjectionKind::kPermitFault);
  if (of_permits != nullptr) {
    console_host_ = of_permits->host;
    StartPermits();
  }
  // The first sample of /clock may be late.
  if (robot_.config().clock == ClockSource::kTopic) {
    Random clock(Scramble(seed_, 7, 7));
    const bool late = clock.Bernoulli(0.5);
    Later(late ? clock.Between({}, std::chrono::seconds(15)) : Duration::zero(),
          [this] { robot_.StartClock(); });
  }
  StartController();
}

void Scenario::StartPermits() {
  if (robot_.config().permit && robot_.permits() == nullptr) robot_.StartPermits(console_host_);
}

void Scenario::StartController(Starter starter) {
  robot_.LaunchController(0, starter == Starter::kPerson, robot_.ListenTime(), starter);
  robot_.StartStandby();
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
  const SimulatedController* leader = robot_.leader();
  return MachinePhaseOf(leader == nullptr ? nullptr : &leader->shell().machine());
}

// Ends all injected faults, and starts a controller if there is none.
void Scenario::EndFaults() {
  if (config_.policy)
    robot_.SetMotion(303);  // walking: a body that lies still goes to LowPower by itself
  robot_.EndStopPrograms();
  RestoreWorld();
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

void Scenario::AwaitStableState() {
  const Time faults_ended = robot_.network().now();
  if (!ReachStableState(std::to_string(ToMilliseconds(options_.bound)) +
                        " ms after the last fault")) {
    return;
  }
  ending_.rested = robot_.network().now() - faults_ended;
  // A fault may be detected only now.
  RunFor(std::chrono::seconds(15));
  if (ReachStableState("although it was before")) checker_.CheckRest(options_.provided);
  if (!Over()) AwaitOtherMachine();
}

// Beside the robot, too, whatever happened to either, the other machine is as it should be.
void Scenario::AwaitOtherMachine() {
  if (!other_) return;
  Checker& checker = other_->checker();
  if (other_->robot().leader() == nullptr) {
    other_->StartController(Starter::kPerson);
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

// --- how injected events act on the robot ---

// A crash ends all actuators of the process.
void Scenario::NoteCrash(ActuatorIndex process) {
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (robot_.layout().ProcessOf(i) == process) checker_.OnCrash(config_.actuators[i].name);
  }
}

void Scenario::Apply(const Injection& injection) {
  const std::string& name = config_.actuators[injection.actuator].name;
  const Time now = robot_.network().now();
  FaultWindow& window = fault_windows_[injection.actuator];
  switch (injection.kind) {
    case InjectionKind::kCrash:
      if (robot_.IsAlive(name)) NoteCrash(robot_.layout().ProcessOf(injection.actuator));
      return robot_.CrashActuator(name);
    case InjectionKind::kWrongConfig:
      return Misconfigure(name, injection.lasts);
    case InjectionKind::kFreeze:
      if (!robot_.IsAlive(name)) return;
      robot_.FreezeActuator(name);
      return Later(injection.lasts, [this, name] {
        if (robot_.IsAlive(name)) robot_.ThawActuator(name);
      });
    case InjectionKind::kHang:
      window.hangs = now + injection.lasts;
      return;
    case InjectionKind::kSlow:
      window.slow = now + injection.lasts;
      return;
    case InjectionKind::kFail:
      window.fails = now + injection.lasts;
      return;
    case InjectionKind::kLie:
      if (!robot_.IsAlive(name)) return;
      checker_.OnFalseReport(name, injection.state);
      return robot_.Lie(name, injection.state);
    case InjectionKind::kSet:
      return RequestSwitch(injection.state);
    case InjectionKind::kSetOne:
      return RequestSwitch(injection.state, name);
    case InjectionKind::kBattery:
      return robot_.SetBattery(BatteryOf(injection), ChargesIn(injection));
    case InjectionKind::kEmergencyStop:
      return Engage(injection.random / 2 % 2, StopId(injection.random | 1));
    case InjectionKind::kRelease:
      return robot_.ReleaseEmergencyStop();
    case InjectionKind::kTakeBack:
      return robot_.TakeBack();
    case InjectionKind::kRestart:
      checker_.OnRestartRequest(name);
      return robot_.Restart(name);
    default:
      if (IsAround(injection.kind)) return ApplyAround(injection);
      if (injection.kind >= InjectionKind::kClientSet) return ApplyByClient(injection);
      if (injection.kind == InjectionKind::kCrossingStops) return ApplyToStops(injection);
      if (injection.kind == InjectionKind::kStalledDisk) return ApplyToController(injection);
      if (injection.kind >= InjectionKind::kReboot) return ApplyToHosts(injection);
      if (injection.kind >= InjectionKind::kBatteryGlitch) return ApplyToBattery(injection);
      if (injection.kind > InjectionKind::kRestart) return ApplyToPolicy(injection);
      return injection.kind < InjectionKind::kControllerCrash ? ApplyToNetwork(injection)
                                                              : ApplyToController(injection);
  }
}

void Scenario::Misconfigure(const std::string& name, Duration lasts) {
  robot_.processes().Misconfigure(name, true);
  if (robot_.IsAlive(name)) {
    checker_.OnWrongConfig(name);
    robot_.processes().End(name, WrongConfigExit());
  }
  Later(lasts, [this, name] { robot_.processes().Misconfigure(name, false); });
}

void Scenario::ApplyToPolicy(const Injection& injection) {
  const std::uint64_t random = injection.random;
  switch (injection.kind) {
    case InjectionKind::kStillness:
      return robot_.SetMotion(random % 4 == 0 ? kWalking : kLying);
    case InjectionKind::kWakeUp:
      return RequestPolicy({0, PolicyRequest::kWakeUp, "", 0, false});
    case InjectionKind::kKeep:
      return RequestPolicy(
          {0, PolicyRequest::kKeep, injection.state, static_cast<std::int64_t>(random % 8), false});
    case InjectionKind::kOta:
      return RequestPolicy({0, PolicyRequest::kOta, "", 0, random % 2 == 0});
    case InjectionKind::kLowPowerSwitch:
      return RequestPolicy({0, PolicyRequest::kLowPowerSwitch, "", 0, random % 3 != 0});
    default:
      return RequestPolicy({0, PolicyRequest::kPowerOff, "", 0, false});
  }
}

// Faults of what publishes the battery.
void Scenario::ApplyToBattery(const Injection& injection) {
  switch (injection.kind) {
    case InjectionKind::kBatteryGlitch:
      return robot_.GlitchBattery(BatteryOf(injection), ChargesIn(injection));
    case InjectionKind::kBatteryWriter:
      robot_.SetOtherBattery(BatteryOf(injection));
      return Later(injection.lasts, [this] { robot_.SetOtherBattery(std::nullopt); });
    default:
      robot_.SetBattery(BatteryOf(injection), false);
      return WalkBattery(transport::sim::Random(injection.random),
                         robot_.network().now() + injection.lasts);
  }
}

void Scenario::WalkBattery(transport::sim::Random random, Time until) {
  if (robot_.network().now() >= until) return;
  const int step = static_cast<int>(random.Next() % 7) - 3;
  robot_.SetBattery(std::clamp(robot_.battery().value_or(kMostBattery) + step, 0, kMostBattery),
                    false);
  Later(kWalkPeriod, [this, random, until] { WalkBattery(random, until); });
}

void Scenario::RequestPolicy(const event::PolicyRequested& requested) {
  SimulatedController* leader = robot_.leader();
  if (leader == nullptr || leader->frozen) return;
  const std::uint64_t request = checker_.OnPolicyRequest(*leader, requested);
  leader->shell().SendPolicyRequest(requested, [this, request, requested](const Result<>& reply) {
    Mix(reply ? "ok" : reply.error().message);
    checker_.OnPolicyReply(request, requested, reply);
  });
}

void Scenario::ApplyToNetwork(const Injection& injection) {
  if (injection.kind < InjectionKind::kPartition) {
    const auto which =
        static_cast<std::size_t>(injection.kind) - static_cast<std::size_t>(InjectionKind::kLoss);
    ++network_faults_[which];
    ApplyNetworkFaults();
    return Later(injection.lasts, [this, which] {
      --network_faults_[which];
      ApplyNetworkFaults();
    });
  }
  const bool deaf = injection.kind != InjectionKind::kMute;
  const bool mute = injection.kind != InjectionKind::kDeaf;
  const ActuatorIndex process = robot_.layout().ProcessOf(injection.actuator);
  const auto set = [this, name = config_.actuators[process].name, deaf, mute](bool blocked) {
    for (const char* controller : SimRobot::kControllerEndpoints) {
      if (deaf) robot_.hosts().SetBlocked(controller, name, blocked);
      if (mute) robot_.hosts().SetBlocked(name, controller, blocked);
    }
  };
  set(true);
  Later(injection.lasts, [set] { set(false); });
}

// A panel has no identity: it stops every machine in reach.
void Scenario::Engage(std::size_t panel, StopId id, const std::string& by) {
  if (id != 0) checker_.OnStopEngaged(panel, id);
  if (id != 0 && other_) other_->checker().OnStopEngaged(panel, id);
  const StopId given = robot_.EngageEmergencyStop(id, panel, by);
  if (id != 0) return;
  checker_.OnStopEngaged(panel, given);
  if (other_) other_->checker().OnStopEngaged(panel, given);
}

// Two panels engage a stop; the release comes between them or at about the same time.
void Scenario::ApplyToStops(const Injection& injection) {
  const std::uint64_t random = injection.random;
  const std::size_t panel = random / 2 % 2;
  Engage(panel, StopId(random | 1));
  Later(Milliseconds(static_cast<std::int64_t>(random / 16 % 40)),
        [this, panel, id = StopId((random >> 9) | 1)] { Engage(1 - panel, id); });
  Later(Milliseconds(static_cast<std::int64_t>(random / 1024 % 60)),
        [this] { robot_.ReleaseEmergencyStop(); });
}

// What is around the robot.
void Scenario::ApplyAround(const Injection& injection) {
  switch (injection.kind) {
    case InjectionKind::kOtherMachine:
      return MeetOtherMachine(injection);
    case InjectionKind::kOuterNetwork:
      robot_.hosts().SetCutOff(injection.host, true);
      return Later(injection.lasts,
                   [this, host = injection.host] { robot_.hosts().SetCutOff(host, false); });
    case InjectionKind::kLostFiles:
      checker_.OnControllersBlocked(true);
      robot_.LoseFiles();
      return Later(std::chrono::seconds(1), [this] { robot_.SaveAgain(); });
    case InjectionKind::kBridge:
      bridge_ = std::make_unique<Bridge>(robot_.network(), config_, injection.random);
      return Later(injection.lasts, [this] { bridge_.reset(); });
    case InjectionKind::kStopProgram:
      EngageByProgram(injection);
      return ReleaseLater(injection);
    case InjectionKind::kManyStops:
      EngageMany(transport::sim::Random(injection.random));
      return ReleaseLater(injection);
    case InjectionKind::kSilentBattery:
      robot_.SetBatterySilent(true);
      return Later(injection.lasts, [this] { robot_.SetBatterySilent(false); });
    case InjectionKind::kSlowDiscovery:
      robot_.ClientOn(injection.host).SetDiscoveryAtMost(std::chrono::seconds(10));
      return Later(injection.lasts, [this, host = injection.host] {
        robot_.ClientOn(host).SetDiscoveryAtMost(Client::kUsualDiscovery);
      });
    case InjectionKind::kPermitFault:
      return ApplyToPermits(injection);
    case InjectionKind::kClockFault:
      return ApplyToClock(injection);
    case InjectionKind::kUnreadFolder:
      return robot_.AddUnreadFolder(injection.random);
    case InjectionKind::kClosedFolder:
      checker_.OnControllersBlocked(true);
      robot_.SetFolderOpens(injection.random % 2 == 0 ? FolderOpens::kForReading
                                                      : FolderOpens::kNo);
      return Later(injection.lasts, [this] { robot_.SetFolderOpens(FolderOpens::kYes); });
    case InjectionKind::kOtherUser:
      return ChangeUser(injection);
    case InjectionKind::kFrozen:
      if (!robot_.IsAlive(config_.actuators[injection.actuator].name)) return;
      return robot_.FreezeActuator(config_.actuators[injection.actuator].name);
    default:
      Engage(injection.random / 2 % 2, 0);
      return ReleaseLater(injection);
  }
}

void Scenario::ChangeUser(const Injection& injection) {
  checker_.OnControllersBlocked(false);
  robot_.ChangeUser();
  const bool boots = injection.random % 4 != 0;
  if (boots) Reboot(robot_.layout().controllers[0], injection.lasts);
  Later(injection.lasts, [this] {
    if (robot_.MayStartFirst()) StartController();
  });
}

// Faults of one console; the next one has the links of the others.
void Scenario::ApplyToPermits(const Injection& injection) {
  const PermitConsole* console = robot_.permits();
  if (console == nullptr) return;
  const std::string& endpoint = console->endpoint();
  LinkFaults faults;
  switch (PermitFaultOf(injection)) {
    case PermitFault::kConsoleEnds:
      robot_.EndPermits();
      return Later(injection.lasts, [this] { StartPermits(); });
    case PermitFault::kCut: {
      const ActuatorIndex process = robot_.layout().ProcessOf(injection.actuator);
      const auto set = [this, endpoint, name = config_.actuators[process].name](bool blocked) {
        robot_.hosts().SetBlocked(endpoint, name, blocked);
      };
      set(true);
      return Later(injection.lasts, [set] { set(false); });
    }
    case PermitFault::kLost:
      faults.loss = 0.9;
      break;
    case PermitFault::kLate:
      faults.delay_max = kLatestPermit;
      faults.reordering = 0.5;
      faults.duplication = 0.3;
      break;
  }
  robot_.network().SetFaultsOf(endpoint, faults);
  Later(injection.lasts,
        [this, endpoint] { robot_.network().SetFaultsOf(endpoint, LinkFaults{}); });
}

void Scenario::ApplyToClock(const Injection& injection) {
  WorldClock* clock = robot_.clock();
  if (clock == nullptr) return;
  switch (ClockFaultOf(injection)) {
    case ClockFault::kRate:
      clock->SetRate(ClockRateOf(injection));
      return Later(injection.lasts, [clock] { clock->SetRate(kRealTime); });
    case ClockFault::kPause:
      clock->SetPaused(true);
      return Later(injection.lasts, [clock] { clock->SetPaused(false); });
    case ClockFault::kBack:
    case ClockFault::kForward:
      return clock->Jump(ClockJumpOf(injection));
    case ClockFault::kRestart:
      return clock->Restart();
  }
}

void Scenario::RestoreWorld() {
  StartPermits();
  WorldClock* clock = robot_.clock();
  if (clock == nullptr) return;
  clock->SetPaused(false);
  clock->SetRate(kRealTime);
}

void Scenario::ReleaseLater(const Injection& injection) {
  if (injection.lasts == Duration::zero()) return;
  Later(injection.lasts, [this, host = injection.host, by_client = injection.random % 3 == 0] {
    if (!by_client) return robot_.ReleaseEmergencyStop();
    robot_.ClientOn(host).ReleaseEmergencyStop();
  });
}

// It starts before it comes into range, or just then; meanwhile people use it. Half of them stay.
void Scenario::MeetOtherMachine(const Injection& injection) {
  if (other_) return;
  transport::sim::Random random(injection.random);
  const std::size_t host = robot_.hosts().size() - 1;
  other_ = std::make_unique<OtherMachine>(robot_, checker_, host, random);
  for (std::size_t number = 0; number < program_stops_.size(); ++number) NoteForOther(number);
  other_->on_record = [this](action::Record record) {
    record.message = "other machine: " + record.message;
    Mix(record.message);
    if (listener.on_record) listener.on_record(robot_.network().now(), record);
  };
  ApplyNetworkFaults();
  const Duration alone =
      random.Bernoulli(0.3) ? Duration::zero() : random.Between({}, std::chrono::seconds(5));
  Later(alone, [this] { other_->SetInRange(true); });
  for (std::uint64_t acts = random.Next() % 5; acts > 0; --acts) {
    Later(random.Between({}, alone + injection.lasts), [this] { other_->Act(); });
  }
  const bool stays = random.Bernoulli(0.5);
  Later(alone + injection.lasts, [this, stays] {
    if (!stays) other_->SetInRange(false);
    other_->StartController(Starter::kSupervisor);  // where none runs
  });
}

void Scenario::EngageByProgram(const Injection& injection) {
  // As late as the stop may arrive, over links that lose most of it.
  constexpr Duration kLatest = std::chrono::seconds(30);
  transport::sim::Random random(injection.random);
  const std::array<Duration, 3> delays = {Milliseconds(1), Milliseconds(100), Milliseconds(400)};
  const std::array<Duration, 3> discoveries = {Milliseconds(5), Milliseconds(1500),
                                               std::chrono::seconds(10)};
  SimRobot::StopLinks links;
  links.delay_most = delays[random.Next() % delays.size()];
  links.discovery_most = discoveries[random.Next() % discoveries.size()];
  links.loss = random.Bernoulli(0.5) ? 0.3 : 0;
  const StopId id((random.Next() | 1) >> 1);
  checker_.OnStopEngaged(kFirstProgram + program_stops_.size(), id);
  robot_.on_stop_program = [this](StopId stop, bool confirmed) {
    ++ending_.stop_programs[confirmed ? 1 : 0];
    const auto program = std::find_if(program_stops_.begin(), program_stops_.end(),
                                      [&](const ProgramStop& one) { return one.id == stop; });
    // It has not named this machine alone: it may reach and confirm the other one only.
    const bool any = other_ && SameMachine(program->meant, other_->robot().identity());
    if (confirmed && !any) checker_.OnStopConfirmed(stop);
  };
  robot_.on_stop_withdrawn = [this](StopId stop) { checker_.OnStopWithdrawn(stop); };
  const MachineIdentity meant =
      robot_.EngageByProgram(id, injection.host, links, random.Bernoulli(0.2));
  Later(kLatest, [] {});
  program_stops_.push_back({id, meant});
  if (other_) NoteForOther(program_stops_.size() - 1);
}

// Whether the stop is meant for the other machine as well, which may be out of range.
void Scenario::NoteForOther(std::size_t number) {
  const ProgramStop& stop = program_stops_[number];
  Checker& checker = other_->checker();
  if (!SameMachine(stop.meant, other_->robot().identity())) return checker.OnStopOfOther(stop.id);
  checker.OnStopEngaged(kFirstProgram + number, stop.id);
  checker.OnStopWithdrawn(stop.id);
}

// By one source or by as many, with or without ids.
void Scenario::EngageMany(transport::sim::Random random) {
  const int count = 20 + static_cast<int>(random.Next() % 80);
  const StopId first(random.Bernoulli(0.3) ? 0 : (random.Next() >> 8) + 1);
  const bool one_source = random.Bernoulli(0.5);
  EngageNext(random.Next() % 2, first, one_source, count);
}

void Scenario::EngageNext(std::size_t panel, StopId id, bool one_source, int left) {
  if (left == 0) return;
  Engage(panel, id, one_source ? "a person" : "person " + std::to_string(left));
  const StopId next(id == 0 ? 0 : id.value() + 1);
  Later(Milliseconds(1 + left % 20),
        [this, panel, next, one_source, left] { EngageNext(panel, next, one_source, left - 1); });
}

void Scenario::ApplyByClient(const Injection& injection) {
  Client& client = robot_.ClientOn(injection.host);
  client.on_end = [this](const Client::Request&, const SwitchEnd& end) {
    ++ending_.client_ends[static_cast<std::size_t>(end.kind)];
    Mix(end.result.outcome);
  };
  client.on_reply = [this](bool replied) { ++ending_.client_calls[replied ? 1 : 0]; };
  const std::string& name = config_.actuators[injection.actuator].name;
  switch (injection.kind) {
    case InjectionKind::kClientSet:
      checker_.OnClientRequest(injection.state);
      return client.SetState(injection.state, injection.random % 8 == 0 ? name : "");
    case InjectionKind::kClientRelease:
      return client.ReleaseEmergencyStop();
    case InjectionKind::kClientRestart:
      checker_.OnRestartRequest(name);
      return client.Restart(name);
    default:
      return client.GetStatus();
  }
}

void Scenario::ApplyToHosts(const Injection& injection) {
  const std::size_t from = injection.host;
  const std::size_t to = injection.other_host;
  if (injection.kind == InjectionKind::kReboot) {
    if (robot_.systemds() == nullptr || injection.random % 2 == 0) {
      return Reboot(from, injection.lasts);
    }
    robot_.systemds()->ShutDown(from);  // in an orderly way
    // Whatever ends from now on has ended with its host.
    for (const ActuatorConfig& actuator : config_.actuators) checker_.OnCrash(actuator.name);
    return Later(kShutsDownWithin, [this, from, lasts = injection.lasts] { Reboot(from, lasts); });
  }
  const auto set = [this, from, to,
                    both = injection.kind == InjectionKind::kHostPartition](bool blocked) {
    robot_.hosts().SetHostBlocked(from, to, blocked);
    if (both) robot_.hosts().SetHostBlocked(to, from, blocked);
  };
  set(true);
  Later(injection.lasts, [set] { set(false); });
}

// After the reboot the actuators that are started by hand, and a controller that ran on the host,
// start again.
void Scenario::Reboot(std::size_t host, Duration lasts) {
  bool had_controller = false;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* controller = robot_.controller(which);
    had_controller |= controller != nullptr && controller->host() == host;
  }
  robot_.RebootHost(host);
  Later(lasts, [this, host, had_controller] {
    robot_.BootHost(host);
    StartPermits();
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      if (IsByHand(i) && robot_.layout().HostOf(i) == host) StartByHand(i);
    }
    if (robot_.layout().controllers[1] == host) robot_.StartStandby();
    const bool here = robot_.layout().controllers[0] == host;
    if (had_controller && robot_.MayStartFirst()) {
      StartController(supervised_ && here ? Starter::kBoot : Starter::kPerson);
    }
  });
}

void Scenario::ApplyNetworkFaults() {
  LinkFaults faults;
  if (network_faults_[0] > 0) faults.loss = 0.2;
  if (network_faults_[1] > 0) faults.delay_max = Milliseconds(80);
  if (network_faults_[2] > 0) faults.duplication = 0.3;
  if (network_faults_[3] > 0) faults.reordering = 0.3;
  robot_.network().SetFaults(faults);
  const bool any = std::any_of(network_faults_.begin(), network_faults_.end(),
                               [](int active) { return active > 0; });
  checker_.OnLinkFaults(any);
  if (other_) other_->checker().OnLinkFaults(any);
}

void Scenario::ApplyToController(const Injection& injection) {
  if (injection.kind != InjectionKind::kWallClock) {
    checker_.OnControllersBlocked(injection.kind == InjectionKind::kFullDisk ||
                                  injection.kind == InjectionKind::kStalledDisk);
  }
  switch (injection.kind) {
    case InjectionKind::kControllerCrash: {
      // A supervisor restarts only a controller that crashed on its own host.
      const bool restarted = supervised_ && (robot_.controller(0) != nullptr || robot_.OneHost());
      config_.failover ? robot_.CrashLeader() : robot_.CrashController();
      const Starter starter = restarted ? Starter::kSupervisor : Starter::kPerson;
      return Later(injection.lasts, [this, starter] {
        if (robot_.MayStartFirst()) StartController(starter);
        robot_.StartStandby();
      });
    }
    case InjectionKind::kStalledDisk:
      robot_.StallDisk(true);
      return Later(injection.lasts, [this] { robot_.StallDisk(false); });
    case InjectionKind::kControllerFreeze:
      robot_.FreezeController();
      return Later(injection.lasts, [this] { robot_.ThawController(); });
    case InjectionKind::kRival:
      return robot_.StartRival(false);
    case InjectionKind::kTakeover:
      return robot_.StartRival(true);
    case InjectionKind::kFullDisk:
      robot_.FillDisk(true);
      return Later(injection.lasts, [this] { robot_.FillDisk(false); });
    default:
      return robot_.JumpWallClock(
          Milliseconds(static_cast<std::int64_t>(injection.random % 7'200'000)) -
          std::chrono::hours(1));
  }
}

void Scenario::RequestSwitch(const State& target, const std::optional<std::string>& actuator) {
  SimulatedController* leader = robot_.leader();
  if (leader == nullptr || leader->frozen) return;
  const std::uint64_t request = checker_.OnRequest(*leader, target);
  leader->shell().SetState(target, actuator, [this, request](const SwitchResult& result) {
    ++ending_.switches[static_cast<std::size_t>(result.outcome)];
    Mix(std::string(OutcomeName(result.outcome)));
    checker_.OnReply(request, result);
  });
}

// --- the operator, who repairs the robot, recovers it and switches it off ---

// The operator releases the stop, starts what nothing else starts again, and recovers the machine
// to its home state.
void Scenario::Repair() {
  if (config_.policy) {
    Note("the operator charges the battery");
    robot_.SetBattery(100, true);
    RunFor(std::chrono::seconds(3));  // three samples
    if (!ReachStableState("after the battery was charged")) return;
  }
  // The TearDown of a client that found no controller may reach the first one that starts.
  for (int tries = 0; tries < 3 && robot_.machine().phase == Phase::kStopped; ++tries) {
    Note("the machine was torn down; the operator starts it again");
    if (tries > 0) EndTornDown();
    robot_.CrashController();
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      if (!IsByHand(i)) continue;
      robot_.CrashActuator(config_.actuators[i].name);
      StartByHand(i);
    }
    StartController();
    if (!ReachStableState("after its start")) return;
  }
  for (int tries = 0; tries < 8 && robot_.machine().emergency.stop; ++tries) {
    Note("the operator releases the emergency stop");
    robot_.ReleaseEmergencyStop();
    RunFor(std::chrono::seconds(1));  // another one may be engaged as well
    if (Over() || !ReachStableState("after the release")) return;
  }
  RepairActuators();
  if (!ReachStableState("after its repair")) return;
  if (RecoverHome() && !Over()) CheckAllAvailable();
}

// A start finishes a TearDown that it finds. A process of another host that hangs in it, which no
// controller can kill, is ended by the operator.
void Scenario::EndTornDown() {
  bool any = false;
  for (const ActuatorConfig& actuator : config_.actuators) {
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(actuator.name, host);
      const bool hangs = report != nullptr && report->target == kTearDown;
      if (!hangs || host == robot_.layout().controllers[0]) continue;
      Note("the operator ends " + actuator.name + " on host " + robot_.hosts().name(host));
      robot_.processes().End(actuator.name, host, {ProcessExit::Kind::kKilled, SIGKILL});
      any = true;
    }
  }
  if (any) RunFor(kUntilMissed);
}

// The operator starts a controller where none is left: of two, each may have been replaced.
bool Scenario::ReachStableState(const std::string& when) {
  const auto none_runs = [this] {
    const SimulatedController* second = robot_.controller(1);
    return !robot_.controller(0) && (second == nullptr || second->stands_by());
  };
  for (int tries = 0; tries < 3; ++tries) {
    RunUntil([&] { return checker_.AtRest() || none_runs(); }, options_.bound);
    if (Over() || !none_runs()) break;
    Note("no controller runs; the operator starts one");
    StartController();
  }
  if (!checker_.AtRest()) {
    checker_.ReportViolation(Invariant::kReachesStableState, "the machine is not stable " + when +
                                                                 ": " + checker_.PendingActivity());
  }
  return !Over();
}

void Scenario::RepairActuators() {
  const bool frozen = EndFrozen();
  if (EndSurplus() || frozen) RunFor(kUntilMissed);
  const auto* leader = robot_.leader();
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (leader == nullptr) break;
    const ActuatorIndex process = robot_.layout().ProcessOf(i);
    const ActuatorConfig& actuator = config_.actuators[process];
    const KnownActuator& known = leader->shell().machine().actuators[i];
    const ActuatorReport* report = robot_.ReportOf(i, known.report);
    const bool finished = (report != nullptr && report->state == kTearDown) ||  // it may run
                          checker_.ReportsTearDownFalsely(config_.actuators[i].name);
    // Its last status was false: where none commands it, only its successor corrects that.
    const bool lies = report != nullptr && report->state != known.report.state;
    const bool well = report != nullptr && !report->busy() && !known.fault && !finished && !lies;
    if (well) continue;
    Note("the operator restarts " + actuator.name);
    EndElsewhere(actuator);
    if (!actuator.command.empty()) {
      checker_.OnRestartRequest(actuator.name);
      robot_.Restart(actuator.name);
      continue;
    }
    robot_.CrashActuator(actuator.name);
    RunFor(std::chrono::seconds(1));
    if (Over()) return;
    StartByHand(process);
  }
  RunFor(std::chrono::seconds(15));
}

// Ends the processes of the actuator on hosts other than the leading controller's.
void Scenario::EndElsewhere(const ActuatorConfig& actuator) {
  const std::size_t here = robot_.leader()->host();
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    const bool unit = !actuator.host.empty() && robot_.systemds()->RunsOn(host, actuator.name);
    if (actuator.command.empty() || host == here || unit) continue;
    if (!robot_.processes().IsAlive(actuator.name, host)) continue;
    robot_.processes().End(actuator.name, host, {ProcessExit::Kind::kKilled, SIGKILL});
    RunFor(kUntilMissed);
  }
}

// One of a later stage has no fault yet: the controller does not await it before its stage.
bool Scenario::EndFrozen() {
  bool any = false;
  for (const ActuatorConfig& actuator : config_.actuators) {
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const SimulatedProcesses& processes = robot_.processes();
      const bool alive = processes.IsAlive(actuator.name, host);
      if (!alive || !processes.IsFrozen(actuator.name, host)) continue;
      Note("the operator ends " + actuator.name + ", which is frozen");
      robot_.processes().End(actuator.name, host, {ProcessExit::Kind::kKilled, SIGKILL});
      any = true;
    }
  }
  return any;
}

// Where an actuator runs on several hosts, the operator keeps the process that the controller can
// restart.
bool Scenario::EndSurplus() {
  bool any = false;
  const std::size_t here = robot_.leader()->host();
  for (const ActuatorConfig& actuator : config_.actuators) {
    const bool by_controller =
        !actuator.command.empty() && robot_.processes().IsAlive(actuator.name, here);
    const std::size_t keep = by_controller ? here : robot_.processes().HomeOf(actuator.name);
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const bool surplus = host != keep && robot_.processes().CountOf(actuator.name) > 1;
      if (!surplus || !robot_.processes().IsAlive(actuator.name, host)) continue;
      Note("the operator ends " + actuator.name + " on host " + robot_.hosts().name(host));
      robot_.processes().End(actuator.name, host, {ProcessExit::Kind::kKilled, SIGKILL});
      any = true;
    }
  }
  return any;
}

bool Scenario::RecoverHome() {
  for (int tries = 0; tries < 3; ++tries) {
    const SimulatedController* leader = robot_.leader();
    if (leader == nullptr) {
      checker_.ReportViolation(Invariant::kReachesStableState, "no controller leads the machine");
      return false;
    }
    const State from = leader->shell().machine().state;
    auto path = FindPath(config_, from, options_.home);
    if (!path) {
      checker_.ReportViolation(
          Invariant::kRecoverable,
          "the machine is in " + from + ", from where no switch leads to " + options_.home);
      return false;
    }
    // A requested self-check includes the actuators that failed theirs. Half of the operators leave
    // it to the switch up.
    const bool up = tries == 0 && Scramble(seed_, 5, 5) % 2 == 0 && !path->empty();
    if (config_.HasState(kSelfCheck) && !up) path->insert(path->begin(), State(kSelfCheck));
    if (path->size() < 2 && from == options_.home) path->push_back(options_.home);
    for (const State& next : *path) {
      Note("the operator requests " + next);
      RequestSwitch(next);
      RunUntil([this] { return checker_.AtRest(); }, options_.bound);
      RunFor(std::chrono::seconds(2));
      if (Over()) return false;
    }
    const Machine& machine = robot_.machine();
    if (machine.state == options_.home && Degraded(config_, machine).empty()) return true;
  }
  return true;
}

void Scenario::CheckAllAvailable() {
  const Machine& machine = robot_.machine();
  if (machine.state != options_.home) {
    return checker_.ReportViolation(Invariant::kAllAvailableAfterRecovery,
                                    "after the repair and a switch to " + options_.home +
                                        ", the machine is in " + machine.state);
  }
  const auto degraded = Degraded(config_, machine);
  if (!degraded.empty()) {
    const ActuatorIndex i = *config_.IndexOf(degraded.front());
    return checker_.ReportViolation(
        Invariant::kAllAvailableAfterRecovery,
        "after the repair " + degraded.front() +
            " is still degraded: " + TroubleOf(machine.actuators[i])->message);
  }
  checker_.CheckRest(false);
  for (const ActuatorConfig& actuator : config_.actuators) {
    const ActuatorIndex i = *config_.IndexOf(actuator.name);
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    const std::string state = report == nullptr ? "not running" : "in " + report->state;
    if (report == nullptr || report->state != options_.home) {
      checker_.ReportViolation(Invariant::kAllAvailableAfterRecovery,
                               "after the repair " + actuator.name + " is " + state);
    } else if (report->held_by_stop) {
      checker_.ReportViolation(
          Invariant::kAllAvailableAfterRecovery,
          "after the repair " + actuator.name + " is held by an emergency stop that was released");
    }
  }
}

// It does not know yet then what runs: a process of its host is discovered after 1 to 5 ms.
void Scenario::RestartBeforeTheEnd() {
  Random random(Scramble(seed_, 11, 11));
  if (!random.Bernoulli(0.25) || robot_.leader() != robot_.controller(0)) return;
  Note("the controller is killed; the operator starts it again");
  robot_.CrashController();
  StartController();
  RunUntil([this] { return robot_.has_controller(); }, std::chrono::seconds(10));
  RunFor(random.Between({}, Milliseconds(4)));
}

void Scenario::SwitchOff() {
  if (!config_.HasState(kTearDown)) return;
  RestartBeforeTheEnd();
  if (Over()) return;
  Note("the operator switches the robot off");
  RequestSwitch(State(kTearDown));
  const auto stopped = [this] {
    return robot_.leader() != nullptr && robot_.machine().phase == Phase::kStopped;
  };
  if (!RunUntil(stopped, config_.shutdown_budget + Milliseconds(100))) {
    return checker_.ReportViolation(Invariant::kTearDownEndsProcesses,
                                    "the machine is not torn down within its budget");
  }
  RunFor(Milliseconds(100));
  checker_.CheckRest(false);
  if (robot_.systemds() == nullptr) return;
  RunFor(kUntilNothingStarts);
  checker_.CheckRest(false);
}

ScenarioOptions UsualOptions(const MachineConfig& config) {
  ScenarioOptions options;
  Duration longest{};
  Duration delay{};
  int restarts = 1;
  for (const ActuatorIndex i : config.actuators.Indices()) {
    Duration one{};
    for (const State& state : config.actuators[i].states) {
      one = std::max(one, config.TimeFor(i, state));
    }
    longest += one;  // as if each waited for the one before
    restarts = std::max(restarts, config.actuators[i].restart.limit);
    delay = std::max(delay, config.actuators[i].restart.max_delay);
  }
  options.bound = std::chrono::minutes(1) + 3 * (restarts + 1) * (longest + delay);
  for (const State& state : config.states) {
    const auto rank = config.RankOf(state);
    const bool higher = rank && (options.home.empty() || *rank > *config.RankOf(options.home));
    if (higher) options.home = state;
  }
  if (config.HasState(kActive)) options.home = State(kActive);
  return options;
}

}  // namespace musher::simulation
