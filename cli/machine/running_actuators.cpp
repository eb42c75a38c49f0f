#include "musher/cli/machine/running_actuators.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {
namespace {

// The latched status of a process that was killed lasts until the lease of its participant expires.
bool HasExited(const msg::ActuatorStatus& status) {
  return status.host == HostId() && status.pid > 0 &&
         RunStateOf(status.pid) == ProcessRunState::kExited;
}

}  // namespace

bool IsOfThisBoot(const std::string& host) {
  const std::string own = HostId();
  const std::string boot = own.substr(0, own.find('/') + 1);
  return !boot.empty() && host.starts_with(boot);
}

Result<std::unique_ptr<RunningActuators>> RunningActuators::Begin(transport::Node& node,
                                                                  const std::string& name_space,
                                                                  bool with_keys) {
  std::unique_ptr<RunningActuators> running(new RunningActuators(node, name_space));
  transport::SubscriptionEvents events;
  events.on_writer_lost = [self = running.get()](transport::EndpointId writer) {
    self->received_.erase(writer);
  };
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(with_keys);
  auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      node, transport::ActuatorStatusTopic(name_space),
      [self = running.get()](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
        if (!transport::IsFrom(status, info)) return;
        self->received_[info.writer] = {status, true, self->loop_.Now(), info.participant,
                                        std::nullopt};
      },
      qos, std::move(events));
  // The permissions of an observer from an earlier version do not allow it: the list stays empty.
  if (!statuses && !with_keys) return statuses.error();
  if (statuses) running->statuses_ = std::move(statuses).value();
  running->FindChildrenHere();
  return running;
}

void RunningActuators::FindChildrenHere() {
  const std::string prefix = NameLock::NameOf(transport::DomainId({}).value(), name_space_, "");
  for (const MarkedProcess& process : FindMarked()) {
    if (process.pid != process.started || !process.mark.starts_with(prefix)) continue;
    const std::string name = process.mark.substr(prefix.size());
    if (name.find('/') == std::string::npos) {
      children_.push_back({name, process.pid, process.start_time});
    }
  }
}

void RunningActuators::OnlyOf(const MachineIdentity& machine) {
  machine_ = machine;
}

std::vector<MachineIdentity> RunningActuators::Machines(bool here) const {
  std::vector<MachineIdentity> machines;
  for (const auto& [writer, actuator] : received_) {
    const msg::ActuatorStatus& status = actuator.status;
    if ((status.host == HostId()) != here) continue;
    const MachineIdentity machine{status.machine, status.machine_id};
    const bool known = std::any_of(machines.begin(), machines.end(),
                                   [&](const auto& other) { return SameMachine(machine, other); });
    if (!known) machines.push_back(machine);
  }
  return machines;
}

bool RunningActuators::IsAnyAwaited() const {
  const std::string prefix = "/" + transport::ResolveName(name_space_, "");
  return std::ranges::any_of(node_.Peers(), [&](const transport::PeerInfo& peer) {
    const bool of_namespace =
        peer.name.starts_with(prefix) && peer.name.find('/', prefix.size()) == std::string::npos;
    return of_namespace && std::ranges::none_of(received_, [&](const auto& one) {
             return one.second.participant == peer.id;
           });
  });
}

std::map<std::string, RunningActuators::Actuator> RunningActuators::Received() const {
  std::map<std::string, Actuator> received;
  for (const auto& [writer, actuator] : received_) {
    const msg::ActuatorStatus& status = actuator.status;
    if (!SameMachine(machine_, {status.machine, status.machine_id})) continue;
    // Of two processes of one actuator that of this host counts.
    const auto known = received.find(status.name);
    if (known != received.end() && known->second.status.host == HostId()) continue;
    received[status.name] = actuator;
  }
  return received;
}

bool RunningActuators::IsTornDown(const std::string& actuator) const {
  const auto received = Received();
  const auto found = received.find(actuator);
  return found != received.end() && found->second.status.state == kTearDown;
}

std::vector<RunningActuators::Actuator> RunningActuators::All() const {
  std::vector<Actuator> all;
  for (const auto& [writer, actuator] : received_) {
    const msg::ActuatorStatus& status = actuator.status;
    const bool ours = SameMachine(machine_, {status.machine, status.machine_id});
    if (ours && status.state != kTearDown && !HasExited(status)) all.push_back(actuator);
  }
  return all;
}

// By its status, also of a container, which has the names of its host and pids of its own.
bool RunningActuators::IsOfAnotherMachine(const std::string& name) const {
  return std::ranges::any_of(received_, [&](const auto& one) {
    const msg::ActuatorStatus& status = one.second.status;
    return status.name == name && IsOfThisBoot(status.host) &&
           !SameMachine(machine_, {status.machine, status.machine_id});
  });
}

std::map<std::string, RunningActuators::Actuator> RunningActuators::Now() const {
  std::map<std::string, Actuator> running;
  const std::map<std::string, Actuator> received = Received();
  for (const auto& [name, actuator] : received) {
    const bool ended = actuator.status.state == kTearDown || HasExited(actuator.status);
    if (!ended) running[name] = actuator;
  }
  const std::string prefix = NameLock::NameOf(transport::DomainId({}).value(), name_space_, "");
  // A status from another host says nothing of the process that holds the name here.
  const auto has_status = [&](const std::string& name) {
    const auto found = received.find(name);
    return found != received.end() && IsOfThisBoot(found->second.status.host) &&
           !HasExited(found->second.status);
  };
  const bool all = std::ranges::all_of(NameLock::HeldBelow(prefix), has_status);
  const auto holders =
      all ? std::map<std::string, NameLock::Holder>() : NameLock::HoldersBelow(prefix);
  for (const auto& [name, holder] : holders) {
    if (has_status(name) || IsOfAnotherMachine(name)) continue;
    Actuator& silent = running[name];
    silent.has_status = false;
    silent.status.name = name;
    silent.status.pid = holder.pid;
    silent.status.host = HostId();
  }
  for (const ChildProcess& child : children_) {
    const bool known = received.contains(child.actuator) || running.contains(child.actuator);
    if (known || !IsRunning(child)) continue;
    Actuator& program = running[child.actuator];
    program.has_status = false;
    program.child = child;
    program.status.name = child.actuator;
    program.status.pid = child.pid;
    program.status.host = HostId();
  }
  return running;
}

}  // namespace musher::cli
