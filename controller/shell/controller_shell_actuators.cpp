// Input from actuators: their status, their replies, and their loss.

#include <algorithm>
#include <utility>

#include "musher/controller/shell/controller_shell.hpp"
#include "musher/controller/shell/wire.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr std::size_t kProcessesKept = 4;  // of one actuator, with the latest statuses
constexpr std::size_t kMostUnlisted = 64;
// A heartbeat that was sent before the loss may arrive after it.
constexpr Duration kTakenAgainAfter = std::chrono::seconds(1);
constexpr std::size_t kMostPeerFaults = 64;  // recorded by one controller

}  // namespace

// Whether the latched status is of a running process that is not about to exit.
bool ControllerShell::Runs(const MachineConfig& config, const ActuatorReport& report) {
  const bool set_up_failed =
      report.state == config.default_state && !report.busy() && report.outcome_code != kCodeOk;
  return report.state != kTearDown && !set_up_failed;
}

void ControllerShell::OnStatus(const msg::ActuatorStatus& status,
                               const transport::SampleInfo& info) {
  const auto found = index_.find(status.name);
  if (!transport::IsFrom(status, info)) return;
  const MachineIdentity theirs{status.machine, status.machine_id};
  if (!SameMachine(machine_identity(), theirs) && !HoldsItsNameHere(status)) {
    return RecordOtherMachines(status, theirs);
  }
  if (found == index_.end()) return RecordUnlisted(status);
  const ActuatorIndex i = found->second;
  if (!TakeSender(i, status, info.participant)) return;
  const ActuatorReport report = WithProvenPid(i, transport::FromMessage(status));
  status_writers_[info.writer] = {i, report.incarnation};
  CompareHash(i, status.config_hash);
  if (machine_.phase == Phase::kIdle) statuses_before_begin_[i] = status;
  Handle(event::StatusSeen{i, report});
  const ActuatorReport& taken = machine_.actuators[i].report;
  if (taken.incarnation == report.incarnation) health_->OnReport(i, report, SenderOf(i, report));
}

// The participant of a process, from its status. Once the status has had its number, a status
// without one is not of that process.
bool ControllerShell::TakeSender(ActuatorIndex actuator, const msg::ActuatorStatus& status,
                                 transport::ParticipantId participant) {
  Process& process = ProcessOf(actuator, transport::FromMessage(status));
  const bool named = status.participant != 0;
  if (process.named && !named) return false;
  process.named = named;
  if (participant != 0) process.participant = participant;
  return true;
}

// 0: not known for certain.
transport::ParticipantId ControllerShell::SenderOf(ActuatorIndex actuator,
                                                   const ActuatorReport& report) const {
  for (const Process& process : peers_[actuator].processes) {
    if (process.named && process.Is(report)) return process.participant;
  }
  return 0;
}

// A process whose status writer was lost, but whose heartbeats are received, is taken again.
void ControllerShell::OnAlive(ActuatorIndex actuator, Incarnation incarnation) {
  const ActuatorRecord& record = machine_.actuators[actuator];
  std::optional<Time>& since = peers_[actuator].alive_since;
  const ActuatorReport& report = record.report;
  const bool lost = record.presence == Presence::kLost && report.incarnation == incarnation &&
                    record.process.dead != incarnation && !record.process.termination &&
                    report.state != kTearDown && report.state != config_.default_state;
  const Time now = dependencies_.node->loop().Now();
  if (!lost) {
    since.reset();
  } else if (!since) {
    since = now;
  } else if (now - *since >= kTakenAgainAfter) {
    since.reset();
    Handle(event::HealthChanged{actuator, incarnation, Health::kWell, false,
                                "its heartbeats are received"});
  }
}

// The process that sent the report. Keeps kProcessesKept processes for each actuator, those with
// the latest reports; never drops the process whose report the machine uses.
ControllerShell::Process& ControllerShell::ProcessOf(ActuatorIndex actuator,
                                                     const ActuatorReport& report) {
  std::vector<Process>& known = peers_[actuator].processes;
  const auto found = std::find_if(known.begin(), known.end(),
                                  [&](const Process& process) { return process.Is(report); });
  if (found != known.end()) {
    std::rotate(found, found + 1, known.end());
    return known.back();
  }
  if (known.size() >= kProcessesKept) {
    const bool is_taken = known.front().Is(machine_.actuators[actuator].report);
    known.erase(known.begin() + (is_taken ? 1 : 0));
  }
  return known.emplace_back(Process{report.host, report.incarnation, 0, 0, false});
}

// A reply counts as a heartbeat, and so does what the link of another protocol reports of its node.
void ControllerShell::OnLinkEvent(const Event& from_link) {
  Event event = from_link;
  auto* replied = std::get_if<event::Replied>(&event);
  if (replied) replied->report = WithProvenPid(replied->actuator, std::move(replied->report));
  Handle(event);
  if (replied != nullptr) return CountAsHeartbeat(replied->actuator, replied->report.incarnation);
  const auto* seen = std::get_if<event::StatusSeen>(&event);
  if (seen == nullptr) return;
  CountAsHeartbeat(seen->actuator, seen->report.incarnation);
  WatchProgram(seen->actuator);
}

// A program of another protocol does not report its pid; the controller knows the pid of a program
// that it has started or found. Until the program is set up it need not answer: its constructor may
// block its only thread.
void ControllerShell::CountAsHeartbeat(ActuatorIndex actuator, Incarnation incarnation) {
  const ActuatorRecord& record = machine_.actuators[actuator];
  if (record.report.incarnation != incarnation) return;
  const bool own = config_.actuators[actuator].protocol == Protocol::kMusher;
  if (!own && record.presence != Presence::kPresent) return;
  ActuatorReport report = record.report;
  if (report.host.empty() && record.process.pid != 0) {
    report.host = dependencies_.host;
    report.pid = dependencies_.process_probe->WorkerOf(record.process.pid);
  }
  health_->OnReport(actuator, report, SenderOf(actuator, report));
}

void ControllerShell::OnWriterLost(transport::EndpointId writer) {
  const auto lost = status_writers_.extract(writer);
  if (lost.empty()) return;
  const auto [actuator, incarnation] = lost.mapped();
  Handle(event::Vanished{actuator, incarnation, false, kOutOfReach});
}

void ControllerShell::CompareHash(ActuatorIndex actuator, const std::string& hash) {
  Peer& peer = peers_[actuator];
  if (hash == config_.hash || peer.hash_recorded) return;
  peer.hash_recorded = true;
  RecordHere(
      "actuator", actuator, kCodeParametersInvalid,
      texts::ConfigDiffers(config_.actuators[actuator].name, hash, config_.file, config_.hash));
}

// An earlier config may have listed it. No controller controls it, so it is only reported here.
void ControllerShell::RecordUnlisted(const msg::ActuatorStatus& status) {
  if (!Runs(config_, transport::FromMessage(status))) return;
  const Incarnation incarnation(status.incarnation);
  const auto [unlisted, added] = unlisted_.try_emplace(status.name.substr(0, 64), incarnation);
  const bool known = !added && unlisted->second == incarnation;
  if (known || unlisted_.size() > kMostUnlisted) return;
  unlisted->second = incarnation;
  RecordHere(
      "machine", std::nullopt, kCodeStateInvalid,
      texts::UnlistedActuatorFound(unlisted->first, status.pid, State(status.state), config_.file));
}

// Then it is of this machine, whatever it says: one machine of a host has the namespace and domain.
bool ControllerShell::HoldsItsNameHere(const msg::ActuatorStatus& status) const {
  const auto found = index_.find(status.name);
  if (status.host.empty() || status.host != dependencies_.host || found == index_.end()) {
    return false;
  }
  const std::int32_t child = machine_.actuators[found->second].process.pid;
  return dependencies_.process_probe->Prove(status.name, status.pid, child).ok();
}

// An actuator that is started by hand may have a config of another name by mistake.
void ControllerShell::RecordOtherMachines(const msg::ActuatorStatus& status,
                                          const MachineIdentity& theirs) {
  const auto found = index_.find(status.name);
  if (found == index_.end() || !config_.actuators[found->second].command.empty()) return;
  MachineIdentity machine = theirs;
  machine.name = machine.name.substr(0, 64);
  const bool added = of_others_.emplace(found->second, machine.name).second;
  if (!added || of_others_.size() > kMostUnlisted) return;
  RecordHere("machine", std::nullopt, kCodeParametersInvalid,
             texts::OtherMachineSeen(MachineText(machine), "its actuator " + status.name,
                                     config_.name_space));
}

// Each fault of a participant once: it may send any number of samples.
void ControllerShell::RecordPeerFault(const transport::PeerFault& fault) {
  if (peer_faults_.size() >= kMostPeerFaults) return;
  if (!peer_faults_.emplace(fault.participant, fault.what + " " + fault.topic).second) return;
  std::string source = dependencies_.node->RosNodeOf(fault.participant);
  for (const transport::PeerInfo& peer : dependencies_.node->Peers()) {
    if (peer.id != fault.participant || peer.pid == 0) continue;
    source += (source.empty() ? "" : ", ") + std::string("process ") + std::to_string(peer.pid) +
              (peer.host.empty() ? "" : " of host " + peer.host.substr(0, 64));
  }
  if (source.empty()) source = "a participant that does not say its process";
  Remark(kCodeParametersInvalid,
         source + " " + fault.what + ", on " + fault.topic + "; recorded once");
}

std::string ControllerShell::RunningWithAnotherConfig(const std::string& hash) const {
  std::string names;
  std::size_t count = 0;
  for (const auto& [actuator, all] : before_begin_) {
    const auto status = statuses_before_begin_.find(actuator);
    const std::string theirs =
        status == statuses_before_begin_.end() ? "" : status->second.config_hash;
    const bool ours = theirs.empty() || theirs == config_.hash || theirs == hash;
    const auto here = std::ranges::find_if(all, [this](const event::StatusSeen& seen) {
      return seen.report.host == dependencies_.host;
    });
    if (ours || here == all.end() || !Runs(config_, here->report)) continue;
    names += (names.empty() ? "" : ", ") + config_.actuators[actuator].name + " (pid " +
             std::to_string(here->report.pid) + ")";
    ++count;
  }
  return names.empty() ? names : names + (count == 1 ? " runs" : " run");
}

// Keeps events from before Begin(): an actuator latches its status once, so a status received
// before this controller begins would not be received again.
bool ControllerShell::KeepForBegin(const Event& event) {
  if (machine_.phase != Phase::kIdle) return false;
  if (const auto* seen = std::get_if<event::StatusSeen>(&event)) {
    std::vector<event::StatusSeen>& known = before_begin_[seen->actuator];
    std::erase_if(known, [&](const event::StatusSeen& other) {
      return other.report.host == seen->report.host;
    });
    if (known.size() >= kProcessesKept) known.erase(known.begin());
    known.push_back(*seen);
    if (!first_status_at_) first_status_at_ = dependencies_.node->loop().Now();
    return true;
  }
  if (const auto* stop = std::get_if<event::EmergencyStopSeen>(&event)) {
    const StoredStops over{{}, {stop->stop.id}};
    stops_before_begin_ =
        Merge(stops_before_begin_, stop->engaged ? StoredStops{{stop->stop}, {}} : over);
    return true;
  }
  if (const auto* vanished = std::get_if<event::Vanished>(&event)) {
    const auto kept = before_begin_.find(vanished->actuator);
    if (kept == before_begin_.end()) return true;
    std::erase_if(kept->second, [&](const event::StatusSeen& seen) {
      return seen.report.incarnation == vanished->incarnation;
    });
    if (kept->second.empty()) before_begin_.erase(kept);
    return true;
  }
  return false;
}

}  // namespace musher
