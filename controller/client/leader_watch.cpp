#include "musher/controller/client/leader_watch.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/base/host.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

// A controller of another host is lost after this many missed heartbeats, but not before
// kShortestSilence: a heartbeat may be lost, and a process may wait for a CPU.
constexpr int kHeartbeatsMissed = 4;
constexpr Duration kShortestSilence = Milliseconds(750);
constexpr Duration kSlowestHeartbeat = Milliseconds(500);
constexpr const char* kExited = "has exited";

class PidfdWatch : public transport::LoopHandle {
 public:
  PidfdWatch(transport::EventLoop& loop, UniqueFd process, std::function<void()> on_end)
      : process_(std::move(process)),
        on_end_(std::move(on_end)),
        watch_(loop.WhenReadable(process_.get(), [this] {
          const auto ended = std::move(on_end_);
          watch_ = nullptr;  // it stays readable
          ended();           // last: it may drop this
        })) {}

 private:
  UniqueFd process_;
  std::function<void()> on_end_;
  transport::LoopHandlePtr watch_;
};

}  // namespace

WatchProcess WatchByPidfd(transport::EventLoop& loop) {
  return [&loop](std::int32_t pid, std::function<void()> on_end) -> transport::LoopHandlePtr {
    auto process = OpenPidfd(pid);
    if (!process) return nullptr;
    return std::make_unique<PidfdWatch>(loop, std::move(process).value(), std::move(on_end));
  };
}

LeaderWatch::LeaderWatch(transport::Node& node, Options options, OnStatus on_status, OnEnd on_end)
    : node_(node),
      options_(std::move(options)),
      on_status_(std::move(on_status)),
      on_end_(std::move(on_end)),
      machine_(options_.machine) {
  if (!options_.word.empty()) machine_.name = options_.word;
}

Result<std::unique_ptr<LeaderWatch>> LeaderWatch::Make(transport::Node& node, Options options,
                                                       OnStatus on_status, OnEnd on_end) {
  std::unique_ptr<LeaderWatch> watch(
      new LeaderWatch(node, std::move(options), std::move(on_status), std::move(on_end)));
  if (auto opened = watch->Open(); !opened) return opened.error();
  return watch;
}

Result<> LeaderWatch::Open() {
  auto heartbeats = transport::MakeSubscription<msg::ControllerHeartbeat>(
      node_, transport::ControllerHeartbeatTopic(options_.name_space),
      [this](const msg::ControllerHeartbeat& heartbeat, const transport::SampleInfo& info) {
        if (transport::IsOwn(heartbeat.participant, info)) OnHeartbeat(heartbeat);
      },
      transport::kLatchedFromManyQos);
  // An observer may not read them: then the loss of the status counts.
  if (!heartbeats && heartbeats.error().code != kCodePermissionDenied) return heartbeats.error();
  if (heartbeats) heartbeats_ = std::move(heartbeats).value();
  transport::SubscriptionEvents events;
  events.on_writer_lost = [this](transport::EndpointId writer) {
    if (leader_ && writer == from_.writer) End("no longer leads");
  };
  auto statuses = transport::MakeSubscription<msg::MachineStatus>(
      node_, transport::MachineStatusTopic(options_.name_space),
      [this](const msg::MachineStatus& status, const transport::SampleInfo& info) {
        if (!transport::IsOwn(status.participant, info)) return;
        NoteCandidate({status.machine, status.machine_id});
        OnStatusOf(status, info);
      },
      transport::kLatchedFromManyQos, std::move(events));
  if (!statuses) return statuses.error();
  statuses_ = std::move(statuses).value();
  return Ok();
}

bool LeaderWatch::IsHere(const msg::MachineStatus& status) const {
  return !status.host.empty() && status.host == options_.host;
}

bool LeaderWatch::IsOurs(const msg::MachineStatus& leader) const {
  return options_.watch_process && IsHere(leader);
}

bool LeaderWatch::IsPermitted(const MachineIdentity& machine) const {
  const std::string& word = options_.word;
  return SameMachine(options_.machine, machine) &&
         (word.empty() || machine.name == word || BeginsIdOf(machine, word));
}

void LeaderWatch::NoteCandidate(const MachineIdentity& machine) {
  const auto same = [&machine](const MachineIdentity& one) { return SameMachine(one, machine); };
  const bool is_new = IsPermitted(machine) && std::ranges::none_of(candidates_, same);
  if (is_new && candidates_.size() < kMostCandidates) candidates_.push_back(machine);
}

// Whether the status is of the machine of this host, and another machine was found before.
bool LeaderWatch::ReplacesElsewhere(const msg::MachineStatus& status) const {
  return options_.prefer_here && !found_here_ && IsHere(status) &&
         (!leader_ || !IsHere(*leader_)) &&
         !SameMachine(machine_, {status.machine, status.machine_id});
}

bool LeaderWatch::Follows(const msg::MachineStatus& status,
                          const transport::SampleInfo& from) const {
  const MachineIdentity theirs{status.machine, status.machine_id};
  if (!IsPermitted(theirs)) return false;
  if (ReplacesElsewhere(status)) return true;
  const bool preferred = found_here_ && IsHere(status);
  const bool one = options_.one_machine || options_.one_name || found_here_;
  if (found_ && (leader_ || (one && !preferred))) {
    const bool by_name = options_.one_name && !options_.one_machine && !found_here_ && !leader_;
    if (!SameMachine(by_name ? MachineIdentity{machine_.name, ""} : machine_, theirs)) return false;
  }
  if (leader_) {
    // A status that names the leader's process, but no participant, is a repeated sample if the
    // leader names its participant.
    const bool same = status.pid == leader_->pid && status.host == leader_->host;
    const bool repeated =
        same && from.writer != from_.writer && status.participant == 0 && leader_->participant != 0;
    return status.epoch >= leader_->epoch && !repeated;
  }
  // DDS delivers the latched status of an exited process until the lease of that process expires.
  return ended_ == 0 || from.writer != ended_;
}

void LeaderWatch::OnStatusOf(const msg::MachineStatus& status, const transport::SampleInfo& from) {
  if (!Follows(status, from)) return;
  const bool another = !leader_ || from.writer != from_.writer;
  transport::LoopHandlePtr process;
  if (another && IsOurs(status)) {
    process = options_.watch_process(status.pid, [this] { End(kExited); });
    if (!process && leader_) return;  // the status of a process that has exited ends no other one
  }
  machine_ = {status.machine, status.machine_id};
  found_ = true;
  found_here_ |= options_.prefer_here && IsHere(status);
  if (leader_ && another) End("no longer leads");
  silent_.reset();
  leader_ = status;
  from_ = from;
  if (another) {
    heartbeat_period_ = kSlowestHeartbeat;  // until its heartbeat has the period
    if (!IsOurs(status)) {
      ExpectHeartbeat();
    } else {
      process_ = std::move(process);
      if (!process_) return End(kExited);
    }
  }
  on_status_(status);
}

void LeaderWatch::OnHeartbeat(const msg::ControllerHeartbeat& heartbeat) {
  const auto is_of = [&](const std::optional<msg::MachineStatus>& one) {
    return one && heartbeat.pid == one->pid && heartbeat.host == one->host;
  };
  if (!leader_ && is_of(silent_))
    OnStatusOf(msg::MachineStatus(*silent_), transport::SampleInfo(silent_from_));
  const bool of_leader = is_of(leader_);
  if (!of_leader || IsOurs(*leader_)) return;
  heartbeat_period_ = std::clamp(Duration(heartbeat.period_ns), Duration(Milliseconds(10)),
                                 Duration(std::chrono::seconds(10)));
  ExpectHeartbeat();
}

void LeaderWatch::ExpectHeartbeat() {
  if (!heartbeats_) return;
  transport::EventLoop& loop = node_.loop();
  silence_ = loop.At(loop.Now() + std::max(kHeartbeatsMissed * heartbeat_period_, kShortestSilence),
                     [this] { OnHeartbeatLost(); });
}

void LeaderWatch::OnHeartbeatLost() {
  silent_ = leader_;
  silent_from_ = from_;
  End("sends no heartbeat");
}

void LeaderWatch::End(const std::string& how) {
  const msg::MachineStatus leader = *std::exchange(leader_, std::nullopt);
  if (IsOurs(leader) && how == kExited) ended_ = from_.writer;
  from_ = {};
  process_ = nullptr;
  silence_ = nullptr;
  on_end_(leader, how);
}

}  // namespace musher
