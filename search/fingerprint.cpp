#include "musher/search/fingerprint.hpp"

#include <algorithm>
#include <bit>
#include <string_view>

#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/step/event.hpp"
#include "musher/search/reduction.hpp"

namespace musher::search {
namespace {

using fields::Base;
using fields::Field;
using fields::kFields;
using fields::Part;
using fields::Struct;

// The members that no decision depends on: texts, durations, records, and what waits for an answer.
template <class T>
inline constexpr std::tuple kIgnored = {};
template <>
inline constexpr std::tuple kIgnored<Error> = {&Error::message};
// The emergency stop matters when the report arrives, and then only where it is released; the pid
// and the host follow from the incarnation.
template <>
inline constexpr std::tuple kIgnored<ActuatorReport> = {&ActuatorReport::outcome_message,
                                                        &ActuatorReport::pid,
                                                        &ActuatorReport::host,
                                                        &ActuatorReport::config_hash,
                                                        &ActuatorReport::degraded_reason,
                                                        &ActuatorReport::emergency_stop,
                                                        &ActuatorReport::emergency_stop_by,
                                                        &ActuatorReport::emergency_stop_reason,
                                                        &ActuatorReport::released_stop,
                                                        &ActuatorReport::other_stops,
                                                        &ActuatorReport::stamp};
template <>
inline constexpr std::tuple kIgnored<EmergencyStop> = {&EmergencyStop::by, &EmergencyStop::reason};
template <>
inline constexpr std::tuple kIgnored<PendingCommand> = {&PendingCommand::sent,
                                                        &PendingCommand::clock_ahead};
template <>
inline constexpr std::tuple kIgnored<ActuatorFault> = {&ActuatorFault::message};
// Only the difference of the clocks counts. The others are added where they are read.
template <>
inline constexpr std::tuple kIgnored<KnownActuator> = {
    &KnownActuator::clock_theirs, &KnownActuator::clock_ours, &KnownActuator::join_tried,
    &KnownActuator::lost_in, &KnownActuator::cause};
template <>
inline constexpr std::tuple kIgnored<ControlState> = {&ControlState::incarnation};
template <>
inline constexpr std::tuple kIgnored<ActuatorGoal> = {&ActuatorGoal::actuator};
template <>
inline constexpr std::tuple kIgnored<Leg> = {&Leg::code, &Leg::message, &Leg::event, &Leg::started,
                                             &Leg::duration};
template <>
inline constexpr std::tuple kIgnored<SwitchResult> = {
    &SwitchResult::number,   &SwitchResult::target,   &SwitchResult::actuator,
    &SwitchResult::code,     &SwitchResult::reason,   &SwitchResult::state,
    &SwitchResult::degraded, &SwitchResult::actuators};
// Legs count with their actuators.
template <>
inline constexpr std::tuple kIgnored<Rollback> = {&Rollback::legs};
template <>
inline constexpr std::tuple kIgnored<Switch> = {&Switch::legs, &Switch::others, &Switch::cause};
// The requesters matter to a manager of ROS 2, and the search has none.
template <>
inline constexpr std::tuple kIgnored<WaitingSwitch> = {&WaitingSwitch::cause, &WaitingSwitch::by};
template <>
inline constexpr std::tuple kIgnored<Shutdown> = {&Shutdown::begun, &Shutdown::cause,
                                                  &Shutdown::by};
template <>
inline constexpr std::tuple kIgnored<Keep> = {&Keep::seconds};
template <>
inline constexpr std::tuple kIgnored<PowerDown> = {&PowerDown::cause, &PowerDown::by};
// Its clock is another one: its distance from now would make every state different.
template <>
inline constexpr std::tuple kIgnored<PolicyState> = {&PolicyState::clock,
                                                     &PolicyState::level_cause};
// It counts that there is a stop, and how many others there are. How often one was engaged matters
// to another state folder only.
template <>
inline constexpr std::tuple kIgnored<EmergencyStopState> = {
    &EmergencyStopState::stop, &EmergencyStopState::cause, &EmergencyStopState::others,
    &EmergencyStopState::engagements};
template <>
inline constexpr std::tuple kIgnored<PendingRelease> = {&PendingRelease::requests,
                                                        &PendingRelease::by};
template <>
inline constexpr std::tuple kIgnored<FallbackState> = {&FallbackState::cause};
// What is not on disk the model of the disk has. The actuators as stored are added where they are
// read.
template <>
inline constexpr std::tuple kIgnored<SavesState> = {&SavesState::last, &SavesState::unsaved,
                                                    &SavesState::actuators};
template <>
inline constexpr std::tuple kIgnored<Machine> = {
    &Machine::host,      &Machine::last_switch, &Machine::requested_by,  &Machine::standing,
    &Machine::actuators, &Machine::last_record, &Machine::recorded_state};

template <class T, class M>
constexpr bool IsIgnored(M T::*member) {
  const auto is = [&](auto ignored) {
    if constexpr (std::is_same_v<decltype(ignored), M T::*>) return ignored == member;
    return false;
  };
  return std::apply([&](auto... ignored) { return (is(ignored) || ...); }, kIgnored<T>);
}

std::uint64_t Scramble(std::uint64_t x) {
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  return x ^ x >> 32;
}

// Values in a fixed order; what varies in number is preceded by how many there are.
class Mixer {
 public:
  explicit Mixer(Time now) : now_(now) {}

  template <typename... T>
  void Add(const T&... values) {
    (One(values), ...);
  }
  Fingerprint Get() const { return {Scramble(high_), Scramble(low_ ^ high_)}; }

 private:
  void Word(std::uint64_t x) {
    high_ = (std::rotl(high_, 5) ^ x) * 0x9e3779b97f4a7c15U;
    low_ = (std::rotl(low_, 23) + x) * 0xd6e8feb86659fd93U;
    low_ ^= low_ >> 32;
  }
  template <typename T>
  requires(std::is_integral_v<T> || std::is_enum_v<T>) void One(const T& x) {
    Word(static_cast<std::uint64_t>(x));
  }
  template <typename Kind>
  void One(StrongNumber<Kind> number) {
    Word(number.value());
  }
  void One(std::string_view text) { Word(std::hash<std::string_view>{}(text)); }
  void One(Duration d) { Word(static_cast<std::uint64_t>(d.count())); }
  void One(Time t) { Word(static_cast<std::uint64_t>((t - now_).count())); }
  void One(const Fingerprint& f) {
    Word(f.high);
    Word(f.low);
  }
  template <typename T>
  void One(const std::optional<T>& x) {
    Word(x.has_value());
    if (x) One(*x);
  }
  template <typename T>
  void One(const std::vector<T>& all) {
    Word(all.size());
    for (const T& x : all) One(x);
  }

  template <typename T>
  void One(const PerActuator<T>& all) {
    for (const T& x : all) One(x);
  }

  template <Struct T>
  void One(const T& value) {
    std::apply([&](const auto&... fields) { (Member(value, fields), ...); }, kFields<T>);
  }
  template <class T, class M>
  void Member(const T& value, const Field<T, M>& field) {
    if (!IsIgnored(field.member)) One(value.*field.member);
  }
  template <class T, class M>
  void Member(const T& value, const Part<T, M>& part) {
    One(value.*part.member);
  }
  template <class T, class B>
  void Member(const T& value, const Base<B>& /*base*/) {
    One(static_cast<const B&>(value));
  }

  void One(const actuator_event::ControllerHeartbeatReceived& heartbeat) {
    Add(heartbeat.sender, heartbeat.epoch);
  }
  // Which controller has released it matters to the controllers' own "engaged", which the search
  // does not publish.
  void One(const ReleasedStop& released) { Add(released.id); }
  void One(const SwitchCommand& c) {
    // Its age by the actuator's clock.
    Add(c.epoch, c.number, c.target, c.budget, c.incarnation, c.detached);
    Add(ToMilliseconds(now_ - c.status_stamp - c.since_status));
  }
  void One(const QueryCommand& a) { Add(a.epoch, a.number, a.stop); }
  void One(const ActuatorCore::WaitingCommand& w) { Add(w.command, w.tokens, w.stopped); }
  void One(const Message& m) {
    Add(m.sender, m.epoch, m.what.index());
    std::visit([this](const auto& what) { One(what); }, m.what);
  }
  void One(const Request& r) { Add(r.target, r.replies, r.abandoned); }

  Time now_;
  std::uint64_t high_ = 1;
  std::uint64_t low_ = 2;
};

// A message under way from an actuator: of its stamp only whether the controller has a newer one
// counts.
void AddReply(Mixer& mixer, const KnownActuator& known, const event::Replied& r) {
  mixer.Add(r.number, r.query, r.verdict, r.report, r.report.emergency_stop,
            r.report.stamp < known.report.stamp);
}

void AddLate(Mixer& mixer, const KnownActuator& known, const std::vector<Late>& all) {
  mixer.Add(all.size());
  for (const Late& late : all) {
    mixer.Add(late.index());
    if (const auto* message = std::get_if<Message>(&late)) {
      mixer.Add(*message);
    } else if (const auto* reply = std::get_if<event::Replied>(&late)) {
      AddReply(mixer, known, *reply);
    } else if (const auto* seen = std::get_if<event::StatusSeen>(&late)) {
      mixer.Add(seen->report, seen->report.emergency_stop, seen->report.stamp < known.report.stamp);
    }
  }
}

// Whether its process has exited on the controller's host, and the controller knows that.
bool HasExited(const Model& model, const KnownActuator& known, ActuatorIndex i) {
  return model.host_of[i] == kHere && known.presence != Presence::kPresent && !known.command &&
         !known.control.again && known.report.incarnation != 0 &&
         known.report.incarnation == known.process.dead;
}

// Whether no other controller than those of the search can lead an actuator: no report has a higher
// epoch than the controller's.
bool LeadsAlone(const Model& model) {
  return model.hosts.empty() && !model.other_machine;
}

// The record of an actuator whose process has exited, without what no decision reads
// (fingerprint.hpp).
void AddExited(Mixer& mixer, const Model& model, const Machine& machine, KnownActuator exited) {
  ActuatorReport& report = exited.report;
  const bool has_taken = exited.control.incarnation == report.incarnation && exited.met;
  report.number = report.outcome_number = CommandNumber();
  report.outcome_code = kCodeOk;
  exited.writer_lost = false;
  if (machine.phase == Phase::kStopping) report.detached = false;
  if (LeadsAlone(model)) {
    mixer.Add(!has_taken && report.epoch >= machine.epoch);
    report.epoch = Epoch();
    exited.met = false;
  } else {
    mixer.Add(exited.control.incarnation);
  }
  mixer.Add(exited);
}

void AddRecord(Mixer& mixer, const Model& model, const World& world, ActuatorIndex i) {
  const Machine& machine = world.machine;
  if (machine.phase == Phase::kStopped) return;  // the controller handles nothing any more
  const KnownActuator& known = machine.actuators[i];
  mixer.Add(ToMilliseconds(known.clock_theirs - known.clock_ours));
  if (!model.reduces || MayReportLoss(model, world)) mixer.Add(known.lost_in);
  if (model.reduces && HasExited(model, known, i)) return AddExited(mixer, model, machine, known);
  const bool present = known.presence == Presence::kPresent;
  if (!model.reduces || present) mixer.Add(known.join_tried);
  if (model.reduces && LeadsAlone(model)) {
    mixer.Add(known.control.incarnation == known.report.incarnation);
  } else {
    mixer.Add(known.control.incarnation);
  }
  mixer.Add(known);
  if (known.command) mixer.Add(ToMilliseconds(known.command->clock_ahead));
}

void AddLegs(Mixer& mixer, const std::vector<Leg>& legs, ActuatorIndex i) {
  const auto found =
      std::find_if(legs.begin(), legs.end(), [i](const Leg& leg) { return leg.actuator == i; });
  mixer.Add(found == legs.end());
  if (found != legs.end()) mixer.Add(*found);
}

// Whether its process has exited on the controller's host, and nothing of it is under way.
bool LeavesNothing(const Model& model, const SimActuator& actuator, ActuatorIndex i) {
  return model.host_of[i] == kHere && !actuator.alive && !actuator.end && !actuator.status_due &&
         actuator.replies.empty();
}

// What the rules read of it: how it has ended, and whether it had done its part of the first
// request by then. Another controller answers that no more, and may use the same number again.
void AddEnded(Mixer& mixer, const World& world, const SimActuator& actuator) {
  const ActuatorReport& report = actuator.core.report;
  const auto& current = world.machine.current;
  const bool did = current && world.generation == 0 && report.outcome_number == current->number &&
                   report.outcome_code == kCodeOk;
  mixer.Add(report.state, report.held_by_stop, report.incarnation, did);
}

void AddProcess(Mixer& mixer, const KnownActuator& known, const SimActuator& a) {
  mixer.Add(a.alive, a.visible, a.work, a.stop_requested, a.energised, a.status_due, a.end, a.epoch,
            a.begun, a.queried);
  const ActuatorCore& c = a.core;
  mixer.Add(c.report, c.report.emergency_stop, c.report.released_stop, c.running_for,
            c.was_detached, c.waiting, c.unsettled, c.half_way_down, c.controller, c.announced,
            c.released, c.stops, c.last_before_release, c.stopped_meanwhile, c.under_stop);
  mixer.Add(a.replies.size());
  for (const event::Replied& reply : a.replies) AddReply(mixer, known, reply);
  mixer.Add(a.hung, a.hang_due, a.backtrace_due);
  mixer.Add(a.unit_report, a.wanted, a.await_by, a.killed, a.silent);
}

Fingerprint OfActuator(const Model& model, const World& world, ActuatorIndex i) {
  Mixer mixer(world.now);
  const Machine& machine = world.machine;
  const KnownActuator& known = machine.actuators[i];
  AddRecord(mixer, model, world, i);
  if (model.releases) {
    mixer.Add(known.report.emergency_stop, known.report.released_stop,
              known.report.other_stops.size());
  }
  if (machine.current) {
    AddLegs(mixer, machine.current->legs, i);
    AddLegs(mixer, machine.current->rollback.legs, i);
    for (const ActuatorResult& other : machine.current->others) {
      if (other.name == model.config.actuators[i].name) mixer.Add(other.outcome);
    }
  }
  const SimActuator& actuator = world.actuators[i];
  mixer.Add(machine.current && actuator.done == machine.current->number);
  const bool has_ended = model.reduces && LeavesNothing(model, actuator, i);
  mixer.Add(has_ended);
  if (has_ended) {
    AddEnded(mixer, world, actuator);
  } else {
    AddProcess(mixer, known, actuator);
  }
  AddLate(mixer, known, actuator.late);
  // Whether a controller that takes over finds that its process has ended.
  if (world.faults_left > 0) mixer.Add(world.disk.children.contains(i));
  for (std::size_t k = 0; k < world.outbox.size(); ++k) {
    if (world.outbox[k].to == i) mixer.Add(k, world.outbox[k]);
  }
  mixer.Add(model.kinds[i]);
  return mixer.Get();
}

void AddMachine(Mixer& mixer, const Model& model, const Machine& machine) {
  if (model.reduces && machine.phase == Phase::kStopped && machine.stopping) {
    Machine stopped = machine;
    stopped.stopping->result.reset();  // it was reported
    mixer.Add(stopped);
  } else {
    mixer.Add(machine);
  }
  mixer.Add(machine.policy.clock.time_since_epoch().count(), machine.emergency.stop.has_value(),
            machine.emergency.others.size());
}

}  // namespace

Identity IdentityOf(const Model& model, const World& w) {
  Mixer mixer(w.now);
  const Machine& m = w.machine;
  unsigned twins = 0;
  std::vector<Fingerprint> actuators;
  for (const ActuatorIndex i : w.actuators.Indices()) {
    const Fingerprint own = OfActuator(model, w, i);
    if (std::find(actuators.begin(), actuators.end(), own) != actuators.end())
      twins |= 1U << i.value();
    actuators.push_back(own);
  }
  std::sort(actuators.begin(), actuators.end());
  mixer.Add(actuators, w.faults_left, w.requests, w.from, w.generation, w.disk.epoch,
            w.disk.stop_intent, w.stays_down, w.at_start, w.stopped, w.stop_seen_due, w.released,
            w.repeat, w.battery, w.battery_due);
  for (const Link& link : w.links) mixer.Add(link.cut, link.silent_by, link.boots);
  AddMachine(mixer, model, m);
  // The next controller reads them, and there is one after a fault only.
  if (!model.reduces || w.faults_left > 0) mixer.Add(m.saves.actuators);
  // Once met or violated, it waits until the machine goes elsewhere, as is seen from the machine.
  for (const TimedRuleCheck& check : w.timed_checks) mixer.Add(check.due());
  return {mixer.Get(), twins};
}

}  // namespace musher::search
