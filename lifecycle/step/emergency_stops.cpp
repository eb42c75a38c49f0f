#include "musher/lifecycle/step/emergency_stops.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include "musher/base/checksum.hpp"
#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

// So many ids of emergency stops that are over are remembered, here and on disk.
constexpr std::size_t kMostReleasedKept = 256;
// The limit of the stops that are engaged beside the first. One more replaces the oldest stop
// without a source, else the oldest stop.
constexpr std::size_t kMostStopsKnown = 64;
// The limit of those that are received before Begin: more than can be known as released.
constexpr std::size_t kMostReceived = kMostReleasedKept + kMostStopsKnown;
// A release is published again after kReleaseRepeat and ends after kReleaseTime; a client waits
// longer.
constexpr Duration kReleaseRepeat = Milliseconds(500);
constexpr Duration kReleaseTime = Milliseconds(3000);
// A person releases what is shown: the reasons of one source are kept up to this length.
constexpr std::size_t kMostReasonBytes = 512;
constexpr std::string_view kThen = "; then: ";
constexpr std::string_view kMore = "more";

bool Names(const std::string& reasons, std::string_view reason) {
  for (std::size_t begin = 0; begin <= reasons.size();) {
    const std::size_t end = std::min(reasons.find(kThen, begin), reasons.size());
    if (std::string_view(reasons).substr(begin, end - begin) == reason) return true;
    begin = end + kThen.size();
  }
  return false;
}

// "smoke; then: hand in the gripper": a later cause of the same source counts as much as the first.
void AddReason(std::string& reasons, const std::string& reason) {
  if (reason.empty() || Names(reasons, reason)) return;
  if (reasons.empty() || Names(reason, reasons)) {
    reasons = reason;
    return;
  }
  if (Names(reasons, kMore)) return;
  const std::size_t size = reasons.size() + 2 * kThen.size() + reason.size() + kMore.size();
  reasons.append(kThen).append(size <= kMostReasonBytes ? reason : kMore);
}

// A stop that is over, as a newer one of its source is engaged in its place: the next release ends
// it at the actuators, too.
void AddReplaced(StoredStops& stops, StopId id) {
  AddReleased(stops, id);
  stops.replaced.push_back(id);
}

// Stands for the last stop of another state folder, among those that are over: that the machine
// waits for a request since it was last engaged there is known here. It is the id of no stop.
StopId MarkOf(StopId last, std::uint64_t engagements) {
  return StopId(Fnv1a("the last stop of another folder: " + ToString(last) + ", engagement " +
                      std::to_string(engagements)));
}

}  // namespace

std::string WhyUnread(const UnreadFolder& unread) {
  if (unread.owner.empty()) return "it cannot be read";
  return "this user may not read it, user " + unread.owner + " may";
}

void AddReleased(StoredStops& stops, StopId id) {
  auto& released = stops.released;
  std::erase(released, id);
  std::erase(stops.replaced, id);
  released.push_back(id);
  if (released.size() <= kMostReleasedKept) return;
  std::erase(stops.replaced, released.front());
  released.erase(released.begin());
}

bool AddStop(StoredStops& stops, const EmergencyStop& stop) {
  auto& engaged = stops.engaged;
  if (std::ranges::count(stops.released, stop.id) != 0) return false;
  if (const auto known = std::ranges::find(engaged, stop.id, &EmergencyStop::id);
      known != engaged.end()) {
    // An actuator that had latched it may have reported before the sample that engaged it arrived.
    if (!known->by.empty() || stop.by.empty()) return false;
    const auto same = std::ranges::find(engaged, stop.by, &EmergencyStop::by);
    if (same == engaged.end()) {
      *known = stop;
    } else {
      AddReplaced(stops, std::exchange(same->id, stop.id));
      AddReason(same->reason, stop.reason);
      engaged.erase(known);
    }
    return true;
  }
  const bool full = engaged.size() > kMostStopsKnown;
  // Two stops without a source may be of two sources: each is kept while there is room for it.
  const auto same = std::ranges::find(engaged, stop.by, &EmergencyStop::by);
  if (same != engaged.end() && (full || !stop.by.empty())) {
    AddReplaced(stops, same->id);
    same->id = stop.id;
    AddReason(same->reason, stop.reason);
    return true;
  }
  if (full) {
    const auto unnamed = std::ranges::find(engaged, "", &EmergencyStop::by);
    const auto replaced = unnamed != engaged.end() ? unnamed : engaged.begin();
    AddReplaced(stops, replaced->id);
    engaged.erase(replaced);
  }
  engaged.push_back(stop);
  return true;
}

// Also a stop that is released again before Begin() has switched something off: the machine awaits
// a request.
void AddReceived(StoredStops& received, EmergencyStop stop) {
  if (stop.id == 0) stop.id = kUnknownStop;
  received.awaits_request = true;
  auto& engaged = received.engaged;
  if (std::ranges::count(received.released, stop.id) != 0) return;
  if (const auto known = std::ranges::find(engaged, stop.id, &EmergencyStop::id);
      known != engaged.end()) {
    if (known->by.empty()) *known = std::move(stop);
    return;
  }
  if (engaged.size() >= kMostReceived) {
    const auto same = std::ranges::find(engaged, stop.by, &EmergencyStop::by);
    engaged.erase(same != engaged.end() ? same : engaged.begin());
  }
  engaged.push_back(std::move(stop));
}

void AddReceivedRelease(StoredStops& received, StopId id) {
  AddReleased(received, id);
  std::erase_if(received.engaged, [id](const EmergencyStop& stop) { return stop.id == id; });
}

StoredStops WithoutReleased(const StoredStops& stored, StoredStops received) {
  const auto is_known = [&](StopId id) {
    return id != kUnknownStop && std::ranges::count(stored.released, id) != 0;
  };
  std::erase_if(received.engaged, [&](const EmergencyStop& stop) { return is_known(stop.id); });
  std::erase_if(received.released, is_known);
  std::erase_if(received.replaced, is_known);
  if (received.engaged.empty() && received.released.empty()) received.awaits_request = false;
  return received;
}

StoredStops StopsThatHold(const StoredStops& known, StoredStops elsewhere, StopId unnamed) {
  const auto is_released = [&](StopId id) { return std::ranges::count(known.released, id) != 0; };
  for (EmergencyStop& stop : elsewhere.engaged) {
    if (stop.id == kUnknownStop && unnamed != 0) stop.id = unnamed;
  }
  StopId last = elsewhere.released.empty() ? kUnknownStop : elsewhere.released.back();
  if (!elsewhere.engaged.empty()) last = elsewhere.engaged.back().id;
  const StopId mark = MarkOf(last, elsewhere.engagements);
  const bool has_id = last != kUnknownStop;
  if (has_id && is_released(mark)) elsewhere.awaits_request = false;
  std::erase_if(elsewhere.engaged, [&](const EmergencyStop& stop) { return is_released(stop.id); });
  std::erase_if(elsewhere.replaced, [&](StopId id) {
    return elsewhere.engaged.empty() || is_released(id) ||
           std::ranges::count(known.engaged, id, &EmergencyStop::id) != 0;
  });
  elsewhere.released = elsewhere.replaced;
  if (has_id && elsewhere.awaits_request) elsewhere.released.push_back(mark);
  return elsewhere;
}

StoredStops Merge(const StoredStops& stored, const StoredStops& received) {
  StoredStops stops;
  stops.awaits_request = stored.awaits_request || received.awaits_request;
  stops.unread = stored.unread;
  stops.engagements = stored.engagements;
  stops.led_elsewhere = stored.led_elsewhere;
  for (const auto* from : {&stored, &received}) {
    for (const StopId id : from->released) AddReleased(stops, id);
  }
  // What one side has as released is not only replaced.
  const auto is_replaced = [&](StopId id) {
    return std::ranges::all_of(std::array{&stored, &received}, [&](const StoredStops* from) {
      return std::ranges::count(from->released, id) == std::ranges::count(from->replaced, id);
    });
  };
  std::ranges::copy_if(stops.released, std::back_inserter(stops.replaced), is_replaced);
  for (const auto* from : {&stored, &received}) {
    for (const EmergencyStop& stop : from->engaged) AddStop(stops, stop);
  }
  return stops;
}

// Both are published, so that a panel that still publishes "engaged" does not engage a released
// stop.
void EmergencyStops::Begin(const event::Begin& begin) {
  const StoredStops& stops = begin.stops;
  machine_.emergency.released = stops.released;
  machine_.emergency.replaced = stops.replaced;
  // A person who starts the machine requests its states, a supervisor does not.
  machine_.emergency.awaits_request =
      stops.awaits_request || (stops.led_elsewhere && machine_.start_up.by_supervisor);
  machine_.emergency.unread = stops.unread;
  machine_.emergency.engagements = stops.engagements;
  PublishReleased();
  for (const EmergencyStop& stop : stops.engaged) {
    if (Add(stop)) Engage(stop);
  }
  if (stops != StoredStops{}) saver_.Save(Stored::kEmergencyStops);
}

// Only the controller that leads releases a stop; the releases that other controllers published
// before came with Begin.
void EmergencyStops::On(const event::EmergencyStopSeen& seen) {
  if (machine_.phase == Phase::kIdle || !seen.engaged) return;
  EmergencyStop stop = seen.stop;
  if (stop.id == 0) stop.id = kUnknownStop;
  if (Add(stop)) Engage(stop);
}

// The stops are over at once; the request is answered when every actuator has confirmed that.
void EmergencyStops::On(const event::ReleaseRequested& requested) {
  auto& emergency = machine_.emergency;
  // It publishes no more, although its last replies may still be on their way.
  if (machine_.phase == Phase::kStopped) {
    return Do(action::AnswerCall{requested.request, Refused<Refusal::kStoppedMachine>()});
  }
  if (emergency.release && !emergency.stop) {
    return emergency.release->requests.push_back(requested.request);
  }
  if (!emergency.stop && Unconfirmed(0).empty()) {
    return Do(action::AnswerCall{requested.request, Refused<Refusal::kNoEmergencyStop>()});
  }
  StoredStops stops = StopsOf(machine_);
  const auto unseen = std::ranges::find_if(stops.engaged, [&](const EmergencyStop& stop) {
    return !requested.seen.empty() && std::ranges::count(requested.seen, stop.id) == 0;
  });
  if (unseen != stops.engaged.end()) {
    return Do(
        action::AnswerCall{requested.request, Refused<Refusal::kStopNotSeen>(OriginOf(*unseen))});
  }
  for (const EmergencyStop& stop : stops.engaged) AddReleased(stops, stop.id);
  // A release that is repeated for an actuator keeps the number: a switch may have been requested
  // since.
  if (emergency.stop) emergency.last_before_release = machine_.number;
  emergency.stop.reset();
  emergency.others.clear();
  emergency.released = std::move(stops.released);
  emergency.replaced.clear();
  const StopId last = emergency.released.empty() ? StopId(0) : emergency.released.back();
  emergency.release = PendingRelease{
      {requested.request}, requested.by, last, now_ + kReleaseRepeat, now_ + kReleaseTime};
  PublishReleased();
  saver_.Save(Stored::kEmergencyStops);
}

// Also releases the stops that newer stops have replaced: an actuator may have latched them.
void EmergencyStops::PublishReleased() {
  for (const StopId id : machine_.emergency.released) PublishReleased(id);
}

void EmergencyStops::PublishReleased(StopId id) {
  Do(action::PublishEmergencyStop{{id, "", ""}, false, machine_.emergency.last_before_release});
}

// Whether the actuator has received a whole release, up to its last stop `last`, and no process of
// it has latched a stop. An actuator that cannot be running has nothing to confirm.
bool EmergencyStops::HasConfirmed(ActuatorIndex i, StopId last) const {
  const KnownActuator& known = machine_.actuators[i];
  const ActuatorReport& report = known.report;
  if (ConfigOf(i).protocol != Protocol::kMusher) return true;
  // A second process: after a reboot of its host, while the process before the reboot still counts.
  if (known.other && known.other->emergency_stop != 0) return false;
  const bool clear = report.emergency_stop == 0;
  switch (known.presence) {
    case Presence::kPresent:
      return clear && (last == 0 || report.released_stop == last);
    case Presence::kStarting:
      return clear;
    case Presence::kLost: {
      // It may run on, and its last report is from before the release.
      const bool is_off = known.state() == kTearDown && report.target.empty();
      return (clear && (last == 0 || is_off)) || report.incarnation == known.process.dead;
    }
    case Presence::kAbsent: {
      // Its process was found by its name, and has not reported yet what it has latched; or it ran
      // on another host before this controller.
      const bool unheard = known.process.launch == Launch::kFoundRunning &&
                           known.process.pid != 0 && report.incarnation == 0;
      return last == 0 || !(unheard || known.elsewhere);
    }
  }
  return true;
}

std::vector<std::string> EmergencyStops::Unconfirmed(StopId last) const {
  std::vector<std::string> names;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (!HasConfirmed(i, last)) names.push_back(ConfigOf(i).name);
  }
  return names;
}

void EmergencyStops::CheckRelease() {
  auto& release = machine_.emergency.release;
  if (!release) return;
  if (const auto& stop = machine_.emergency.stop) {
    return EndRelease(Refused<Refusal::kStoppedAgain>(OriginOf(*stop)));
  }
  const std::vector<std::string> missing = Unconfirmed(release->last);
  if (missing.empty()) {
    RecordMachine(kCodeOk, texts::EmergencyStopReleased(release->by));
    return EndRelease(Ok());
  }
  if (now_ >= release->until) {
    const RecordText text = texts::ReleaseUnconfirmed(missing);
    RecordMachine(kCodeTimeout, text);
    return EndRelease(Error{kCodeTimeout, text.message});
  }
  if (now_ < release->again) return;
  release->again = now_ + kReleaseRepeat;
  PublishReleased();
}

void EmergencyStops::CheckRequested() {
  const EmergencyStopState& emergency = machine_.emergency;
  if ((!emergency.awaits_request && emergency.Unanswered() == nullptr) || emergency.stop) return;
  if (std::ranges::all_of(machine_.actuators, &KnownActuator::set_again)) TakeRequest();
}

void EmergencyStops::TakeRequest() {
  EmergencyStopState& emergency = machine_.emergency;
  if (!emergency.awaits_request && emergency.Unanswered() == nullptr) return;
  emergency.awaits_request = false;
  for (UnreadFolder& unread : emergency.unread) unread.answered = true;
  saver_.Save(Stored::kEmergencyStops);
}

void EmergencyStops::EndRelease(const Result<>& result) {
  const PendingRelease ended = *std::exchange(machine_.emergency.release, std::nullopt);
  for (const RequestId request : ended.requests) Do(action::AnswerCall{request, result});
}

// An actuator may have latched a stop that this controller missed. Then that stop is engaged for
// the machine, with all other stops that the actuator has latched, since one release covers them.
// The actuator may have missed a release. Then the release is published again, unless another stop
// is engaged, which the actuator may have missed.
void EmergencyStops::Compare(const ActuatorReport& report, ActuatorIndex i) {
  if (machine_.phase == Phase::kIdle) return;
  CompareRelease(report);
  CompareLatched(report, i);
}

void EmergencyStops::CompareLatched(const ActuatorReport& report, ActuatorIndex i) {
  if (machine_.phase == Phase::kIdle || report.emergency_stop == 0) return;
  CompareOldest(report, i);
  EngageOthersOf(report, i);
}

// A controller may miss a stop and its release altogether, for example on another host. What the
// stop has switched off waits for a request; so do the actuators that were restarted since and do
// not report it.
void EmergencyStops::CompareRelease(const ActuatorReport& report) {
  const StopId id = report.released_stop;
  if (!report.held_by_stop || id == 0 || machine_.emergency.stop || IsReleased(id)) return;
  machine_.emergency.awaits_request = true;
  if (!machine_.emergency.release) {  // which every actuator confirms by the last one
    StoredStops stops = StopsOf(machine_);
    AddReleased(stops, id);
    machine_.emergency.released = std::move(stops.released);
    machine_.emergency.replaced = std::move(stops.replaced);
  }
  saver_.Save(Stored::kEmergencyStops);
}

void EmergencyStops::CompareOldest(const ActuatorReport& report, ActuatorIndex i) {
  const StopId id = report.emergency_stop;
  if (IsReleased(id)) {
    if (!machine_.emergency.stop) PublishReleased(id);
    return;
  }
  const bool origin_known =
      !report.emergency_stop_by.empty() || !report.emergency_stop_reason.empty();
  const EmergencyStop stop{
      id, report.emergency_stop_by,
      origin_known ? report.emergency_stop_reason : ConfigOf(i).name + " had latched it"};
  if (Add(stop)) Engage(stop);
}

// One record for all of them: who engaged them is not known.
void EmergencyStops::EngageOthersOf(const ActuatorReport& report, ActuatorIndex i) {
  EmergencyStop last;
  for (const StopId id : report.other_stops) {
    const EmergencyStop stop{id, "", ConfigOf(i).name + " had latched it"};
    if (!IsReleased(id) && Add(stop)) last = stop;
  }
  if (last.id != 0) Engage(last);
}

bool EmergencyStops::Add(const EmergencyStop& stop) {
  StoredStops stops = StopsOf(machine_);
  if (!AddStop(stops, stop)) return false;
  machine_.emergency.stop = stops.engaged.front();
  machine_.emergency.others.assign(stops.engaged.begin() + 1, stops.engaged.end());
  machine_.emergency.released = std::move(stops.released);
  machine_.emergency.replaced = std::move(stops.replaced);
  return true;
}

bool EmergencyStops::IsReleased(StopId id) const {
  return std::ranges::count(machine_.emergency.released, id) != 0;
}

// The actuators have latched the stop themselves by now, or do so when they receive it from this
// controller. It is published first and saved after.
void EmergencyStops::Engage(const EmergencyStop& stop) {
  Do(action::PublishEmergencyStop{stop, true});
  ++machine_.emergency.engagements;
  machine_.emergency.awaits_request = true;
  machine_.start_up.requests_nothing = true;
  saver_.Save(Stored::kEmergencyStops);
  const RecordId recorded =
      RecordMachine(kCodeProtectedError, texts::EmergencyStopEngaged(stop.by, stop.reason),
                    machine_.emergency.others.empty() ? 0 : machine_.emergency.cause);
  if (machine_.emergency.others.empty()) machine_.emergency.cause = recorded;
  if (machine_.current) machine_.current->stopped = true;
  for (KnownActuator& known : machine_.actuators) known.set_again = false;
  // A ROS 2 node does not receive the stop. Its way up may take several transitions: after the one
  // that runs no further one is requested.
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const auto& command = Of(i).command;
    const bool goes_on = command && ConfigOf(i).protocol == Protocol::kRos2Lifecycle &&
                         MaySwitchOn(config_, Of(i).state(), command->target);
    if (goes_on) Do(action::SendQuery{i, {machine_.epoch, command->number, true}});
  }
}

}  // namespace musher
