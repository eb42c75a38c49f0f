#include "musher/lifecycle/health/health_monitor.hpp"

#include <algorithm>

namespace musher {
namespace {

constexpr Duration kSlowestHeartbeat = Milliseconds(500);
constexpr Duration kLanHeartbeat = Milliseconds(125);
constexpr Duration kControllerHeartbeat = Milliseconds(500);
constexpr int kHeartbeatsMissed = 3;
// With a shorter limit, a loaded network loses healthy actuators.
constexpr Duration kLeastRemoteLimit = Milliseconds(500);
// The longest limit, whatever heartbeat period the actuator reports.
constexpr Duration kLongestLimit = Milliseconds(60'000);
// Above this delay the loop of the controller was late itself; samples may wait behind the timer.
constexpr Duration kOwnDelay = Milliseconds(20);
// After such a delay the controller was stopped, or its computer suspended: the actuators, whose
// leases may have ended meanwhile, are discovered again before their silence counts.
constexpr Duration kOwnBreak = Milliseconds(5000);
constexpr Duration kDiscoveredAgain = Milliseconds(10'000);
// A starved actuator stays starved until it has kept up for this long.
constexpr Duration kStarvedFor = Milliseconds(2000);

std::string Ms(Duration duration) {
  return std::to_string(ToMilliseconds(duration)) + " ms";
}

// Empty where it did not wait for the disk.
std::string DiskText(Duration waited, const std::string& before) {
  if (waited == Duration::zero()) return "";
  const bool longer = waited > kLongestDiskWait;
  return before + Ms(waited) + (longer ? ", of which " + Ms(kLongestDiskWait) + " count" : "");
}

}  // namespace

Duration HeartbeatPeriod(const MachineConfig& config, ActuatorIndex actuator) {
  const Duration slowest =
      config.transport == TransportProfile::kLan ? kLanHeartbeat : kSlowestHeartbeat;
  const auto checkpoint = config.actuators[actuator].checkpoint;
  return checkpoint ? std::clamp(*checkpoint / 2, Milliseconds(10), slowest) : slowest;
}

Duration ControllerHeartbeatPeriod(const MachineConfig& config) {
  return config.transport == TransportProfile::kLan ? kLanHeartbeat : kControllerHeartbeat;
}

HealthMonitor::HealthMonitor(const MachineConfig& config)
    : config_(&config), monitored_(config.actuators.size()) {}

void HealthMonitor::Watch(ActuatorIndex actuator, Incarnation incarnation, const std::string& host,
                          bool local, Time now) {
  MonitoredProcess& process = monitored_[actuator];
  if (process.incarnation == incarnation) return;
  process = MonitoredProcess{};
  process.incarnation = incarnation;
  process.host = host;
  process.local = local;
  process.last_received = now;
  const ActuatorConfig& config = config_->actuators[actuator];
  if (config.protocol == Protocol::kMusher) {
    // Its first heartbeats may have come before the subscription.
    SetLimit(process, HeartbeatPeriod(*config_, actuator));
  } else if (config.protocol == Protocol::kRos2Lifecycle && config.checkpoint) {
    // A ROS 2 node sends no heartbeats: it is queried at half of its limit.
    process.limit = std::clamp(*config.checkpoint, Milliseconds(40), kLongestLimit);
  } else {
    return;
  }
  process.look = now + process.limit / 2;
}

// Sets the limit of its silence from the period of its heartbeat.
void HealthMonitor::SetLimit(MonitoredProcess& process, Duration period) {
  const Duration least = process.local ? Milliseconds(40) : kLeastRemoteLimit;
  const Duration reported = std::clamp(period, Duration::zero(), kLongestLimit);
  process.limit = std::clamp(reported * kHeartbeatsMissed, least, kLongestLimit);
}

void HealthMonitor::Forget(ActuatorIndex actuator) {
  monitored_[actuator] = MonitoredProcess{};
}

std::vector<HealthEvent> HealthMonitor::OnSample(ActuatorIndex actuator, Incarnation incarnation,
                                                 Time now) {
  std::vector<HealthEvent> events;
  MonitoredProcess& process = monitored_[actuator];
  if (process.incarnation != incarnation || incarnation == 0) return events;
  Revive(actuator, process, now, events);
  return events;
}

std::vector<HealthEvent> HealthMonitor::OnSample(ActuatorIndex actuator, Incarnation incarnation,
                                                 const Heartbeat& heartbeat, Time now) {
  std::vector<HealthEvent> events;
  MonitoredProcess& process = monitored_[actuator];
  if (process.incarnation != incarnation || incarnation == 0) return events;
  SetLimit(process, heartbeat.period);
  Revive(actuator, process, now, events);
  EvaluateWork(actuator, process, heartbeat, now, events);
  return events;
}

// An actuator that sends is alive; its work thread is evaluated separately.
void HealthMonitor::Revive(ActuatorIndex actuator, MonitoredProcess& process, Time now,
                           std::vector<HealthEvent>& events) {
  NoteBreak(process, now);
  process.last_received = now;
  process.probed = false;
  process.silent = false;
  process.excused = false;
  process.look.reset();
  if (process.limit != Duration::zero()) process.look = now + process.limit / 2;
  const bool was_silent = process.health != Health::kWell && process.health != Health::kStarved;
  if (was_silent && !process.work_hung) {
    Change(actuator, process, Health::kWell, false, "heartbeat received again", events);
  }
}

void HealthMonitor::EvaluateWork(ActuatorIndex actuator, MonitoredProcess& process,
                                 const Heartbeat& heartbeat, Time now,
                                 std::vector<HealthEvent>& events) {
  const std::string silence =
      (heartbeat.during.empty() ? "no checkpoint from its work thread for "
                                : "no checkpoint in " + heartbeat.during + " for ") +
      Ms(heartbeat.silent);
  if (heartbeat.work == Health::kHung) {
    process.work_hung = true;
    return Change(actuator, process, Health::kHung, false, silence, events);
  }
  process.work_hung = false;
  if (heartbeat.work == Health::kStarved) {
    process.starved = now;
    return Change(actuator, process, Health::kStarved, false,
                  silence + ", " + Ms(heartbeat.waited) + " of them waiting for a CPU or the disk",
                  events);
  }
  const bool kept_up = now - process.starved >= kStarvedFor;
  if (process.health == Health::kStarved && !kept_up) return;
  Change(actuator, process, Health::kWell, false,
         process.health == Health::kStarved ? "it gets enough CPU again"
                                            : "its work thread makes progress again",
         events);
}

// What waited behind the break may be received before the time is seen to have passed.
void HealthMonitor::NoteBreak(const MonitoredProcess& process, Time now) {
  if (process.look && now - *process.look > kOwnBreak) no_silence_until_ = now + kDiscoveredAgain;
}

std::vector<HealthEvent> HealthMonitor::TimePassed(Time now) {
  std::vector<HealthEvent> events;
  for (const ActuatorIndex i : monitored_.Indices()) {
    MonitoredProcess& process = monitored_[i];
    if (!process.look || *process.look > now) continue;
    NoteBreak(process, now);
    if (now < no_silence_until_) {
      process.last_received = now;
      process.probed = false;
      process.look = no_silence_until_;
      continue;
    }
    if (now - *process.look > kOwnDelay && !process.excused) {
      process.excused = true;
      process.look = now + kOwnDelay;
      continue;
    }
    if (!process.probed) {
      process.probed = true;
      // After the limit, and with time to answer even if the controller was late itself.
      process.look =
          std::max(process.last_received + process.limit + Duration(1), now + process.limit / 4);
      if (process.local) events.emplace_back(health_event::Examine{i, true});
      events.emplace_back(health_event::Probe{i});
      continue;
    }
    process.look.reset();
    if (process.local) {
      events.emplace_back(health_event::Examine{i, false});
    } else {
      EvaluateRemote(i, process, now, events);
    }
  }
  return events;
}

std::vector<HealthEvent> HealthMonitor::Examined(ActuatorIndex actuator,
                                                 const Examination& examination, Time now) {
  using Process = Examination::Process;
  std::vector<HealthEvent> events;
  MonitoredProcess& process = monitored_[actuator];
  const Duration silent = now - process.last_received;
  if (process.incarnation == 0 || examination.process == Process::kExited || !process.probed ||
      silent < process.limit) {
    return events;
  }
  const std::string silence = "no heartbeat for " + Ms(silent);
  const Duration waited = examination.waited + std::min(examination.on_disk, kLongestDiskWait);
  const Health health = EvaluateSilence(silent, process.limit, waited);
  if (examination.process == Process::kStopped) {
    Change(actuator, process, Health::kHung, true, "its process is stopped; " + silence, events);
  } else if (examination.process == Process::kTraced) {
    process.starved = now;
    Change(actuator, process, Health::kStarved, true, "a debugger holds its process", events);
    process.look = now + process.limit;
  } else if (health == Health::kHung) {
    Change(actuator, process, Health::kHung, true,
           silence + ", although it waited for a CPU for only " + Ms(examination.waited) +
               DiskText(examination.on_disk, " and for the disk for "),
           events);
  } else {
    process.starved = now;
    Change(actuator, process, Health::kStarved, true,
           silence + ", " + Ms(examination.waited) + " of them waiting for a CPU" +
               DiskText(examination.on_disk, " and for the disk "),
           events);
    process.look = now + std::max(process.limit - (silent - waited), process.limit / 4);
  }
  return events;
}

void HealthMonitor::EvaluateRemote(ActuatorIndex actuator, MonitoredProcess& process, Time now,
                                   std::vector<HealthEvent>& events) {
  const std::string silence = "no heartbeat for " + Ms(now - process.last_received);
  // A program of another protocol that was started by hand: its host is not known.
  if (process.host.empty()) {
    return Change(actuator, process, Health::kHung, true, silence, events);
  }
  // Its host may be silent later, too, or be heard again without it.
  process.look = now + process.limit;
  if (HostIsAlive(process, now)) {
    Change(actuator, process, Health::kCrashed, true,
           silence + ", while other actuators of its host are alive", events);
  } else {
    Change(actuator, process, Health::kPartitioned, true,
           silence + ", nor from any actuator of its host", events);
  }
}

// Whether another actuator of the host was received after this one fell silent: within half of the
// other's limit, while this one has exceeded its own limit.
bool HealthMonitor::HostIsAlive(const MonitoredProcess& process, Time now) const {
  return std::any_of(monitored_.begin(), monitored_.end(), [&](const MonitoredProcess& other) {
    return &other != &process && other.incarnation != 0 && other.host == process.host &&
           other.limit != Duration::zero() && now - other.last_received < other.limit / 2;
  });
}

void HealthMonitor::Change(ActuatorIndex actuator, MonitoredProcess& process, Health health,
                           bool silent, std::string how, std::vector<HealthEvent>& events) {
  // A process whose work thread hangs may have been frozen since.
  const bool frozen = health == Health::kHung && silent && !process.silent;
  if (process.health == health && !frozen) return;
  process.health = health;
  process.silent = silent;
  events.emplace_back(
      health_event::Changed{actuator, process.incarnation, health, silent, std::move(how)});
}

std::optional<Time> HealthMonitor::NextDeadline() const {
  std::optional<Time> next;
  for (const MonitoredProcess& process : monitored_) {
    if (process.look) next = next ? std::min(*next, *process.look) : *process.look;
  }
  return next;
}

}  // namespace musher
