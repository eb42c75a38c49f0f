#pragma once
// The emergency stops of the machine: several can be engaged at a time, each with an id. They are
// published first and saved after; one release ends all of them, and is over once every actuator
// has confirmed it.

#include "musher/lifecycle/step/saver.hpp"

namespace musher {

// "this user may not read it, user root may", "it cannot be read".
std::string WhyUnread(const UnreadFolder& unread);

// The stops of another state folder of the machine that hold beside `known`, the stops of its own
// folder: without stops that are released in `known`. A release in the other folder is not
// believed, as any user may have written it: a stop that is engaged in its own folder, in a third
// one or at the actuators stays engaged. A stop that another one has replaced there is over while
// that one is engaged. A stop without an id gets `unnamed`, unless that is 0. The machine waits for
// a request if it does there, until that is known here: it is among `released`, by an id that no
// stop has, which is another one each time that a stop is engaged there. A start there may have
// engaged a stop again that was released here, as its panel still publishes it.
StoredStops StopsThatHold(const StoredStops& known, StoredStops elsewhere, StopId unnamed);

class EmergencyStops : StepPart {
 public:
  EmergencyStops(StepContext& step, Saver& saver) : StepPart(step), saver_(saver) {}

  // Continues those that were stored, or received from other controllers and panels.
  void Begin(const event::Begin& begin);
  void On(const event::EmergencyStopSeen& seen);
  void On(const event::ReleaseRequested& requested);
  // An actuator may have latched a stop that this controller missed, or missed a release.
  void Compare(const ActuatorReport& report, ActuatorIndex i);
  // The same of a process that is not in use: only what it has latched counts.
  void CompareLatched(const ActuatorReport& report, ActuatorIndex i);
  // Ends a release that is confirmed, or whose time is over.
  void CheckRelease();
  // Ends the wait for a request once every actuator may switch on again after the last stop.
  void CheckRequested();
  // A person has requested to switch on again, and no stop is engaged.
  void TakeRequest();

 private:
  void CompareRelease(const ActuatorReport& report);
  void CompareOldest(const ActuatorReport& report, ActuatorIndex i);
  void EngageOthersOf(const ActuatorReport& report, ActuatorIndex i);
  bool IsReleased(StopId id) const;
  bool Add(const EmergencyStop& stop);
  void Engage(const EmergencyStop& stop);
  void PublishReleased();
  void PublishReleased(StopId id);
  bool HasConfirmed(ActuatorIndex i, StopId last) const;
  std::vector<std::string> Unconfirmed(StopId last) const;
  void EndRelease(const Result<>& result);

  Saver& saver_;
};

}  // namespace musher
