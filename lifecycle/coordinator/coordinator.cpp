#include "musher/lifecycle/coordinator/coordinator.hpp"

#include <algorithm>
#include <variant>

#include "musher/lifecycle/coordinator/authority.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"
#include "musher/lifecycle/policy/policy.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/lifecycle/rules/policy_requests.hpp"
#include "musher/lifecycle/supervision/binding.hpp"
#include "musher/lifecycle/supervision/fallback.hpp"
#include "musher/lifecycle/supervision/late_actuators.hpp"
#include "musher/lifecycle/supervision/recovery.hpp"
#include "musher/lifecycle/supervision/start_up.hpp"
#include "musher/lifecycle/switch/arrivals.hpp"

namespace musher {
namespace {

// Whether the rules of the policy are evaluated.
bool RulesApply(const MachineConfig& config, const Machine& machine) {
  return config.policy && (machine.phase == Phase::kStarting || machine.phase == Phase::kRunning ||
                           machine.phase == Phase::kFailed);
}

// The parts of one step, each after those that it uses.
class Coordinator : StepPart {
 public:
  explicit Coordinator(StepContext& step) : StepPart(step), step_(step) {}

  void Handle(const Event& event);
  // Handles deadlines, then does what has become possible. Ends every step.
  void FinishStep(const Event& event);
  // A fenced controller only answers requests, with a refusal.
  void Decline(const Event& event);
  // Records what the step has broken, if anything. The machine goes on: what a person sees of it,
  // and a stop, are worth more than a controller that ends.
  void ReportIfBroken();

 private:
  void On(const event::Begin& begin);
  void Advance();
  bool AdvanceSwitch();

  StepContext& step_;
  Saver saver_{step_};
  EmergencyStops stops_{step_, saver_};
  PolicyMemory memory_{step_, saver_};
  Power power_{step_, saver_};
  Processes processes_{step_};
  Commands commands_{step_, stops_, processes_};
  Control control_{step_, saver_, memory_, processes_};
  Arrivals arrivals_{step_, saver_, stops_, processes_, commands_, control_};
  Switches switches_{step_, memory_, commands_};
  TearDown tear_down_{step_, saver_, memory_, power_, commands_, switches_};
  Requests requests_{step_, commands_, switches_, tear_down_};
  StartUp start_up_{step_, saver_, stops_, switches_, tear_down_};
  Recovery recovery_{step_, processes_, commands_, control_};
  Binding binding_{step_};
  LateActuators late_{step_, commands_};
  Fallback fallback_{step_, memory_, switches_};
  PolicyRules rules_{step_, memory_, power_, switches_, tear_down_};
  PolicyRequests policy_requests_{step_,     saver_,     memory_,   power_,
                                  switches_, tear_down_, requests_, rules_};
  Authority authority_{step_, control_, switches_, tear_down_};
};

template <typename... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};
template <typename... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;  // for clang 14

void Coordinator::Handle(const Event& event) {
  std::visit(Overloaded{
                 [&](const event::Begin& e) { On(e); },
                 [&](const event::StatusSeen& e) {
                   if (!authority_.ReleaseIfReplaced(e.actuator, e.report)) arrivals_.On(e);
                 },
                 [&](const event::Replied& e) {
                   if (!authority_.ReleaseIfReplaced(e.actuator, e.report)) arrivals_.On(e);
                 },
                 [&](const event::Vanished& e) { arrivals_.On(e); },
                 [&](const event::ProcessStarted& e) { recovery_.On(e); },
                 [&](const event::ProcessNotStarted& e) { recovery_.On(e); },
                 [&](const event::ProcessesFound& e) { tear_down_.On(e); },
                 [&](const event::ProcessEnded& e) { recovery_.On(e); },
                 [&](const event::HealthChanged& e) { recovery_.On(e); },
                 [&](const event::BacktraceTaken& e) { recovery_.On(e); },
                 [&](const event::RestartRequested& e) { recovery_.On(e); },
                 [&](const event::RivalSeen& e) { authority_.On(e); },
                 [&](const event::EmergencyStopSeen& e) { stops_.On(e); },
                 [&](const event::ReleaseRequested& e) { stops_.On(e); },
                 [&](const event::SetStateRequested& e) { requests_.On(e); },
                 [&](const event::SetUpAwaited& e) { start_up_.On(e); },
                 [&](const event::BatterySeen& e) { rules_.On(e); },
                 [&](const event::BatterySourceSilent& e) { rules_.On(e); },
                 [&](const event::MotionSeen& e) { rules_.On(e); },
                 [&](const event::InputSilent& e) { rules_.On(e); },
                 [&](const event::ClockReceived& e) { rules_.On(e); },
                 [&](const event::PolicyRequested& e) { policy_requests_.On(e); },
                 [&](const event::SaveEnded& e) { saver_.On(e); },
                 [&](const event::StartExamined& e) { start_up_.On(e); },
                 [](const event::TimePassed&) {},
             },
             event);
}

void Coordinator::On(const event::Begin& begin) {
  start_up_.Begin(begin);
  stops_.Begin(begin);
  rules_.Begin(begin);
}

void Coordinator::FinishStep(const Event& event) {
  if (machine_.phase == Phase::kFenced) return;
  authority_.ReleaseIfReplacedElsewhere();
  if (machine_.phase == Phase::kFenced) return;
  arrivals_.CheckDeadlines();
  arrivals_.TakeUpOthers();
  // With other events, which may come late, the shell has not examined the processes yet.
  if (std::holds_alternative<event::TimePassed>(event)) start_up_.CheckDeadlines();
  recovery_.CheckDeadlines();
  stops_.CheckRelease();
  stops_.CheckRequested();
  Advance();
  saver_.NoteHosts();
  saver_.NoteActuators();
}

// Each can make the next one possible; the loop ends when all of them wait for an event.
void Coordinator::Advance() {
  const Phase& phase = machine_.phase;
  bool changed = true;
  while (changed) {
    changed = AdvanceSwitch();
    if (phase == Phase::kStopping) {
      changed |= tear_down_.BeginWaiting();
      tear_down_.Advance();
    } else if (phase != Phase::kIdle && phase != Phase::kStopped) {
      changed |= start_up_.StartProcesses();
      changed |= start_up_.Advance();
      changed |= requests_.BeginWaiting();
      changed |= binding_.SuspendAndResume();
      changed |= fallback_.Begin();
      changed |= rules_.Advance();
      // Last: what comes before may take the machine to another state.
      if (!changed) changed = late_.DriveLateOnes();
    }
  }
}

bool Coordinator::AdvanceSwitch() {
  if (tear_down_.WaitsForIntent()) return false;
  const Switches::Progress progress = switches_.Advance();
  if (const auto& ended = progress.ended) {
    if (ended->purpose == Purpose::kStop) {
      tear_down_.OnTornDown(ended->result);
    } else {
      start_up_.OnSwitchEnded(*ended);
    }
  }
  return progress.changed;
}

void Coordinator::ReportIfBroken() {
  const std::string broken = BrokenInvariant(config_, machine_);
  if (!broken.empty()) RecordMachine(kCodeFailed, texts::InvariantBroken(broken));
}

void Coordinator::Decline(const Event& event) {
  const Error fenced = Refused<Refusal::kLedByAnother>();
  const auto answer = [&](RequestId request) {
    step_.actions.emplace_back(action::AnswerCall{request, fenced});
  };
  if (const auto* requested = std::get_if<event::SetStateRequested>(&event)) {
    requests_.On(*requested);
  } else if (const auto* restart = std::get_if<event::RestartRequested>(&event)) {
    answer(restart->request);
  } else if (const auto* release = std::get_if<event::ReleaseRequested>(&event)) {
    answer(release->request);
  } else if (const auto* awaited = std::get_if<event::SetUpAwaited>(&event)) {
    answer(awaited->request);
  } else if (const auto* of_policy = std::get_if<event::PolicyRequested>(&event)) {
    answer(of_policy->request);
  }
}

// When samples of the battery, confirmed by their number, are confirmed by time, too.
std::optional<Time> NextConfirmation(const MachineConfig& config, const Machine& machine) {
  const PolicyState& policy = machine.policy;
  if (!RulesApply(config, machine) || !config.policy->battery) return std::nullopt;
  const BatteryPolicy& battery = *config.policy->battery;
  auto next = ConfirmedAt(policy.lifting, battery.raise_after);
  const auto empty = ConfirmedAt(policy.emptying, battery.tear_down_after);
  if (empty && !policy.empty) next = next ? std::min(*next, *empty) : *empty;
  return next;
}

// When the next command, take-control attempt or set-up deadline of one actuator is due.
std::optional<Time> NextDeadlineOf(const KnownActuator& known) {
  std::optional<Time> next;
  const auto consider = [&](Time when) { next = next ? std::min(*next, when) : when; };
  if (known.command) consider(known.command->deadline);
  if (known.control.again) consider(*known.control.again);
  if (known.set_up_by && known.presence != Presence::kPresent) consider(*known.set_up_by);
  for (const auto& when :
       {known.restart.at, known.restart.reset_at, known.free_by, known.exit_by}) {
    if (when) consider(*when);
  }
  if (const auto& termination = known.process.termination) {
    consider(std::min(termination->kill_at, termination->terminate_at.value_or(Time::max())));
  }
  return next;
}

}  // namespace

std::vector<Action> Step(const MachineConfig& config, Machine& machine, const Event& event,
                         Time now) {
  // A fault that a snapshot brought along is not the step's.
  const bool was_sound = BrokenInvariant(config, machine).empty();
  StepContext step{config, machine, now};
  Coordinator coordinator(step);
  if (machine.phase == Phase::kFenced) {
    coordinator.Decline(event);
  } else {
    coordinator.Handle(event);
    coordinator.FinishStep(event);
  }
  if (was_sound) coordinator.ReportIfBroken();
  return std::move(step.actions);
}

std::optional<Time> NextDeadline(const MachineConfig& config, const Machine& machine) {
  std::optional<Time> next;
  if (machine.phase == Phase::kFenced || machine.phase == Phase::kStopped) return next;
  const auto consider = [&](std::optional<Time> when) {
    if (when) next = next ? std::min(*next, *when) : *when;
  };
  const bool joins = machine.phase == Phase::kRunning && !machine.current && !machine.waiting;
  for (const KnownActuator& known : machine.actuators) {
    consider(NextDeadlineOf(known));
    if (joins) consider(known.failed_checks.at);
  }
  if (machine.phase == Phase::kStopping && machine.stopping) {
    const Shutdown& stopping = *machine.stopping;
    consider(stopping.intent_by);
    consider(stopping.announced_by);
    if (stopping.sent == Shutdown::Signal::kNone) consider(stopping.terminate_at);
    consider(stopping.sent == Shutdown::Signal::kKill ? stopping.give_up_at : stopping.kill_at);
  }
  if (machine.waiting) consider(machine.waiting->until);
  if (const auto& release = machine.emergency.release) {
    consider(std::min(release->again, release->until));
  }
  consider(NextPowerDeadline(machine));
  consider(NextConfirmation(config, machine));
  if (config.clock == ClockSource::kSteady) consider(NextPolicyDeadline(config, machine));
  return next;
}

std::optional<Time> NextPolicyDeadline(const MachineConfig& config, const Machine& machine) {
  if (!RulesApply(config, machine)) return std::nullopt;
  const PolicyState& policy = machine.policy;
  std::optional<Time> next;
  if (policy.keep) next = policy.keep->until;
  const bool waits = machine.current || policy.power || policy.retry_at;
  if (policy.still_since && config.policy->low_power && !waits) {
    const Time rests_at = *policy.still_since + config.policy->low_power->lying_still;
    next = next ? std::min(*next, rests_at) : rests_at;
  }
  return next;
}

}  // namespace musher
