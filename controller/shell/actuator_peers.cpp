#include "musher/controller/shell/actuator_peers.hpp"

#include <algorithm>

#include "musher/lifecycle/record/texts.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr std::size_t kProcessesKept = 4;  // of one actuator, with the latest statuses
constexpr std::size_t kMostUnlisted = 64;
constexpr std::size_t kLongestShown = 64;          // of a name, an id or a host, in messages
constexpr std::size_t kMostOfOtherMachines = 256;  // actuators
// A heartbeat that was sent before the loss may arrive after it.
constexpr Duration kTakenAgainAfter = std::chrono::seconds(1);
constexpr std::size_t kMostPeerFaults = 64;  // then none for kPeerFaultsPeriod
constexpr Duration kPeerFaultsPeriod = std::chrono::hours(1);
// A participant that keeps publishing wrong pids must not fill the journal.
constexpr Duration kUnprovenPeriod = std::chrono::minutes(1);
constexpr Duration kLastSampleTime = Milliseconds(500);  // see ReportExit()
// The kernel's table of sockets may lack one while others are opened and closed.
constexpr int kMostProgramLooks = 5;
constexpr Duration kProgramLookPeriod = std::chrono::seconds(1);

// Whether the latched status is of a running process that is not about to exit.
bool Runs(const MachineConfig& config, const ActuatorReport& report) {
  const bool set_up_failed =
      report.state == config.default_state && !report.busy() && report.outcome_code != kCodeOk;
  return report.state != kTearDown && !set_up_failed;
}

std::string TakenBy(const MachineIdentity& machine) {
  const MachineIdentity shown{machine.name.substr(0, kLongestShown), machine.id};
  return "it follows another machine now, " + MachineText(shown);
}

}  // namespace

ActuatorPeers::ActuatorPeers(ShellContext context)
    : context_(std::move(context)),
      dependencies_(context_.dependencies),
      config_(context_.config),
      machine_(context_.machine),
      identity_{config_.name, dependencies_.machine_id},
      peers_(config_.actuators.size()) {
  for (const ActuatorIndex i : config_.actuators.Indices()) index_[config_.actuators[i].name] = i;
}

ActuatorPeers::~ActuatorPeers() {
  Unsubscribe();
}

Result<> ActuatorPeers::OpenLinks() {
  transport::Node& node = *dependencies_.node;
  node.SetOnPeerFault([this](const transport::PeerFault& fault) { RecordPeerFault(fault); });
  for (const ActuatorIndex i : peers_.Indices()) {
    auto link = MakeLink(
        node, config_, i, [this](const Event& event) { OnLinkEvent(event); }, dependencies_.links);
    if (!link) return link.error();
    peers_[i].link = std::move(link).value();
    peers_[i].link->OnMachine(identity_, dependencies_.host);
  }
  return Ok();
}

Result<> ActuatorPeers::Subscribe(HealthWatch& health) {
  health_ = &health;
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(!config_.keys.empty());
  auto subscription = transport::MakeSubscription<msg::ActuatorStatus>(
      *dependencies_.node, transport::ActuatorStatusTopic(config_.name_space),
      [this](const msg::ActuatorStatus& s, const transport::SampleInfo& i) { OnStatus(s, i); }, qos,
      {[this](transport::EndpointId writer) { OnWriterLost(writer); }, nullptr});
  if (!subscription) return subscription.error();
  statuses_ = std::move(subscription).value();
  return Ok();
}

void ActuatorPeers::Unsubscribe() {
  dependencies_.node->SetOnPeerFault({});
  statuses_ = nullptr;
}

void ActuatorPeers::SetMachine(const MachineIdentity& machine) {
  identity_ = machine;
  for (Peer& peer : peers_) peer.link->OnMachine(machine, dependencies_.host);
}

ActuatorLink& ActuatorPeers::LinkTo(ActuatorIndex actuator) {
  Peer& peer = peers_[actuator];
  for (const Process& process : peer.processes) {
    if (process.participant != 0 && process.Is(machine_.actuators[actuator].report)) {
      peer.link->OnPeer(process.participant);
    }
  }
  return *peer.link;
}

void ActuatorPeers::OnStatus(const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
  const auto found = index_.find(status.name);
  if (!transport::IsFrom(status, info)) return;
  const MachineIdentity theirs{status.machine, status.machine_id};
  if (!SameMachine(identity_, theirs) && !HoldsItsNameHere(status)) {
    NoteOtherMachine(status, info);
    RecordOtherMachines(status, theirs);
    return LoseToOther(status, info.writer);
  }
  other_machines_.erase(info.writer);
  if (found == index_.end()) return RecordUnlisted(status);
  const ActuatorIndex i = found->second;
  if (!TakeSender(i, status, info.participant)) return;
  const ActuatorReport report = WithProvenPid(i, transport::FromMessage(status));
  status_writers_[info.writer] = {i, report.incarnation};
  CompareHash(i, status.config_hash);
  if (machine_.phase == Phase::kIdle) statuses_before_begin_[i] = status;
  context_.handle(event::StatusSeen{i, report});
  const ActuatorReport& taken = machine_.actuators[i].report;
  if (taken.incarnation == report.incarnation) health_->OnReport(i, report, SenderOf(i, report));
}

// A reply counts as a heartbeat, and so does what the link of another protocol reports of its node.
void ActuatorPeers::OnLinkEvent(const Event& from_link) {
  Event event = from_link;
  auto* replied = std::get_if<event::Replied>(&event);
  if (replied) replied->report = WithProvenPid(replied->actuator, std::move(replied->report));
  context_.handle(event);
  const auto* seen = std::get_if<event::StatusSeen>(&event);
  if (replied == nullptr && seen == nullptr) return;
  const ActuatorIndex actuator = replied != nullptr ? replied->actuator : seen->actuator;
  const ActuatorReport& report = replied != nullptr ? replied->report : seen->report;
  CountAsHeartbeat(actuator, report.incarnation);
  WatchProgram(actuator);
}

// A program of another protocol does not report its pid; the controller knows the pid of a program
// that it has started or found. Until the program is set up it need not answer: its constructor may
// block its only thread.
void ActuatorPeers::CountAsHeartbeat(ActuatorIndex actuator, Incarnation incarnation) {
  const KnownActuator& known = machine_.actuators[actuator];
  if (known.report.incarnation != incarnation) return;
  const bool own = config_.actuators[actuator].protocol == Protocol::kMusher;
  if (!own && known.presence != Presence::kPresent) return;
  ActuatorReport report = known.report;
  if (report.host.empty() && ChildOf(actuator) != 0) {
    report.host = dependencies_.host;
    report.pid = dependencies_.process_probe->WorkerOf(ChildOf(actuator));
  }
  health_->OnReport(actuator, report, SenderOf(actuator, report));
}

void ActuatorPeers::OnAlive(ActuatorIndex actuator, Incarnation incarnation) {
  const KnownActuator& known = machine_.actuators[actuator];
  std::optional<Time>& since = peers_[actuator].alive_since;
  const ActuatorReport& report = known.report;
  const bool lost = known.presence == Presence::kLost && report.incarnation == incarnation &&
                    known.process.dead != incarnation && !known.process.termination &&
                    report.state != kTearDown && report.state != config_.default_state &&
                    !FollowsOther(actuator);
  const Time now = context_.loop().Now();
  if (!lost) {
    since.reset();
  } else if (!since) {
    since = now;
  } else if (now - *since >= kTakenAgainAfter) {
    since.reset();
    context_.handle(event::HealthChanged{actuator, incarnation, Health::kWell, false,
                                         "its heartbeats are received"});
  }
}

// A process on another host has followed this controller, and since then the controller of another
// machine, which began there. That one leads its own machine: this controller keeps the others.
void ActuatorPeers::LoseToOther(const msg::ActuatorStatus& status, transport::EndpointId writer) {
  const auto lost = status_writers_.extract(writer);
  if (!lost.empty()) {
    const auto [actuator, incarnation] = lost.mapped();
    return context_.handle(event::Vanished{actuator, incarnation, false,
                                           TakenBy({status.machine, status.machine_id}), true,
                                           status.pid, status.host.substr(0, kLongestShown)});
  }
  const auto found = index_.find(status.name);
  if (found == index_.end()) return;
  const KnownActuator& in_use = machine_.actuators[found->second];
  // After a cut its heartbeats were received before its status.
  const bool is_in_use = in_use.report.host == status.host &&
                         in_use.report.incarnation == Incarnation(status.incarnation) &&
                         in_use.presence != Presence::kLost;
  if (is_in_use) {
    return context_.handle(event::Vanished{found->second, in_use.report.incarnation, false,
                                           TakenBy({status.machine, status.machine_id}), true,
                                           status.pid, status.host.substr(0, kLongestShown)});
  }
  const auto& taken = in_use.process.taken;
  const bool known = taken && taken->pid == status.pid && taken->host == status.host;
  if (!known) ReportTaken(found->second);
}

void ActuatorPeers::ReportTaken(ActuatorIndex actuator) {
  const ActuatorProcess& process = machine_.actuators[actuator].process;
  const OtherMachine* status = StatusOfOther(actuator, process.host, process.pid);
  if (status == nullptr) return;
  context_.handle(event::Vanished{actuator, status->incarnation, false, TakenBy(status->machine),
                                  true, status->pid, status->host});
}

// Null: there is none, or the process publishes as this machine's.
const ActuatorPeers::OtherMachine* ActuatorPeers::StatusOfOther(ActuatorIndex actuator,
                                                                const std::string& host,
                                                                std::int32_t pid) const {
  const KnownActuator& known = machine_.actuators[actuator];
  const bool follows =
      known.presence == Presence::kPresent && known.report.host == host && known.report.pid == pid;
  if (host.empty() || pid == 0 || follows) return nullptr;
  const std::string& name = config_.actuators[actuator].name;
  const auto found = std::ranges::find_if(other_machines_, [&](const auto& one) {
    const OtherMachine& other = one.second;
    return other.actuator == name && other.host == host && other.pid == pid;
  });
  return found == other_machines_.end() ? nullptr : &found->second;
}

bool ActuatorPeers::FollowsOther(ActuatorIndex actuator) const {
  const std::vector<Process>& processes = peers_[actuator].processes;
  return std::ranges::any_of(processes, [&](const Process& process) {
    return process.participant != 0 && process.Is(machine_.actuators[actuator].report) &&
           OtherMachineOf(process.participant) != nullptr;
  });
}

void ActuatorPeers::OnWriterLost(transport::EndpointId writer) {
  other_machines_.erase(writer);
  const auto lost = status_writers_.extract(writer);
  if (lost.empty()) return;
  const auto [actuator, incarnation] = lost.mapped();
  context_.handle(event::Vanished{actuator, incarnation, false, kOutOfReach});
}

// --- the sender of a status ---

// The participant of a process, from its status. Once a status of the process has named its
// participant, a status that names none is not of that process.
bool ActuatorPeers::TakeSender(ActuatorIndex actuator, const msg::ActuatorStatus& status,
                               transport::ParticipantId participant) {
  Process& process = ProcessOf(actuator, transport::FromMessage(status));
  const bool named = status.participant != 0;
  if (process.named && !named) return false;
  process.named = named;
  if (participant != 0) process.participant = participant;
  process.stop_trouble = status.stop_trouble;
  return true;
}

std::string ActuatorPeers::StopTrouble(ActuatorIndex actuator) const {
  const KnownActuator& known = machine_.actuators[actuator];
  if (known.presence != Presence::kPresent) return "";
  for (const Process& process : peers_[actuator].processes) {
    if (process.Is(known.report)) return process.stop_trouble;
  }
  return "";
}

// 0: not known for certain.
transport::ParticipantId ActuatorPeers::SenderOf(ActuatorIndex actuator,
                                                 const ActuatorReport& report) const {
  for (const Process& process : peers_[actuator].processes) {
    if (process.named && process.Is(report)) return process.participant;
  }
  return 0;
}

// The process that sent the report. Keeps kProcessesKept processes for each actuator, those with
// the latest reports; never drops the process whose report the machine uses.
ActuatorPeers::Process& ActuatorPeers::ProcessOf(ActuatorIndex actuator,
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
  Process& process = known.emplace_back();
  process.host = report.host;
  process.incarnation = report.incarnation;
  return process;
}

// --- the process of a sender ---

// The report, with pid 0 unless the pid is proven. Any participant on the network can publish a
// status with any pid of this host; a pid that is not proven to be the actuator's is dropped here:
// nothing is watched, traced or signalled because of it. The result is kept for as long as the
// process of that incarnation reports the same pid.
ActuatorReport ActuatorPeers::WithProvenPid(ActuatorIndex actuator, ActuatorReport report) {
  if (report.pid == 0 || report.host.empty() || report.host != dependencies_.host) return report;
  Process& process = ProcessOf(actuator, report);
  if (process.pid != report.pid) {
    process.pid = report.pid;
    const Result<> proven = ProveAndWatch(actuator, report);
    process.proven = proven.ok();
    // If the process has exited meanwhile, its writer is lost as well: no record needed.
    const bool ended = !proven && proven.error().code == kCodeStateInvalid;
    if (!proven && !ended) RecordUnproven(actuator, report.pid, proven.error().message);
  }
  if (!process.proven) report.pid = 0;
  return report;
}

// The process of this host that we have started for the actuator; 0: none.
std::int32_t ActuatorPeers::ChildOf(ActuatorIndex actuator) const {
  const ActuatorProcess& process = machine_.actuators[actuator].process;
  return process.host.empty() ? process.pid : 0;
}

// The exit of a process that we did not start is noticed as fast as a child's, but without the exit
// code. Several actuators may share a process: each watches it.
Result<> ActuatorPeers::ProveAndWatch(ActuatorIndex actuator, const ActuatorReport& report) {
  const std::int32_t child = ChildOf(actuator);
  if (report.pid == child) return Ok();  // watched since it was started
  Result<> proven =
      dependencies_.process_probe->Prove(config_.actuators[actuator].name, report.pid, child);
  if (!proven || report.pid == dependencies_.pid) return proven;
  return dependencies_.processes->Watch(
      report.pid, [this, actuator, incarnation = report.incarnation,
                   pid = report.pid](const ProcessExit& exit) {
        const bool known = exit.kind != ProcessExit::Kind::kUnknown;
        event::Vanished vanished{
            actuator, incarnation, true,
            "its process " + std::to_string(pid) + " ended" + (known ? ": " + exit.Text() : "")};
        vanished.clean = exit.clean();
        const auto vanish = [this, vanished] {
          context_.handle(vanished);
          health_->ForgetUnlessPresent(vanished.actuator, machine_.actuators[vanished.actuator]);
        };
        if (known) return vanish();
        ReportExit(actuator, vanish);
      });
}

void ActuatorPeers::ReportExit(ActuatorIndex actuator, std::function<void()> report) {
  const KnownActuator& known = machine_.actuators[actuator];
  const bool tears_down =
      known.report.target == kTearDown || (known.command && known.command->target == kTearDown);
  const bool killed = (known.process.termination && known.process.termination->killed) ||
                      (machine_.stopping && machine_.stopping->sent == Shutdown::Signal::kKill);
  if (!tears_down || killed) return report();
  const std::uint64_t number = ++last_exit_;
  exits_later_[number] = context_.loop().At(
      context_.loop().Now() + kLastSampleTime, [this, number, report = std::move(report)] {
        const auto ended = exits_later_.extract(number);  // what runs here lives until its end
        report();
      });
}

// The exit of a program of another protocol that we did not start: its participant says which
// process it has. That is used for nothing but this watch, and only if the process takes part in
// our domain: in a container the same number may be another process.
void ActuatorPeers::WatchProgram(ActuatorIndex actuator) {
  Peer& peer = peers_[actuator];
  const transport::ParticipantId participant =
      peer.link ? peer.link->ProgramsParticipant() : transport::ParticipantId();
  const Time now = context_.loop().Now();
  if (std::exchange(peer.looked_at, participant) != participant) {
    peer.looks_left = kMostProgramLooks;
    peer.next_look = now;
  }
  if (participant == 0 || dependencies_.host_name.empty()) return;
  if (peer.looks_left == 0 || now < peer.next_look) return;
  --peer.looks_left;
  peer.next_look = now + kProgramLookPeriod;
  const std::vector<transport::PeerInfo> peers = dependencies_.node->Peers();
  const auto found = std::ranges::find(peers, participant, &transport::PeerInfo::id);
  if (found == peers.end()) return;
  const std::int32_t pid = found->host == dependencies_.host_name ? found->pid : 0;
  if (pid != 0 && !dependencies_.process_probe->SharesDomain(pid)) return;
  peer.looks_left = 0;
  if (pid == 0) return;
  const Result<> watched =
      dependencies_.processes->Watch(pid, [this, actuator, participant, pid](const ProcessExit&) {
        ReportExit(actuator, [this, actuator, participant, pid] {
          ActuatorLink& link = *peers_[actuator].link;
          if (link.ProgramsParticipant() == participant) health_->Forget(actuator);
          link.OnParticipantEnded(participant, pid);
        });
      });
  if (watched) peer.link->OnParticipantWatched(participant);
}

void ActuatorPeers::RecordUnproven(ActuatorIndex actuator, std::int32_t pid,
                                   const std::string& why) {
  std::optional<Time>& recorded = peers_[actuator].unproven_recorded;
  const Time now = context_.loop().Now();
  if (recorded && now - *recorded < kUnprovenPeriod) return;
  recorded = now;
  context_.records.WriteOwn("process", actuator, kCodePermissionDenied,
                            texts::ProcessUnproven(config_.actuators[actuator].name, pid, why));
}

// --- what is not of this machine, or of another config ---

void ActuatorPeers::CompareHash(ActuatorIndex actuator, const std::string& hash) {
  Peer& peer = peers_[actuator];
  if (hash == config_.hash || peer.hash_recorded) return;
  peer.hash_recorded = true;
  context_.records.WriteOwn(
      "actuator", actuator, kCodeParametersInvalid,
      texts::ConfigDiffers(config_.actuators[actuator].name, hash, config_.file, config_.hash));
}

// An earlier config may have listed it. No controller controls it, so it is only reported here.
void ActuatorPeers::RecordUnlisted(const msg::ActuatorStatus& status) {
  if (!Runs(config_, transport::FromMessage(status))) return;
  const Incarnation incarnation(status.incarnation);
  const auto [unlisted, added] =
      unlisted_.try_emplace(status.name.substr(0, kLongestShown), incarnation);
  const bool known = !added && unlisted->second == incarnation;
  if (known || unlisted_.size() > kMostUnlisted) return;
  unlisted->second = incarnation;
  context_.records.WriteOwn(
      "machine", std::nullopt, kCodeStateInvalid,
      texts::UnlistedActuatorFound(unlisted->first, status.pid, State(status.state), config_.file));
}

// Then it is of this machine, whatever it says: one machine of a host has the namespace and domain.
bool ActuatorPeers::HoldsItsNameHere(const msg::ActuatorStatus& status) const {
  const auto found = index_.find(status.name);
  if (status.host.empty() || status.host != dependencies_.host || found == index_.end()) {
    return false;
  }
  const std::int32_t child = ChildOf(found->second);
  return dependencies_.process_probe->Prove(status.name, status.pid, child).ok();
}

// A status without its participant may be one that a bridge repeats.
void ActuatorPeers::NoteOtherMachine(const msg::ActuatorStatus& status,
                                     const transport::SampleInfo& info) {
  const bool known = other_machines_.contains(info.writer);
  if (status.participant == 0 || (!known && other_machines_.size() >= kMostOfOtherMachines)) return;
  other_machines_[info.writer] = {
      info.participant,
      {status.machine.substr(0, kLongestShown), status.machine_id.substr(0, kLongestShown)},
      status.name.substr(0, kLongestShown),
      status.host.substr(0, kLongestShown),
      status.pid,
      Incarnation(status.incarnation)};
}

const MachineIdentity* ActuatorPeers::OtherMachineOf(transport::ParticipantId participant) const {
  const auto found = std::find_if(
      other_machines_.begin(), other_machines_.end(),
      [participant](const auto& other) { return other.second.participant == participant; });
  return found == other_machines_.end() ? nullptr : &found->second.machine;
}

// An actuator that is started by hand may have a config of another name by mistake.
void ActuatorPeers::RecordOtherMachines(const msg::ActuatorStatus& status,
                                        const MachineIdentity& theirs) {
  const auto found = index_.find(status.name);
  if (found == index_.end() || !config_.actuators[found->second].command.empty()) return;
  MachineIdentity machine = theirs;
  machine.name = machine.name.substr(0, kLongestShown);
  const bool added = of_others_.emplace(found->second, machine.name).second;
  if (!added || of_others_.size() > kMostUnlisted) return;
  context_.records.WriteOwn(
      "machine", std::nullopt, kCodeParametersInvalid,
      texts::OtherMachineSeen(MachineText(machine), "its actuator " + status.name,
                              config_.name_space));
}

// Each fault of a participant once in the period: it may send any number of samples.
void ActuatorPeers::RecordPeerFault(const transport::PeerFault& fault) {
  const Time now = context_.loop().Now();
  if (peer_faults_.size() >= kMostPeerFaults) {  // respawned processes may be others
    if (now - peer_faults_full_at_ < kPeerFaultsPeriod) return;
    peer_faults_.clear();
  }
  if (!peer_faults_.emplace(fault.participant, fault.what + " " + fault.topic).second) return;
  if (peer_faults_.size() == kMostPeerFaults) peer_faults_full_at_ = now;
  std::string source = dependencies_.node->RosNodeOf(fault.participant);
  for (const transport::PeerInfo& peer : dependencies_.node->Peers()) {
    if (peer.id != fault.participant || peer.pid == 0) continue;
    source += (source.empty() ? "" : ", ") + std::string("process ") + std::to_string(peer.pid) +
              (peer.host.empty() ? "" : " of host " + peer.host.substr(0, kLongestShown));
  }
  if (source.empty()) source = "a participant that does not say its process";
  context_.records.Remark(kCodeParametersInvalid,
                          source + " " + fault.what + ", on " + fault.topic + "; recorded once");
}

// --- before the machine begins ---

bool ActuatorPeers::KeepForBegin(const Event& event) {
  if (const auto* seen = std::get_if<event::StatusSeen>(&event)) {
    std::vector<event::StatusSeen>& known = before_begin_[seen->actuator];
    const bool is_older = std::ranges::any_of(known, [&](const event::StatusSeen& other) {
      return other.report.host == seen->report.host &&
             other.report.incarnation == seen->report.incarnation &&
             other.report.stamp > seen->report.stamp;
    });
    if (is_older) return true;
    std::erase_if(known, [&](const event::StatusSeen& other) {
      return other.report.host == seen->report.host;
    });
    if (known.size() >= kProcessesKept) known.erase(known.begin());
    known.push_back(*seen);
    if (!first_status_at_) first_status_at_ = context_.loop().Now();
    return true;
  }
  const auto* vanished = std::get_if<event::Vanished>(&event);
  if (vanished == nullptr) return false;
  const auto kept = before_begin_.find(vanished->actuator);
  if (kept == before_begin_.end()) return true;
  std::erase_if(kept->second, [&](const event::StatusSeen& seen) {
    return seen.report.incarnation == vanished->incarnation;
  });
  if (kept->second.empty()) before_begin_.erase(kept);
  return true;
}

// A process that was killed is reported as vanished only once its lease is over.
void ActuatorPeers::ForgetEnded(const RunsHere& runs_here) {
  if (dependencies_.host.empty()) return;  // it is not known which ran here
  for (auto& [actuator, all] : before_begin_) {
    const std::string& name = config_.actuators[actuator].name;
    std::erase_if(all, [&](const event::StatusSeen& seen) {
      return seen.report.host == dependencies_.host && !runs_here(name, seen.report.pid);
    });
  }
  std::erase_if(before_begin_, [](const auto& kept) { return kept.second.empty(); });
}

std::string ActuatorPeers::RunningWithAnotherConfig(const std::string& hash) const {
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

// Whether another actuator runs in the process of `report`. That process does not exit, even if
// this actuator is torn down, and a second one would start the other actuator twice.
bool ActuatorPeers::SharesItsProcess(const ActuatorReport& report) const {
  const auto is_it = [&](const event::StatusSeen& other) {
    const ActuatorReport& running = other.report;
    return running.pid != 0 && running.pid == report.pid && running.host == report.host &&
           Runs(config_, running);
  };
  return std::any_of(before_begin_.begin(), before_begin_.end(),
                     [&](const auto& others) { return std::ranges::any_of(others.second, is_it); });
}

bool ActuatorPeers::RanBeforeBegin(ActuatorIndex actuator) const {
  const auto found = before_begin_.find(actuator);
  return found != before_begin_.end() &&
         std::ranges::any_of(found->second, [this](const event::StatusSeen& seen) {
           return Runs(config_, seen.report) || SharesItsProcess(seen.report);
         });
}

void ActuatorPeers::Begin() {
  for (const auto& [actuator, all] : std::exchange(before_begin_, {})) {
    for (const event::StatusSeen& seen : all) {
      context_.handle(seen);
      const ActuatorReport& taken = machine_.actuators[actuator].report;
      if (taken.incarnation == seen.report.incarnation) {
        health_->OnReport(actuator, taken, SenderOf(actuator, taken));
      }
    }
  }
}

}  // namespace musher
