#pragma once
// What is promised of every robot, whatever befalls it, and what is asked of a config.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/lifecycle/time.hpp"

namespace musher::simulation {

enum class Invariant : std::uint8_t {
  // Of the middleware.
  kNothingRises,   // nothing becomes more active because something failed
  kDoneIsDone,     // "done" means that all are there that are not listed as degraded
  kNothingStale,   // no command is executed late, twice, or for a controller that is over
  kStopWins,       // nothing becomes more active while an emergency stop is engaged
  kOneAnswer,      // whoever asks is answered once
  kExplained,      // the journal tells of every state of the machine
  kNoSpinning,     // the next deadline is never in the past
  kComesToRest,    // when faults cease, within the bound
  kOneTruth,       // at rest, who lives is where the machine is, or is listed with a reason
  kEndsWhenAsked,  // TearDown ends every process within its budget
  kNotInVain,      // what found its configuration wrong is started again when somebody asks only
  kRunsOnce,       // no actuator is started while it runs on another host, where that can be known
  kStopStays,      // an emergency stop stays until a controller releases it, and then is over
  kStopIsSeen,     // an actuator that a stop has switched off says so until it is on again
  kStaysDown,      // after an accepted TearDown only a person brings the machine up
  kDownIsDown,     // TearDown is "done" when no actuator lives above it
  kNotCancelled,   // an accepted command is cancelled by a newer one, or its time, and nothing else
  kLeaderAnswers,  // only the controller that leads answers clients
  kClientHears,    // a client is told an outcome, or that there is none, within a bound
  kOnlyProven,     // a process is signalled when it is a child or holds the actuator's name
  // Of the policy.
  kWithinBattery,  // nobody is more active than the battery allows
  kNoFlapping,     // the battery raises only whom it has taken down, beyond its hysteresis
  kPolicyWaits,    // the policy supersedes nobody
  kPowerComes,     // a power-off that was accepted comes in its time
  // Of the config as well.
  kSafeWithoutCritical,  // without a critical actuator the machine is in its on_lost or below
  kProvidedFor,          // for one that is lost for good, on_lost says how the machine goes on
  kWayBack,              // from wherever it rests, people can bring it back to where it was of use
  kWholeAgain,           // and then all are there
};
inline constexpr std::size_t kInvariants = 28;

std::string_view InvariantText(Invariant invariant);  // a sentence without its full stop
// Whether a config, rather than the middleware, can be the reason why it does not hold.
bool DependsOnConfig(Invariant invariant);

// A invariant that did not hold.
struct Violation {
  Invariant invariant = Invariant::kOneTruth;
  Duration at{};     // after the robot was switched on
  std::string what;  // a sentence
};

}  // namespace musher::simulation
