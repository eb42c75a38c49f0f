#include "musher/test/search/fingerprint.hpp"

#include <algorithm>
#include <bit>
#include <string_view>

namespace musher::search {
namespace {

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

  // Without the emergency stop: it matters when the report arrives, and then only where it is
  // released.
  void One(const ActuatorReport& r) {
    Add(r.state, r.target, r.busy_number, r.epoch, r.number, r.outcome_number, r.outcome_code);
    Add(r.incarnation, r.detached, r.held_by_stop, r.degraded_code);
  }
  void One(const EmergencyStop& stop) { Add(stop.id); }
  void One(const Termination& t) { Add(t.pid, t.terminate_at, t.kill_at, t.killed); }
  void One(const PendingCommand& o) { Add(o.number, o.target, o.deadline, o.queries); }
  void One(const Leg& l) {
    Add(l.from, l.target, l.progress, l.outcome, l.ran, l.may_fail, l.needs);
  }
  void One(const actuator_event::ControllerHeartbeatReceived& heartbeat) {
    Add(heartbeat.sender, heartbeat.epoch);
  }
  void One(const SwitchCommand& c) {
    // Its age by the actuator's clock.
    Add(c.epoch, c.number, c.target, c.budget, c.incarnation, c.detached);
    Add(ToMilliseconds(now_ - c.status_stamp - c.since_status));
  }
  void One(const QueryCommand& a) { Add(a.epoch, a.number, a.stop); }
  void One(const ActuatorCore::Waiting& w) { Add(w.command, w.tokens); }
  void One(const Message& m) {
    Add(m.sender, m.epoch, m.what.index());
    std::visit([this](const auto& what) { One(what); }, m.what);
  }
  void One(const Lowering& l) { Add(l.from, l.to, l.epoch); }
  void One(const BatterySource& b) { Add(b.source, b.percent, b.charging); }
  void One(const LevelRun& r) { Add(r.level, r.since, r.samples, r.higher); }
  void One(const Keep& k) { Add(k.state, k.until, k.switch_number); }
  void One(const PowerDown& p) { Add(p.reboot, p.tear_down_at, p.force_at, p.commanded); }
  // The policy's clock is another one: its distance from now would make every state different.
  void One(const PolicyState& p) {
    Add(p.clock.time_since_epoch().count(), p.loaded, p.battery, p.charging, p.level,
        p.stored.low_power, p.stored.lowering, p.stored.level);
    Add(p.batteries, p.jump_recorded, p.doubled_recorded, p.lifting, p.emptying, p.empty);
    Add(p.withheld, p.low_power, p.still, p.still_since, p.keep, p.power, p.failures, p.retry_at);
    Add(p.battery_silent, p.invalid_recorded, p.calls);
  }
  void One(const Request& r) { Add(r.target, r.replies, r.abandoned); }

  Time now_;
  std::uint64_t high_ = 1;
  std::uint64_t low_ = 2;
};

// A message under way from an actuator: of its stamp only whether the controller has a newer one
// counts.
void AddReply(Mixer& mixer, const ActuatorRecord& record, const event::Replied& r) {
  mixer.Add(r.number, r.query, r.verdict, r.report, r.report.emergency_stop,
            r.report.stamp < record.report.stamp);
}

void AddLate(Mixer& mixer, const ActuatorRecord& record, const std::vector<Late>& all) {
  mixer.Add(all.size());
  for (const Late& late : all) {
    mixer.Add(late.index());
    if (const auto* message = std::get_if<Message>(&late)) {
      mixer.Add(*message);
    } else if (const auto* reply = std::get_if<event::Replied>(&late)) {
      AddReply(mixer, record, *reply);
    } else if (const auto* seen = std::get_if<event::StatusSeen>(&late)) {
      mixer.Add(seen->report, seen->report.emergency_stop,
                seen->report.stamp < record.report.stamp);
    }
  }
}

void AddRecord(Mixer& mixer, const ActuatorRecord& r) {
  mixer.Add(r.presence, r.report, r.process.pid, r.process.launch, r.process.dead, r.set_up_by,
            r.control.incarnation, r.control.again, r.checked, r.join_tried, r.failed_checks.count,
            r.failed_checks.at, r.held, r.due, r.set_again, r.fault ? r.fault->code : 0,
            r.fault ? r.fault->event : EventName::kNone, r.tolerated.has_value(), r.command,
            r.health, r.restart.count, r.restart.at, r.restart.reset_at, r.restart.given_up,
            r.restart.requested, r.process.termination, r.suspended, r.control.rival_until,
            r.free_by, r.elsewhere);
  mixer.Add(ToMilliseconds(r.clock_theirs - r.clock_ours));
}

void AddLegs(Mixer& mixer, const std::vector<Leg>& legs, ActuatorIndex i) {
  const auto found =
      std::find_if(legs.begin(), legs.end(), [i](const Leg& leg) { return leg.actuator == i; });
  mixer.Add(found == legs.end());
  if (found != legs.end()) mixer.Add(*found);
}

Fingerprint OfActuator(const Model& model, const World& world, ActuatorIndex i) {
  Mixer mixer(world.now);
  const Machine& machine = world.machine;
  const ActuatorRecord& record = machine.actuators[i];
  AddRecord(mixer, record);
  if (model.releases) {
    mixer.Add(record.report.emergency_stop, record.report.released_stop,
              record.report.other_stops.size());
  }
  if (machine.current) {
    AddLegs(mixer, machine.current->legs, i);
    AddLegs(mixer, machine.current->rollback.legs, i);
    for (const ActuatorResult& other : machine.current->others) {
      if (other.name == model.config.actuators[i].name) mixer.Add(other.outcome);
    }
  }
  const SimActuator& a = world.actuators[i];
  mixer.Add(a.alive, a.visible, a.work, a.stop_requested, a.energised, a.status_due, a.end, a.epoch,
            a.begun, a.queried);
  const ActuatorCore& c = a.core;
  mixer.Add(c.report, c.report.emergency_stop, c.report.released_stop, c.running_for,
            c.was_detached, c.waiting, c.unsettled, c.half_way_down, c.controller, c.announced,
            c.released, c.stops, c.stopped_meanwhile, c.under_stop);
  mixer.Add(a.replies.size());
  for (const event::Replied& reply : a.replies) AddReply(mixer, record, reply);
  AddLate(mixer, record, a.late);
  for (std::size_t k = 0; k < world.outbox.size(); ++k) {
    if (world.outbox[k].to == i) mixer.Add(k, world.outbox[k]);
  }
  mixer.Add(model.kinds[i]);
  return mixer.Get();
}

}  // namespace

Identity IdentityOf(const Model& model, const World& w) {
  Mixer mixer(w.now);
  const Machine& m = w.machine;
  unsigned twins = 0;
  std::vector<Fingerprint> actuators;
  for (const ActuatorIndex i : kIndices) {
    const Fingerprint own = OfActuator(model, w, i);
    if (std::find(actuators.begin(), actuators.end(), own) != actuators.end())
      twins |= 1U << i.value();
    actuators.push_back(own);
  }
  std::sort(actuators.begin(), actuators.end());
  mixer.Add(actuators, w.faults_left, w.requests, w.from, w.generation, w.disk.epoch, w.at_start,
            w.stopped, w.stop_seen_due, w.released, w.repeat);
  mixer.Add(m.phase, m.start_up.by_hand, m.state, m.epoch, m.number, m.start_up.set_up,
            m.start_up.stage, m.fallback.target, m.emergency.stop.has_value(),
            m.emergency.others.size(), m.emergency.released, m.start_up.requests,
            m.start_up.restarted, m.start_up.raised, m.policy);
  if (const auto& release = m.emergency.release)
    mixer.Add(release->last, release->again, release->until);
  mixer.Add(m.current.has_value());
  if (m.current) {
    const Switch& s = *m.current;
    mixer.Add(s.number, s.from, s.target, s.only, s.direction, s.purpose, s.requests, s.stopped,
              s.rollback.under_way, s.rollback.number);
  }
  // Without the requesters: they matter to a manager of ROS 2, and the search has none.
  mixer.Add(m.waiting.has_value());
  if (m.waiting)
    mixer.Add(m.waiting->target, m.waiting->only, m.waiting->until, m.waiting->requests);
  mixer.Add(m.stopping.has_value());
  if (m.stopping) {
    const Stopping& s = *m.stopping;
    mixer.Add(s.intent_by, s.after, s.tear_down_by, s.terminate_at, s.kill_at, s.give_up_at, s.sent,
              s.look, s.requests, s.result.has_value());
    if (s.result) mixer.Add(s.result->outcome);
  }
  return {mixer.Get(), twins};
}

}  // namespace musher::search
