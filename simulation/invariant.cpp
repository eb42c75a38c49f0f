#include "musher/simulation/invariant.hpp"

namespace musher::simulation {

std::string_view InvariantText(Invariant invariant) {
  switch (invariant) {
    case Invariant::kNothingRises:
      return "nothing becomes more active because something failed";
    case Invariant::kDoneIsDone:
      return "\"done\" means that all are there that are not listed as degraded";
    case Invariant::kNothingStale:
      return "no stale command is executed";
    case Invariant::kStopWins:
      return "nothing becomes more active during an emergency stop";
    case Invariant::kOneAnswer:
      return "whoever asks is answered once";
    case Invariant::kExplained:
      return "the journal tells of every state of the machine";
    case Invariant::kNoSpinning:
      return "the next deadline is never in the past";
    case Invariant::kComesToRest:
      return "the machine comes to rest when faults cease";
    case Invariant::kOneTruth:
      return "at rest, who lives is where the machine is, or is listed with a reason";
    case Invariant::kEndsWhenAsked:
      return "TearDown ends every process within its budget";
    case Invariant::kNotInVain:
      return "who finds its configuration wrong is not started again until somebody asks";
    case Invariant::kRunsOnce:
      return "no actuator runs twice";
    case Invariant::kStopStays:
      return "an emergency stop stays until it is released, and then is over";
    case Invariant::kStopIsSeen:
      return "an actuator that an emergency stop has switched off says so until it is on again";
    case Invariant::kStaysDown:
      return "after an accepted TearDown only a person brings the machine up";
    case Invariant::kDownIsDown:
      return "TearDown is \"done\" when no actuator lives above it";
    case Invariant::kNotCancelled:
      return "an accepted command is cancelled by a newer one only";
    case Invariant::kLeaderAnswers:
      return "only the controller that leads answers clients";
    case Invariant::kClientHears:
      return "a client is told an outcome, or that there is none, within a bound";
    case Invariant::kOnlyProven:
      return "a process is signalled when it is a child or holds the actuator's name";
    case Invariant::kWithinBattery:
      return "nobody is more active than the battery allows";
    case Invariant::kNoFlapping:
      return "the battery raises only whom it has taken down, beyond its hysteresis";
    case Invariant::kPolicyWaits:
      return "the policy supersedes nobody";
    case Invariant::kPowerComes:
      return "a power-off that was accepted comes in its time";
    case Invariant::kSafeWithoutCritical:
      return "without a critical actuator the machine is in its on_lost, or less active";
    case Invariant::kProvidedFor:
      return "for an actuator that is lost for good, on_lost says how the machine goes on";
    case Invariant::kWayBack:
      return "from wherever it rests, people can bring the machine back";
    case Invariant::kWholeAgain:
      return "and then all actuators are there";
  }
  return {};
}

bool DependsOnConfig(Invariant invariant) {
  return invariant >= Invariant::kSafeWithoutCritical || invariant == Invariant::kComesToRest;
}

}  // namespace musher::simulation
