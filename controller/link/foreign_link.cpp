#include "musher/controller/link/foreign_link.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

bool Contains(const std::vector<transport::ParticipantId>& servers,
              transport::ParticipantId server) {
  return std::find(servers.begin(), servers.end(), server) != servers.end();
}

}  // namespace

ForeignLink::ForeignLink(transport::Node& node, const MachineConfig& config, ActuatorIndex actuator,
                         Emit emit)
    : node_(node), config_(config), actuator_(actuator), emit_(std::move(emit)) {}

void ForeignLink::Switch(const SwitchCommand& command) {
  Post([this, command] { Take(command); });
}

void ForeignLink::Query(const QueryCommand& command) {
  Post([this, command] { Take(command); });
}

void ForeignLink::Post(std::function<void()> work) {
  node_.loop().Post([alive = std::weak_ptr<bool>(alive_), work = std::move(work)] {
    if (!alive.expired()) work();
  });
}

void ForeignLink::OnProcess(std::int32_t pid) {
  process_ = pid;
  found_ = false;
}

// Its server may already be matched.
void ForeignLink::OnProcessFound(std::int32_t pid) {
  process_ = pid;
  found_ = true;
  if (available()) report_.pid = pid;
}

// The exit of a process on this host is reported before its server is lost: the server stays
// matched until the lease of its participant expires.
void ForeignLink::OnProcessEnded(std::int32_t pid) {
  if (pid != process_) return;
  process_ = 0;
  if (!available()) return;
  ended_.insert(server_);
  Forget();
}

void ForeignLink::OnParticipantWatched(transport::ParticipantId participant) {
  watched_.insert(participant);
}

void ForeignLink::OnParticipantEnded(transport::ParticipantId participant, std::int32_t pid) {
  watched_.erase(participant);
  if (!Contains(servers_, participant)) return;
  ended_.insert(participant);
  if (server_ != participant) return NoteDoubles();
  ReportVanished("its process " + std::to_string(pid) + " ended", true);
  Forget();
  TakeOther();
}

void ForeignLink::OnServers(std::vector<transport::ParticipantId> servers) {
  const std::vector<transport::ParticipantId> before = std::exchange(servers_, std::move(servers));
  const auto newcomer =
      std::find_if(servers_.begin(), servers_.end(),
                   [&](transport::ParticipantId s) { return !Contains(before, s); });
  std::erase_if(ended_, [&](transport::ParticipantId s) { return !Contains(servers_, s); });
  std::erase_if(watched_, [&](transport::ParticipantId s) { return !Contains(servers_, s); });
  if (newcomer != servers_.end()) {
    if (!available() || !Contains(servers_, server_)) return Appear(*newcomer);
    newcomer_ = *newcomer;
    return watched_.contains(server_) ? EndComparison(true) : Compare();
  }
  if (!available()) return;
  if (Contains(servers_, server_)) return NoteDoubles();
  if (TakeOther()) return;
  ReportVanished("its services are lost");
  Forget();
}

// The newest of the other processes with the name, if there is one.
bool ForeignLink::TakeOther() {
  const auto other = std::find_if(servers_.rbegin(), servers_.rend(),
                                  [&](transport::ParticipantId s) { return !ended_.contains(s); });
  if (other == servers_.rend()) return false;
  Appear(*other);
  return true;
}

void ForeignLink::EndComparison(bool first_runs) {
  const transport::ParticipantId newcomer = std::exchange(newcomer_, {});
  if (newcomer == 0 || !Contains(servers_, newcomer)) return;
  if (first_runs) return NoteDoubles();
  ended_.insert(server_);
  Appear(newcomer);
}

// Part of its report, so that the machine lists it as degraded for as long as there are two.
void ForeignLink::NoteDoubles() {
  if (newcomer_ != 0) return;  // not known yet
  std::string others;
  for (const transport::ParticipantId server : servers_) {
    if (server == server_ || ended_.contains(server)) continue;
    others += (others.empty() ? "" : ", ") + ProcessText(server);
  }
  const std::string name = "/" + transport::ResolveName(config_.name_space, actuator().name);
  const std::string reason = others.empty()
                                 ? ""
                                 : "two nodes " + name + ": " + ProcessText(server_) +
                                       ", which is driven, and " + others +
                                       ", which receives the same requests; end one of them";
  if (report_.degraded_reason == reason) return;
  report_.degraded_code = others.empty() ? kCodeOk : kCodeStatusError;
  report_.degraded_reason = reason;
  ReportStatus();
}

// "process 4711", by what it says of itself.
std::string ForeignLink::ProcessText(transport::ParticipantId server) const {
  for (const transport::PeerInfo& peer : node_.Peers()) {
    if (peer.id != server || peer.pid == 0) continue;
    return "process " + std::to_string(peer.pid) +
           (peer.host.empty() ? "" : " of host " + peer.host.substr(0, 64));
  }
  return "a process that does not say its number";
}

void ForeignLink::Appear(transport::ParticipantId server) {
  if (available()) Forget();
  server_ = server;
  const Incarnation now(static_cast<std::uint64_t>(Duration(Now().time_since_epoch()).count()));
  const Incarnation incarnation = std::max(report_.incarnation + 1, now);
  report_ = {};
  report_.state = config_.default_state;
  report_.incarnation = incarnation;
  report_.pid = process_;
  OnAppeared();
  NoteDoubles();
}

void ForeignLink::Forget() {
  server_ = 0;
  newcomer_ = 0;
  pending_.reset();
  waiting_.reset();
  OnLost();
}

void ForeignLink::Take(const SwitchCommand& command) {
  if (!available() || command.incarnation != report_.incarnation) return;  // it was lost meanwhile
  report_.epoch = std::max(report_.epoch, command.epoch);
  report_.number = std::max(report_.number, command.number);
  if (!actuator().Lists(command.target) || command.target == kSetUp) {
    return Refuse(command.number,
                  Refused<Refusal::kNoStateToSwitchTo>(actuator().name, command.target));
  }
  if (!pending_) return Begin(command);
  if (const auto older = std::exchange(waiting_, WaitingCommand{command, Now()})) {
    Refuse(older->command.number, Refused<Refusal::kCommandReplaced>(command.number));
  }
}

void ForeignLink::Take(const QueryCommand& command) {
  if (!available()) return;
  report_.epoch = std::max(report_.epoch, command.epoch);
  report_.number = std::max(report_.number, command.number);
  if (waiting_ && waiting_->command.number <= command.number) {
    const auto fenced = *std::exchange(waiting_, std::nullopt);
    Refuse(fenced.command.number, Refused<Refusal::kCommandCancelled>());
  }
  if (pending_ && command.stop) {
    pending_->stopped = true;
    if (pending_->number == command.number) pending_->queried = true;
  }
  Inquire(command);
}

void ForeignLink::Begin(const SwitchCommand& command) {
  pending_ = PendingCommand{command.number, command.target, Now() + command.budget, false, false};
  report_.target = command.target;
  report_.busy_number = command.number;
  Drive();
}

void ForeignLink::BeginSetUp(Duration budget) {
  pending_ = PendingCommand{0, State(kSetUp), Now() + budget, false, false};
  report_.target = State(kSetUp);
  report_.busy_number = 0;
  Drive();
}

void ForeignLink::BeginWaiting() {
  const auto next = std::exchange(waiting_, std::nullopt);
  if (!next) return;
  if (Now() - next->since > next->command.budget) {
    return Refuse(next->command.number, Refused<Refusal::kCommandWaitedTooLong>());
  }
  Begin(next->command);
}

void ForeignLink::DropPending() {
  pending_.reset();
  report_.target = {};
  report_.busy_number = 0;
  ReportStatus();
  BeginWaiting();
}

void ForeignLink::End(Verdict verdict, std::int32_t code, const std::string& message) {
  const PendingCommand ended = *std::exchange(pending_, std::nullopt);
  report_.target = {};
  report_.busy_number = 0;
  if (verdict != Verdict::kRefused) {
    report_.outcome_number = ended.number;
    report_.outcome_code = code;
    report_.outcome_message = message;
  }
  if (verdict == Verdict::kDone) Arrive(ended.target);
  if (ended.number != 0) Reply(ended.number, false, verdict, code, message);
  // The coordinator does not wait for the reply of an overdue command; it needs the free status.
  if (ended.number == 0 || ended.queried) ReportStatus();
  BeginWaiting();
}

// As in an actuator of Musher's own: in the run phase a SelfCheck changes no state, during the
// start it is a step.
void ForeignLink::Arrive(const State& target) {
  const State& at = report_.state;
  if (target == kSelfCheck && at != kSetUp && at != kSelfCheck && at != kError) return;
  report_.state = target;
}

void ForeignLink::Reply(CommandNumber number, bool query, Verdict verdict, std::int32_t code,
                        const std::string& message) {
  emit_(event::Replied{actuator_, number, query, verdict, code, message, Stamped()});
}

void ForeignLink::ReportStatus() {
  emit_(event::StatusSeen{actuator_, Stamped()});
}

void ForeignLink::ReportVanished(const std::string& how, bool for_good) {
  emit_(event::Vanished{actuator_, report_.incarnation, for_good, how});
}

// Stamps are strictly increasing: of two reports at the same time the later one counts.
ActuatorReport ForeignLink::Stamped() {
  report_.stamp = std::max(Now(), report_.stamp + Duration(1));
  return report_;
}

}  // namespace musher
