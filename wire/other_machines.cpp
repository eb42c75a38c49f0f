#include "musher/wire/other_machines.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::transport {
namespace {

constexpr std::size_t kMostProcesses = 256;  // with lost ones among them
constexpr std::size_t kMostWaiting = 64;
constexpr std::size_t kLongestText = 128;  // of a name, an id and a host

}  // namespace

Result<std::unique_ptr<OtherMachines>> OtherMachines::Make(Node& node,
                                                           std::string_view name_space) {
  std::unique_ptr<OtherMachines> machines(new OtherMachines(node));
  OtherMachines* self = machines.get();
  auto statuses = MakeSubscription<msg::ActuatorStatus>(
      node, ActuatorStatusTopic(name_space),
      [self](const msg::ActuatorStatus& status, const SampleInfo& info) {
        self->Take(status, info, IsFrom(status, info));
      },
      kLatchedFromManyQos);
  if (!statuses) return statuses.error();
  machines->statuses_ = std::move(statuses).value();
  auto heartbeats = MakeSubscription<msg::ControllerHeartbeat>(
      node, ControllerHeartbeatTopic(name_space),
      [self](const msg::ControllerHeartbeat& heartbeat, const SampleInfo& info) {
        self->Take(heartbeat, info, IsOwn(heartbeat.participant, info));
      },
      kLatchedFromManyQos);
  if (!heartbeats) return heartbeats.error();
  machines->heartbeats_ = std::move(heartbeats).value();
  return machines;
}

// A bridge repeats the samples of other participants, and a sample without its participant may be
// one of those: what sends them belongs to no machine.
template <class M>
void OtherMachines::Take(const M& sample, const SampleInfo& info, bool is_own) {
  Process process{info.participant, {}, {}};
  if (is_own && sample.participant != 0) {
    process.machine = {sample.machine.substr(0, kLongestText),
                       sample.machine_id.substr(0, kLongestText)};
    process.host = sample.host.substr(0, kLongestText);
  }
  if (info.participant == own_participant_) {
    own_ = std::move(process);
    return;
  }
  std::erase_if(others_,
                [&info](const Process& one) { return one.participant == info.participant; });
  if (others_.size() >= kMostProcesses) ForgetOneThatIsLost();
  others_.push_back(std::move(process));
  std::vector<std::uint64_t> ready;
  for (const auto& [number, waiting] : waiting_) {
    if (waiting.participant == info.participant) ready.push_back(number);
  }
  for (const std::uint64_t number : ready) EndWait(number, true);
}

// Never one that is matched: its status came hours ago, and comes again only when it changes. Those
// are as many as the participants that DDS knows.
void OtherMachines::ForgetOneThatIsLost() {
  const auto lost = std::ranges::find_if(
      others_, [this](const Process& one) { return !IsMatched(one.participant); });
  if (lost != others_.end()) others_.erase(lost);
}

void OtherMachines::EndWait(std::uint64_t number, bool known) {
  const auto waiting = waiting_.extract(number);
  if (waiting) waiting.mapped().then(known);
}

bool OtherMachines::IsMatched(ParticipantId participant) const {
  return statuses_->HasWriterOf(participant) || heartbeats_->HasWriterOf(participant);
}

const OtherMachines::Process* OtherMachines::Find(ParticipantId participant) const {
  const auto found = std::ranges::find(others_, participant, &Process::participant);
  return found == others_.end() ? nullptr : &*found;
}

const MachineIdentity* OtherMachines::Of(ParticipantId participant) const {
  const Process* process = Find(participant);
  if (process == nullptr) return nullptr;
  const bool of_this_host = !own_.host.empty() && process->host == own_.host;
  return of_this_host || SameMachine(own_.machine, process->machine) ? nullptr : &process->machine;
}

bool OtherMachines::IsAwaited(ParticipantId participant) const {
  if (participant == own_participant_ || Find(participant) != nullptr) return false;
  return IsMatched(participant);
}

void OtherMachines::OnceKnown(ParticipantId participant, Duration timeout,
                              std::function<void(bool known)> then) {
  if (!IsAwaited(participant)) return then(true);
  if (waiting_.size() >= kMostWaiting) EndWait(waiting_.begin()->first, false);
  const std::uint64_t number = ++last_number_;
  waiting_[number] = {participant, std::move(then),
                      loop_.At(loop_.Now() + timeout, [this, number] { EndWait(number, false); })};
}

}  // namespace musher::transport
