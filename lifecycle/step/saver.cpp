#include "musher/lifecycle/step/saver.hpp"

#include <algorithm>

namespace musher {
void Saver::Save(Stored what) {
  const SaveNumber save = ++machine_.saves.last;
  auto& unsaved = machine_.saves.unsaved;
  const auto found = std::find_if(unsaved.begin(), unsaved.end(),
                                  [what](const Unsaved& one) { return one.what == what; });
  if (found == unsaved.end()) {
    unsaved.push_back({what, save, now_, {}});
  } else {
    found->save = save;
  }
  switch (what) {
    case Stored::kEpoch:
      return Do(action::SaveEpoch{machine_.epoch, save});
    case Stored::kEmergencyStops:
      return Do(action::SaveEmergencyStops{StopsOf(machine_), save});
    case Stored::kPolicy:
      return Do(action::SavePolicy{machine_.policy.stored, save});
    case Stored::kStopIntent:
      return Do(action::SaveStopIntent{machine_.phase == Phase::kStopping, save});
    case Stored::kRemoteActuators:
      return Do(action::SaveRemoteActuators{RemoteActuators(), save});
    case Stored::kActuators:
      return Do(action::SaveActuators{machine_.saves.actuators, save});
    case Stored::kJournal:
      break;
  }
}

std::vector<RemoteActuator> Saver::RemoteActuators() const {
  std::vector<RemoteActuator> remote;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (Of(i).elsewhere) remote.push_back({ConfigOf(i).name, *Of(i).elsewhere});
  }
  return remote;
}

// Whether the actuator runs on another host, by its last status. Where its protocol names no host,
// it may be on another one with profile lan only.
bool Saver::IsElsewhere(ActuatorIndex i) const {
  const ActuatorReport& report = Of(i).report;
  const bool runs_here = Of(i).process.pid != 0 && Of(i).process.host.empty() && !RunsElsewhere(i);
  if (runs_here || report.incarnation == Of(i).process.dead || report.state == kTearDown) {
    return false;
  }
  // A Musher actuator exits after a failed SetUp.
  const bool not_set_up = report.state == config_.default_state && !report.busy();
  const bool exits = ConfigOf(i).protocol == Protocol::kMusher && report.outcome_code != kCodeOk;
  if (not_set_up && exits) return false;
  if (report.host.empty()) return config_.transport == TransportProfile::kLan;
  return !machine_.host.empty() && report.host != machine_.host;
}

void Saver::NoteHosts() {
  bool changed = false;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    if (known.report.incarnation == 0) continue;  // what an earlier controller has stored counts
    const bool elsewhere = IsElsewhere(i);
    const bool is_noted = known.elsewhere.has_value() == elsewhere &&
                          (!elsewhere || *known.elsewhere == known.report.host);
    if (is_noted) continue;
    known.elsewhere = elsewhere ? std::optional(known.report.host) : std::nullopt;
    changed = true;
  }
  if (changed) Save(Stored::kRemoteActuators);
}

// Whether it is on its way to a state that a person has requested of it alone. This controller may
// not see it arrive.
bool Saver::IsLedAlone(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  return known.command && known.command->detached && !known.restart.requested;
}

// Why this controller does not start the actuator again by itself.
StaysDown Saver::WhyDown(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  if (IsLedAlone(i) && known.command->target == kTearDown) return StaysDown::kTornDown;
  if (ConfigOf(i).command.empty())  // another party starts it, or the process of another actuator
    return known.down_requested ? StaysDown::kTornDown : StaysDown::kNo;
  const bool down = known.state() == kTearDown && (known.held || known.report.detached);
  if (down || (known.down_requested && known.presence != Presence::kPresent)) {
    return known.restart.requested || known.restart.at ? StaysDown::kNo : StaysDown::kTornDown;
  }
  const bool exited = ProcessOf(i) == 0 && known.report.incarnation == known.process.dead;
  const bool away = known.presence == Presence::kLost || known.presence == Presence::kAbsent;
  const bool has_ended = known.process.dead != 0 || known.process.ended_pid != 0;
  const bool waits = known.process.launch != Launch::kNone &&
                     !(known.process.launch == Launch::kFoundRunning && has_ended);
  const bool begins = waits || known.set_up_by || known.exit_by;
  const bool ended = away && exited && known.fault && !begins && !IsComing(i) && !IsTaken(i);
  return ended ? StaysDown::kGivenUp : StaysDown::kNo;
}

StoredActuator Saver::StoredOf(ActuatorIndex i) const {
  const auto& stored = machine_.saves.actuators;
  const auto found = std::ranges::find(stored, ConfigOf(i).name, &StoredActuator::name);
  return found == stored.end() ? StoredActuator{ConfigOf(i).name} : *found;
}

// A TearDown of the machine that a person requests brings every actuator down alike: the start
// after it starts them all. One that a supervisor or an upgrade requests is no decision of a
// person.
std::vector<StoredActuator> Saver::StoredActuators() const {
  const bool ends = machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped;
  const bool is_down = machine_.phase == Phase::kStopped;
  std::vector<StoredActuator> stored;
  if (is_down && machine_.stopping->after == AfterTearDown::kStaysDown) return stored;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const KnownActuator& known = Of(i);
    const StaysDown why = ends ? StaysDown::kNo : WhyDown(i);
    const bool is_led = IsLedAlone(i) && IsPlace(known.command->target);
    const State& kept_in = is_led ? known.command->target : known.kept_in;
    const bool is_usual = why == StaysDown::kNo && known.lost_in.empty() && kept_in.empty();
    if (!ends && is_usual) continue;  // in each step of most machines
    StoredActuator one{ConfigOf(i).name, why, {}, kept_in};
    if (ends) one = StoredOf(i);
    if (is_down && one.stays_down == StaysDown::kGivenUp) one.stays_down = StaysDown::kNo;
    one.lost_in = known.lost_in;
    if (one != StoredActuator{one.name}) stored.push_back(one);
  }
  // A person may have taken it out of the config, and may list it again.
  for (const StoredActuator& one : machine_.saves.actuators) {
    if (!config_.IndexOf(one.name)) stored.push_back(one);
  }
  return stored;
}

void Saver::NoteActuators() {
  std::vector<StoredActuator> stored = StoredActuators();
  if (stored == machine_.saves.actuators) return;
  machine_.saves.actuators = std::move(stored);
  Save(Stored::kActuators);
}

void Saver::On(const event::SaveEnded& ended) {
  auto& unsaved = machine_.saves.unsaved;
  auto found = std::find_if(unsaved.begin(), unsaved.end(), [&](const Unsaved& one) {
    return one.what == ended.what && one.save == ended.save;
  });
  if (found == unsaved.end() && ended.what == Stored::kJournal && !ended.ok) {
    found = unsaved.insert(found, Unsaved{ended.what, ended.save, now_, {}});
  }
  if (found == unsaved.end()) return;  // a newer save of the same counts
  const bool failed_before = !found->why.empty();
  if (ended.ok) {
    unsaved.erase(found);
    if (failed_before) RecordMachine(kCodeOk, texts::SaveRecovered(StoredName(ended.what)));
  } else {
    found->why = ended.why.empty() ? "failed" : ended.why;
    if (!failed_before) {
      RecordMachine(kCodeFailed, texts::SaveFailed(StoredName(ended.what), found->why));
    }
  }
  if (ended.what == Stored::kStopIntent && machine_.stopping) machine_.stopping->intent_by.reset();
}

}  // namespace musher
