#include "musher/lifecycle/switch/plan.hpp"

#include <algorithm>
#include <iterator>
#include <map>

#include "musher/base/joined.hpp"
#include "musher/base/suggest.hpp"
#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/policy/policy.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

std::string List(const std::vector<State>& names) {
  return Joined(names, "none");
}

Error NotPresent(const std::string& actuator, Presence presence) {
  switch (presence) {
    case Presence::kAbsent:
      return Refused<Refusal::kActuatorAbsent>(actuator);
    case Presence::kStarting:
      return Refused<Refusal::kActuatorStarting>(actuator);
    case Presence::kLost:
    case Presence::kPresent:
      break;
  }
  return Refused<Refusal::kActuatorLost>(actuator);
}

// SetUp, SelfCheck and Uninitialized count as less active than any state with a rank, except Error
// and TearDown.
Direction DirectionOf(const MachineConfig& config, const State& from, const State& to) {
  if (to == kSelfCheck) return Direction::kCheck;
  if (from == to) return Direction::kLevel;
  const auto from_rank = config.RankOf(from);
  const auto to_rank = config.RankOf(to);
  if (!from_rank) {
    return to == kError || to == kTearDown ? Direction::kDown : Direction::kUp;
  }
  if (!to_rank || *to_rank == *from_rank) return Direction::kLevel;
  return *to_rank > *from_rank ? Direction::kUp : Direction::kDown;
}

// For whom a switch is.
enum class By { kRequest, kPolicy, kSafety };

class Planner {
 public:
  Planner(const MachineConfig& config, const Machine& machine, const State& target,
          std::optional<ActuatorIndex> only, By by)
      : config_(config), machine_(machine), by_(by) {
    plan_.target = target;
    plan_.only = only;
    plan_.from = only ? machine.actuators[*only].state() : machine.state;
    plan_.direction = DirectionOf(config, plan_.from, target);
  }

  Plan Make() && {
    plan_.refusal = CheckTarget();
    if (plan_.refusal) return std::move(plan_);
    if (plan_.only) {
      AddSingle(*plan_.only);
    } else {
      for (const ActuatorIndex i : config_.actuators.Indices()) AddStep(i);
    }
    RefuseWhileStopped();
    RefuseWhileBusy();
    if (!plan_.refusal || plan_.free_by) OrderSteps();
    return std::move(plan_);
  }

 private:
  std::optional<Error> CheckTarget() const {
    const State& target = plan_.target;
    if (!config_.HasState(target)) {
      const std::string nearest = Nearest(target, config_.states);
      return Refused<Refusal::kUnknownState>(
          target.Shortened(), nearest.empty() ? "" : " did you mean '" + nearest + "'?",
          List(config_.states));
    }
    const std::string subject = plan_.only ? config_.actuators[*plan_.only].name : "the machine";
    if (machine_.phase == Phase::kIdle ||
        (!machine_.start_up.set_up && (target != kTearDown || plan_.only))) {
      return Refused<Refusal::kNotSetUp>();
    }
    if (machine_.phase == Phase::kFenced) {
      return Refused<Refusal::kLedByAnother>();
    }
    const bool ends = machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped;
    if (ends && !IsTearDownThatWaits()) {
      return Refused<Refusal::kMachineTornDown>();
    }
    // An actuator that is switching is checked again from the state it reaches.
    const bool on_its_way =
        plan_.only && machine_.actuators[*plan_.only].command && !machine_.current;
    const bool exempt = (by_ == By::kSafety && plan_.direction == Direction::kDown) || on_its_way;
    if (!exempt && !FlowAllows(config_, plan_.from, target)) {
      return NoTransition(subject);
    }
    return plan_.only ? std::nullopt : RefusalByPolicy(config_, machine_, target);
  }

  // The TearDown that was begun, once all actuators have announced themselves.
  bool IsTearDownThatWaits() const {
    return machine_.phase == Phase::kStopping && machine_.stopping->announced_by &&
           plan_.target == kTearDown && !plan_.only;
  }

  Error NoTransition(const std::string& subject) const {
    const State& from = plan_.from;
    if (const auto states = Reachable(config_, from); !states.empty()) {
      return Refused<Refusal::kNoTransition>(subject, from, plan_.target, List(states));
    }
    return Refused<Refusal::kFinalState>(subject, from, plan_.target, from,
                                         plan_.only ? Restart(config_.actuators[*plan_.only]) : "");
  }

  // ": `musher restart lamp` starts it again", if the controller starts it; else "".
  static std::string Restart(const ActuatorConfig& actuator) {
    if (actuator.command.empty()) return "";
    return ": `musher restart " + actuator.name + "` starts it again";
  }

  // The first reason is kept.
  void RefuseWith(const Error& refusal) {
    if (!plan_.refusal) plan_.refusal = refusal;
  }

  // During an emergency stop no actuator becomes more active. On the way down the actuators that
  // would have to come up for it refuse themselves.
  void RefuseWhileStopped() {
    if (!machine_.emergency.stop || plan_.direction == Direction::kDown) return;
    const bool rises =
        Rises(config_, plan_.from, plan_.target) ||
        std::any_of(plan_.steps.begin(), plan_.steps.end(), [&](const PlanStep& step) {
          return step.driven() && Rises(config_, step.from, plan_.target);
        });
    const bool resumes = SwitchesOnAgain(config_, plan_.from, plan_.target);
    if (!rises && !resumes) return;
    const std::string by = OriginOf(*machine_.emergency.stop);
    RefuseWith(rises ? Refused<Refusal::kStopForbidsUp>(by)
                     : Refused<Refusal::kStopHoldsMachine>(by, plan_.from));
  }

  // Being busy is temporary: it is the reason only where there is no other.
  void RefuseWhileBusy() {
    if (plan_.refusal || !busy_) return;
    plan_.refusal = busy_;
    if (busy_ends_) plan_.free_by = free_by_;
  }

  void NoteBusy(ActuatorIndex i, const Error& busy) {
    const KnownActuator& known = machine_.actuators[i];
    if (!busy_) busy_ = busy;
    const auto end = known.command ? known.command->deadline : known.free_by;
    busy_ends_ = busy_ends_ && end.has_value() && !machine_.current;
    free_by_ = std::max(free_by_, end.value_or(free_by_));
  }

  PlanStep Blank(ActuatorIndex i) const {
    PlanStep step;
    step.actuator = i;
    step.from = machine_.actuators[i].state();
    step.target = plan_.target;
    step.deadline = config_.TimeFor(i, plan_.target);
    return step;
  }

  void AddSingle(ActuatorIndex i) {
    const ActuatorConfig& actuator = config_.actuators[i];
    const KnownActuator& known = machine_.actuators[i];
    const auto rank = config_.RankOf(plan_.target);
    if (known.presence != Presence::kPresent) {
      RefuseWith(NotPresent(actuator.name, known.presence));
    } else if (!actuator.Lists(plan_.target)) {
      RefuseWith(
          Refused<Refusal::kStateUnsupported>(actuator.name, plan_.target, List(actuator.states)));
    } else if (known.restart.requested) {
      RefuseWith(Refused<Refusal::kActuatorRestarting>(actuator.name));
    } else if (known.report.busy() || known.command) {
      NoteBusy(i, Refused<Refusal::kActuatorBusy>(actuator.name, BusyWith(known)));
    } else if (rank && plan_.target != kTearDown && IsTooActive(known)) {
      RefuseWith(Refused<Refusal::kMoreActiveThanMachine>(actuator.name, machine_.state));
    } else if (rank && plan_.direction == Direction::kUp && !known.checked) {
      RefuseWith(Refused<Refusal::kUnchecked>(actuator.name));
    } else if (plan_.direction == Direction::kUp && known.suspended) {
      RefuseWith(Refused<Refusal::kSuspended>(actuator.name));
    }
    PlanStep step = Blank(i);
    if (plan_.target != kSelfCheck && IsInTarget(known)) {
      step.part = PlanStep::Part::kInTarget;
    }
    plan_.steps.push_back(step);
  }

  // Whether the target is above the machine. In a step of a start every target is, unless the
  // actuator would go down.
  bool IsTooActive(const KnownActuator& known) const {
    if (config_.RankOf(machine_.state)) return Falls(config_, plan_.target, machine_.state);
    return !Falls(config_, known.state(), plan_.target);
  }

  // Whether it is in the target without running its callback. An actuator that is held by an
  // emergency stop reports that state, and what the state had switched on is off.
  bool IsInTarget(const KnownActuator& known) const {
    if (plan_.target == kTearDown && known.state() == kTearDown) return true;  // the last state
    return known.state() == plan_.target && !known.fault && !known.report.held_by_stop;
  }

  static State BusyWith(const KnownActuator& known) {
    return known.command ? known.command->target : known.report.target;
  }

  void AddStep(ActuatorIndex i) {
    const ActuatorConfig& actuator = config_.actuators[i];
    const KnownActuator& known = machine_.actuators[i];
    const bool up = plan_.direction == Direction::kUp;
    const bool checking = plan_.direction == Direction::kCheck;
    PlanStep step = Blank(i);
    const auto leave_out = [&](const std::string& why) {
      step.part = PlanStep::Part::kLeftOut;
      step.note = why;
    };
    const bool blocks = up && actuator.critical;
    if (known.presence != Presence::kPresent) {
      const bool loading = !known.fault && known.presence != Presence::kLost;
      leave_out(loading ? "is still starting" : "is not available");
      if (blocks && !loading) {
        RefuseWith(Refused<Refusal::kCriticalUnavailable>(actuator.name, Restart(actuator)));
      }
    } else if (known.state() == kTearDown && plan_.target != kTearDown) {
      // Its process still runs, with other actuators in it.
      leave_out("is torn down; only a new start brings it back");
      if (blocks) RefuseWith(Refused<Refusal::kCriticalTornDown>(actuator.name));
    } else if (known.restart.requested && plan_.target != kTearDown) {
      leave_out("is being restarted");
    } else if (LateActuators(known)) {
      leave_out("is still starting");
    } else if (!actuator.Lists(plan_.target)) {
      step.part = PlanStep::Part::kUnsupported;
      step.note = "has no state '" + plan_.target + "'";
      if (up) RefuseWith(Refused<Refusal::kStateMissing>(actuator.name, plan_.target));
    } else if (StaysHeld(known)) {
      step.part = PlanStep::Part::kStaysHeld;
      step.note = known.state() == known.kept_in
                      ? "stays in " + known.kept_in + ", where it is held"
                      : "stays in " + known.state() + ": a person holds it in " + known.kept_in;
    } else if (checking && StartsByItself() && known.held && known.kept_in == kError) {
      leave_out("is held in Error");
    } else if (checking && StartsByItself() && FailedSetUp(i)) {
      leave_out("could not be configured");
    } else if (!checking && plan_.target != kTearDown && !known.checked && (up || !AtRest(known)) &&
               !LeavesError(known) && !IsConfiguredByIt(i) && !InCheckBeforeError(known)) {
      leave_out("has not passed its self-check");
      if (blocks) RefuseWith(Refused<Refusal::kCriticalUnchecked>(actuator.name));
    } else if (!checking && known.suspended && Rises(config_, known.state(), plan_.target)) {
      leave_out("is suspended until the actuators in its binds_to are up");
    } else if (by_ == By::kSafety && known.found_below && !known.set_again &&
               Rises(config_, known.state(), plan_.target)) {
      leave_out("was found less active, and no fallback raises it");
    } else if (!checking && IsInTarget(known) && !known.report.busy() && !known.command) {
      step.part = known.held ? PlanStep::Part::kHeldInTarget : PlanStep::Part::kInTarget;
    } else if (!checking && Unknown(actuator, known)) {
      leave_out("has not answered " + known.report.target + " and cannot be queried");
      if (blocks) {
        RefuseWith(Refused<Refusal::kCriticalSilent>(actuator.name, known.report.target));
      }
    } else if (up && !machine_.current && (known.report.busy() || known.command)) {
      step.note = "is still busy with " + BusyWith(known);
      NoteBusy(i, Refused<Refusal::kActuatorStillBusy>(actuator.name, BusyWith(known)));
    }
    plan_.steps.push_back(step);
  }

  // Whether it is held below the target by a person, and the switch is none that raises it.
  bool StaysHeld(const KnownActuator& known) const {
    const bool raises = by_ == By::kRequest && plan_.direction != Direction::kDown;
    // It may have gone up since, or be on its way.
    const bool above = Falls(config_, known.state(), plan_.target) ||
                       Falls(config_, BusyWith(known), plan_.target);
    // A fallback to another state that is as active may be what the robot needs.
    const bool apart =
        plan_.direction == Direction::kDown
            ? Falls(config_, plan_.target, known.kept_in)
            : known.kept_in != plan_.target && !Rises(config_, plan_.target, known.kept_in);
    return !raises && !above && !known.kept_in.empty() && apart;
  }

  // A late actuator in its first self-check is left out, unless the machine is ended. A switch up
  // waits for an actuator that has passed before.
  bool LateActuators(const KnownActuator& known) const {
    return known.command && known.command->target == kSelfCheck && !known.checked &&
           !machine_.current && plan_.target != kTearDown && plan_.target != kError;
  }

  // It goes to Error with the others once its self-check has ended.
  bool InCheckBeforeError(const KnownActuator& known) const {
    return plan_.target == kError && known.command && known.command->target == kSelfCheck;
  }

  // A ROS 2 node whose configuration was just requested and has failed.
  bool FailedSetUp(ActuatorIndex i) const {
    return IsUnconfigured(config_, i, machine_.actuators[i]) && machine_.actuators[i].fault;
  }

  // Whether this switch configures the node as its first step. The switch after the self-check of a
  // start does not, because the node has just failed that self-check; nor does a switch down.
  bool IsConfiguredByIt(ActuatorIndex i) const {
    return IsUnconfigured(config_, i, machine_.actuators[i]) && !StartsByItself() &&
           plan_.direction != Direction::kDown;
  }

  bool StartsByItself() const {
    return machine_.phase == Phase::kStarting && !machine_.start_up.by_hand;
  }

  // Leaving Error by the command of an earlier controller, while the machine stays in Error.
  bool LeavesError(const KnownActuator& known) const {
    return plan_.target == kError && known.state() == kError && known.report.busy();
  }

  // Overdue, with a protocol that has no query: nothing more is sent to it until it answers.
  static bool Unknown(const ActuatorConfig& actuator, const KnownActuator& known) {
    return !HasQuery(actuator.protocol) && known.fault && known.report.busy() && !known.command;
  }

  // In a state with a rank, not in a step of a start or in Error.
  bool AtRest(const KnownActuator& known) const {
    return config_.RankOf(known.state()) && known.state() != kError;
  }

  const PlanStep* DrivenStep(ActuatorIndex actuator) const {
    const auto found = std::find_if(plan_.steps.begin(), plan_.steps.end(), [&](const PlanStep& s) {
      return s.actuator == actuator && s.driven();
    });
    return found == plan_.steps.end() ? nullptr : &*found;
  }

  // The driven actuators that `i` waits for on the way up: its `after`. An actuator in `after` that
  // is not driven is replaced by its own `after`. `seen` keeps a diamond from being walked twice.
  void CollectNeeds(ActuatorIndex i, PerActuator<bool>& seen,
                    std::vector<ActuatorIndex>& needs) const {
    for (const std::string& name : config_.actuators[i].after) {
      const ActuatorIndex other = *config_.IndexOf(name);
      if (seen[other]) continue;
      seen[other] = true;
      if (DrivenStep(other) != nullptr) {
        needs.push_back(other);
      } else {
        CollectNeeds(other, seen, needs);
      }
    }
  }

  void OrderSteps() {
    PerActuator<std::vector<ActuatorIndex>> needs(config_.actuators.size());
    for (const PlanStep& step : plan_.steps) {
      if (!step.driven()) continue;
      PerActuator<bool> seen(config_.actuators.size(), false);
      std::vector<ActuatorIndex> found;
      CollectNeeds(step.actuator, seen, found);
      for (const ActuatorIndex other : found) {
        if (plan_.direction == Direction::kDown) {
          needs[other].push_back(step.actuator);
        } else {
          needs[step.actuator].push_back(other);
        }
      }
    }
    if (plan_.target == kTearDown) ReverseStages(needs);
    PerActuator<int> wave(config_.actuators.size(), 0);
    for (PlanStep& step : plan_.steps) {
      if (!step.driven()) continue;
      std::sort(needs[step.actuator].begin(), needs[step.actuator].end());
      step.needs = needs[step.actuator];
      step.wave = WaveOf(step.actuator, needs, wave);
    }
  }

  // A stage is torn down after the next stage that has actuators.
  void ReverseStages(PerActuator<std::vector<ActuatorIndex>>& needs) const {
    std::map<int, std::vector<ActuatorIndex>> stages;
    for (const PlanStep& step : plan_.steps) {
      if (step.driven()) stages[config_.actuators[step.actuator].stage].push_back(step.actuator);
    }
    for (auto stage = stages.begin(); stage != stages.end(); ++stage) {
      const auto next = std::next(stage);
      if (next == stages.end()) return;
      for (const ActuatorIndex i : stage->second) {
        for (const ActuatorIndex later : next->second) {
          if (std::find(needs[i].begin(), needs[i].end(), later) == needs[i].end()) {
            needs[i].push_back(later);
          }
        }
      }
    }
  }

  static int WaveOf(ActuatorIndex i, const PerActuator<std::vector<ActuatorIndex>>& needs,
                    PerActuator<int>& wave) {
    if (wave[i] == 0) {
      int deepest = 0;
      for (const ActuatorIndex other : needs[i])
        deepest = std::max(deepest, WaveOf(other, needs, wave));
      wave[i] = deepest + 1;
    }
    return wave[i];
  }

  const MachineConfig& config_;
  const Machine& machine_;
  const By by_;
  Plan plan_;
  std::optional<Error> busy_;  // the first busy actuator, and its callback
  bool busy_ends_ = true;
  Time free_by_{};
};

}  // namespace

bool IsUnconfigured(const MachineConfig& config, ActuatorIndex actuator,
                    const KnownActuator& known) {
  return config.actuators[actuator].protocol == Protocol::kRos2Lifecycle &&
         known.state() == config.default_state;
}

Plan MakePlan(const MachineConfig& config, const Machine& machine, const State& target,
              std::optional<ActuatorIndex> only) {
  return Planner(config, machine, target, only, By::kRequest).Make();
}

Plan MakePolicyPlan(const MachineConfig& config, const Machine& machine, const State& target) {
  return Planner(config, machine, target, std::nullopt, By::kPolicy).Make();
}

Plan MakeSafetyPlan(const MachineConfig& config, const Machine& machine, const State& target) {
  return Planner(config, machine, target, std::nullopt, By::kSafety).Make();
}

bool OnlyLowers(const MachineConfig& config, const Machine& machine, const Plan& plan) {
  if (plan.target == kTearDown || plan.target == kError) return true;
  const std::optional<Rank> to = config.RankOf(plan.target);
  if (plan.direction != Direction::kDown || !to) return false;
  return std::ranges::all_of(plan.steps, [&](const PlanStep& step) {
    if (!step.driven()) return true;
    // A command waits behind the present one of a busy actuator, and a plan that waits is made
    // again.
    const KnownActuator& known = machine.actuators[step.actuator];
    const State& next = known.command ? known.command->target : known.report.target;
    const bool waits_safely =
        next.empty() || next == plan.target || RaisesNothing(config.RankOf(next), *to);
    return waits_safely && RaisesNothing(config.RankOf(step.from), *to);
  });
}

}  // namespace musher
