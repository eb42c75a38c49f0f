#include "musher/simulation/promise.hpp"

namespace musher::simulation {

std::string_view PromiseText(Promise promise) {
  switch (promise) {
    case Promise::kNothingRises:
      return "nothing becomes more active because something failed";
    case Promise::kDoneIsDone:
      return "\"done\" means that all are there that are not listed as degraded";
    case Promise::kNothingStale:
      return "no stale command is executed";
    case Promise::kStopWins:
      return "nothing becomes more active during an emergency stop";
    case Promise::kOneAnswer:
      return "whoever asks is answered once";
    case Promise::kExplained:
      return "the journal tells of every state of the machine";
    case Promise::kNoSpinning:
      return "the next deadline is never in the past";
    case Promise::kComesToRest:
      return "the machine comes to rest when faults cease";
    case Promise::kOneTruth:
      return "at rest, who lives is where the machine is, or is listed with a reason";
    case Promise::kEndsWhenAsked:
      return "TearDown ends every process within its budget";
    case Promise::kNotInVain:
      return "who finds its configuration wrong is not started again until somebody asks";
    case Promise::kRunsOnce:
      return "no actuator runs twice";
    case Promise::kStopStays:
      return "an emergency stop stays until it is released, and then is over";
    case Promise::kStopIsSeen:
      return "an actuator that an emergency stop has switched off says so until it is on again";
    case Promise::kStaysDown:
      return "after an accepted TearDown only a person brings the machine up";
    case Promise::kDownIsDown:
      return "TearDown is \"done\" when no actuator lives above it";
    case Promise::kNotCancelled:
      return "an accepted command is cancelled by a newer one only";
    case Promise::kLeaderAnswers:
      return "only the controller that leads answers clients";
    case Promise::kClientHears:
      return "a client is told an outcome, or that there is none, within a bound";
    case Promise::kOnlyProven:
      return "a process is signalled when it is a child or holds the actuator's name";
    case Promise::kWithinBattery:
      return "nobody is more active than the battery allows";
    case Promise::kNoFlapping:
      return "the battery raises only whom it has taken down, beyond its hysteresis";
    case Promise::kPolicyWaits:
      return "the policy supersedes nobody";
    case Promise::kPowerComes:
      return "a power-off that was accepted comes in its time";
    case Promise::kSafeWithoutCritical:
      return "without a critical actuator the machine is in its on_lost, or less active";
    case Promise::kProvidedFor:
      return "for an actuator that is lost for good, on_lost says how the machine goes on";
    case Promise::kWayBack:
      return "from wherever it rests, people can bring the machine back";
    case Promise::kWholeAgain:
      return "and then all actuators are there";
  }
  return {};
}

bool DependsOnConfig(Promise promise) {
  return promise >= Promise::kSafeWithoutCritical || promise == Promise::kComesToRest;
}

}  // namespace musher::simulation
