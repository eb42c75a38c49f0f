#include "musher/lifecycle/health_monitor.hpp"

#include <algorithm>

namespace musher {
namespace {

constexpr Duration kSlowestBeat = Milliseconds(500);
constexpr Duration kLanBeat = Milliseconds(125);
constexpr Duration kControllerBeat = Milliseconds(500);
constexpr int kBeatsMissed = 3;
// Below this a loaded network loses actuators that are well.
constexpr Duration kLeastRemoteLimit = Milliseconds(500);
// Of anybody's silence, whatever period it claims to beat in.
constexpr Duration kLongestLimit = Milliseconds(60'000);
// Past this the loop of the controller was late itself; what was sent may wait behind the timer.
constexpr Duration kOwnDelay = Milliseconds(20);
// Who was starved is called so until it has kept up for as long.
constexpr Duration kStarvedFor = Milliseconds(2000);

std::string Ms(Duration duration) {
  return std::to_string(ToMilliseconds(duration)) + " ms";
}

}  // namespace

Duration BeatPeriod(const MachineConfig& config, std::size_t actuator) {
  const Duration slowest = config.transport == TransportProfile::kLan ? kLanBeat : kSlowestBeat;
  const auto checkpoint = config.actuators[actuator].checkpoint;
  return checkpoint ? std::clamp(*checkpoint / 2, Milliseconds(10), slowest) : slowest;
}

Duration ControllerBeatPeriod(const MachineConfig& config) {
  return config.transport == TransportProfile::kLan ? kLanBeat : kControllerBeat;
}

HealthMonitor::HealthMonitor(const MachineConfig& config)
    : config_(&config), patients_(config.actuators.size()) {}

void HealthMonitor::Watch(std::size_t actuator, std::uint64_t incarnation, const std::string& host,
                          bool local, Time now) {
  Patient& patient = patients_[actuator];
  if (patient.incarnation == incarnation) return;
  patient = Patient{};
  patient.incarnation = incarnation;
  patient.host = host;
  patient.local = local;
  patient.heard = now;
  // Its first beats may have come before anybody listened.
  if (config_->actuators[actuator].protocol != Protocol::kMusher) return;
  Promise(patient, BeatPeriod(*config_, actuator));
  patient.look = now + patient.limit / 2;
}

// The next beat is due in a period: how long it may be silent.
void HealthMonitor::Promise(Patient& patient, Duration period) {
  const Duration least = patient.local ? Milliseconds(40) : kLeastRemoteLimit;
  const Duration promised = std::clamp(period, Duration::zero(), kLongestLimit);
  patient.limit = std::clamp(promised * kBeatsMissed, least, kLongestLimit);
}

void HealthMonitor::Forget(std::size_t actuator) {
  patients_[actuator] = Patient{};
}

std::vector<Finding> HealthMonitor::Heard(std::size_t actuator, std::uint64_t incarnation,
                                          Time now) {
  std::vector<Finding> findings;
  Patient& patient = patients_[actuator];
  if (patient.incarnation != incarnation || incarnation == 0) return findings;
  Revive(actuator, patient, now, findings);
  return findings;
}

std::vector<Finding> HealthMonitor::Heard(std::size_t actuator, std::uint64_t incarnation,
                                          const Beat& beat, Time now) {
  std::vector<Finding> findings;
  Patient& patient = patients_[actuator];
  if (patient.incarnation != incarnation || incarnation == 0) return findings;
  Promise(patient, beat.period);
  Revive(actuator, patient, now, findings);
  JudgeWork(actuator, patient, beat, now, findings);
  return findings;
}

// Who is heard lives; what its work thread does is another matter.
void HealthMonitor::Revive(std::size_t actuator, Patient& patient, Time now,
                           std::vector<Finding>& findings) {
  patient.heard = now;
  patient.probed = false;
  patient.forgiven = false;
  patient.look.reset();
  if (patient.limit != Duration::zero()) patient.look = now + patient.limit / 2;
  const bool was_silent = patient.health != Health::kWell && patient.health != Health::kStarved;
  if (was_silent && !patient.work_hung) {
    Change(actuator, patient, Health::kWell, false, "it is heard again", findings);
  }
}

void HealthMonitor::JudgeWork(std::size_t actuator, Patient& patient, const Beat& beat, Time now,
                              std::vector<Finding>& findings) {
  const std::string silence =
      (beat.during.empty() ? "its work thread gave no checkpoint for "
                           : "in " + beat.during + " it gave no checkpoint for ") +
      Ms(beat.silent);
  if (beat.work == Health::kHung) {
    patient.work_hung = true;
    return Change(actuator, patient, Health::kHung, false, silence, findings);
  }
  patient.work_hung = false;
  if (beat.work == Health::kStarved) {
    patient.starved = now;
    return Change(actuator, patient, Health::kStarved, false,
                  silence + ", and waited for a CPU for " + Ms(beat.waited) + " of them", findings);
  }
  const bool kept_up = now - patient.starved >= kStarvedFor;
  if (patient.health == Health::kStarved && !kept_up) return;
  Change(actuator, patient, Health::kWell, false,
         patient.health == Health::kStarved ? "it keeps up again" : "its work goes on", findings);
}

std::vector<Finding> HealthMonitor::TimePassed(Time now) {
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < patients_.size(); ++i) {
    Patient& patient = patients_[i];
    if (!patient.look || *patient.look > now) continue;
    if (now - *patient.look > kOwnDelay && !patient.forgiven) {
      patient.forgiven = true;
      patient.look = now + kOwnDelay;
      continue;
    }
    if (!patient.probed) {
      patient.probed = true;
      // Silent for longer than the limit, and with time to answer though we were late ourselves.
      patient.look = std::max(patient.heard + patient.limit + Duration(1), now + patient.limit / 4);
      if (patient.local) findings.emplace_back(finding::Examine{i, true});
      findings.emplace_back(finding::Probe{i});
      continue;
    }
    patient.look.reset();
    if (patient.local) {
      findings.emplace_back(finding::Examine{i, false});
    } else {
      JudgeRemote(i, patient, now, findings);
    }
  }
  return findings;
}

std::vector<Finding> HealthMonitor::Examined(std::size_t actuator, const Examination& examination,
                                             Time now) {
  using Process = Examination::Process;
  std::vector<Finding> findings;
  Patient& patient = patients_[actuator];
  const Duration silent = now - patient.heard;
  if (patient.incarnation == 0 || examination.process == Process::kGone || !patient.probed ||
      silent < patient.limit) {
    return findings;
  }
  const std::string silence = "nothing was heard of it for " + Ms(silent);
  const Health health = JudgeSilence(silent, patient.limit, examination.waited);
  if (examination.process == Process::kStopped) {
    Change(actuator, patient, Health::kHung, true, "its process is stopped; " + silence, findings);
  } else if (examination.process == Process::kTraced) {
    patient.starved = now;
    Change(actuator, patient, Health::kStarved, true, "a debugger holds its process", findings);
    patient.look = now + patient.limit;
  } else if (health == Health::kHung) {
    Change(actuator, patient, Health::kHung, true,
           silence + ", although it had to wait for a CPU for " + Ms(examination.waited) + " only",
           findings);
  } else {
    patient.starved = now;
    Change(actuator, patient, Health::kStarved, true,
           silence + ", and waited for a CPU for " + Ms(examination.waited) + " of them", findings);
    patient.look = now + std::max(patient.limit - (silent - examination.waited), patient.limit / 4);
  }
  return findings;
}

void HealthMonitor::JudgeRemote(std::size_t actuator, Patient& patient, Time now,
                                std::vector<Finding>& findings) {
  const std::string silence = "nothing was heard of it for " + Ms(now - patient.heard);
  if (HostIsHeard(patient, now)) {
    Change(actuator, patient, Health::kCrashed, true,
           silence + ", while others of its host are heard", findings);
  } else {
    Change(actuator, patient, Health::kPartitioned, true, silence + ", nor of its host", findings);
  }
}

// Whether another actuator of the host has been heard after this one fell silent: within half of
// its limit, while this one has used up all of its own.
bool HealthMonitor::HostIsHeard(const Patient& patient, Time now) const {
  return std::any_of(patients_.begin(), patients_.end(), [&](const Patient& other) {
    return &other != &patient && other.incarnation != 0 && other.host == patient.host &&
           other.limit != Duration::zero() && now - other.heard < other.limit / 2;
  });
}

void HealthMonitor::Change(std::size_t actuator, Patient& patient, Health health, bool silent,
                           std::string how, std::vector<Finding>& findings) {
  if (patient.health == health) return;
  patient.health = health;
  findings.emplace_back(
      finding::Changed{actuator, patient.incarnation, health, silent, std::move(how)});
}

std::optional<Time> HealthMonitor::NextDeadline() const {
  std::optional<Time> next;
  for (const Patient& patient : patients_) {
    if (patient.look) next = next ? std::min(*next, *patient.look) : *patient.look;
  }
  return next;
}

}  // namespace musher
