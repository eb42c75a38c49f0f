#include "musher/view/live/meant_servers.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/words.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view {
namespace {

constexpr Duration kPeriod = Milliseconds(20);

}  // namespace

MeantServers::MeantServers(transport::Node& node, const std::string& name_space, bool with_keys)
    : node_(node), name_space_(name_space) {
  transport::SubscriptionEvents events;
  events.on_writer_lost = [this](transport::EndpointId writer) { known_.erase(writer); };
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(with_keys);
  auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      node, transport::ActuatorStatusTopic(name_space),
      [this](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
        if (!transport::IsFrom(status, info)) return;
        known_[info.writer] = {{status.machine, status.machine_id}, info.participant};
      },
      qos, std::move(events));
  if (statuses) statuses_ = std::move(statuses).value();
}

void MeantServers::Check(const std::string& name, Servers servers, const MachineIdentity& meant,
                         std::function<void(std::optional<Error>)> then) {
  waiting_.push_back({name, std::move(servers), meant, std::move(then), node_.loop().Now()});
  if (!timer_) timer_ = node_.loop().Every(kPeriod, [this] { LookAtAll(); });
}

void MeantServers::LookAtAll() {
  std::list<WaitingCall> ended;
  for (auto at = waiting_.begin(); at != waiting_.end();) {
    const auto next = std::next(at);
    if (!Waits(*at)) ended.splice(ended.end(), waiting_, at);
    at = next;
  }
  if (waiting_.empty()) timer_ = nullptr;
  for (const WaitingCall& one : ended) one.then(WhyNot(one));
}

bool MeantServers::Waits(WaitingCall& waiting) const {
  const Time now = node_.loop().Now();
  const auto servers = waiting.servers();
  if (servers.empty()) return now < waiting.begun + kServersWithin;
  if (!waiting.found_at) waiting.found_at = now;
  const bool all_known = std::ranges::all_of(
      servers, [this](const auto& server) { return MachineOf(server) != nullptr; });
  return now < *waiting.found_at + (all_known || !statuses_ ? kOthersWithin : kStatusWithin);
}

std::optional<Error> MeantServers::WhyNot(const WaitingCall& waiting) const {
  const auto servers = waiting.servers();
  if (servers.empty()) {
    return Error{kCodeTimeout, "no actuator " + waiting.name + " answers. Nothing was done"};
  }
  std::vector<MachineIdentity> machines;
  bool unknown = false;
  for (const transport::ParticipantId server : servers) {
    const MachineIdentity* machine = MachineOf(server);
    unknown |= machine == nullptr || (machine->name.empty() && machine->id.empty());
    const bool is_new = machine != nullptr && std::ranges::none_of(machines, [&](const auto& one) {
                          return SameMachine(one, *machine);
                        });
    if (is_new) machines.push_back(*machine);
  }
  if (unknown && servers.size() > 1) {
    return Error{kCodeTargetBusy, waiting.name +
                                      " is served by several processes, and the machine "
                                      "of one of them is not known. Nothing was done"};
  }
  if (machines.empty()) return std::nullopt;
  if (machines.size() == 1 && SameMachine(machines.front(), waiting.meant)) return std::nullopt;
  if (machines.size() == 1) {
    return Error{kCodeTargetBusy, waiting.name + " is an actuator of " +
                                      MachineText(machines.front()) + ", and the page shows " +
                                      MachineText(waiting.meant) + ". Nothing was done"};
  }
  std::string list;
  for (const MachineIdentity& one : machines) list += (list.empty() ? "" : ", ") + MachineText(one);
  return Error{kCodeTargetBusy, waiting.name + " is an actuator of several machines in " +
                                    NamespaceText(name_space_) + ": " + list +
                                    ". Nothing was done: each of them would receive it; give each "
                                    "a namespace"};
}

bool MeantServers::IsMeant(transport::ParticipantId server,
                           const std::vector<transport::ParticipantId>& servers,
                           const MachineIdentity& meant) const {
  const auto is_known = [](const MachineIdentity* machine) {
    return machine != nullptr && !(machine->name.empty() && machine->id.empty());
  };
  const MachineIdentity* machine = MachineOf(server);
  if (is_known(machine) && is_known(&meant)) return SameMachine(*machine, meant);
  if (servers.size() < 2) return true;
  return std::ranges::all_of(servers, [&](const transport::ParticipantId one) {
    const MachineIdentity* other = MachineOf(one);
    return one == server || (is_known(machine) && is_known(other) && SameMachine(*machine, *other));
  });
}

std::optional<MachineIdentity> MeantServers::OtherThan(
    const MachineIdentity& meant, const std::vector<transport::ParticipantId>& participants) const {
  for (const transport::ParticipantId participant : participants) {
    const MachineIdentity* machine = MachineOf(participant);
    if (machine != nullptr && !SameMachine(*machine, meant)) return *machine;
  }
  return std::nullopt;
}

const MachineIdentity* MeantServers::MachineOf(transport::ParticipantId participant) const {
  const auto found = std::ranges::find_if(
      known_, [&](const auto& each) { return each.second.participant == participant; });
  return found == known_.end() ? nullptr : &found->second.machine;
}

}  // namespace musher::view
