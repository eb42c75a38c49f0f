#include "musher/controller/cli/machine/running.hpp"

#include <utility>

#include "musher/base/host.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {

Result<std::unique_ptr<Running>> Running::Begin(transport::Node& node,
                                                const std::string& name_space, bool with_keys) {
  std::unique_ptr<Running> running(new Running(node.loop(), name_space));
  transport::SubscriptionEvents events;
  events.on_writer_lost = [self = running.get()](transport::EndpointId writer) {
    std::erase_if(self->received_,
                  [writer](const auto& one) { return one.second.writer == writer; });
  };
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(with_keys);
  auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      node, transport::ActuatorStatusTopic(name_space),
      [self = running.get()](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
        if (!transport::IsFrom(status.name, info)) return;
        self->received_[status.name] = {status, true, self->loop_.Now(), info.writer, std::nullopt};
      },
      qos, std::move(events));
  // The permissions of an observer from an earlier version do not allow it: the list stays empty.
  if (!statuses && !with_keys) return statuses.error();
  if (statuses) running->statuses_ = std::move(statuses).value();
  running->FindChildrenHere();
  return running;
}

void Running::FindChildrenHere() {
  const std::string prefix = NameLock::NameOf(transport::DomainId({}).value(), name_space_, "");
  for (const MarkedProcess& process : FindMarked()) {
    if (process.pid != process.started || !process.mark.starts_with(prefix)) continue;
    const std::string name = process.mark.substr(prefix.size());
    if (name.find('/') == std::string::npos) {
      children_.push_back({name, process.pid, process.start_time});
    }
  }
}

std::map<std::string, Running::Actuator> Running::Now() const {
  std::map<std::string, Actuator> running;
  for (const auto& [name, actuator] : received_) {
    if (actuator.status.state != kTearDown) running[name] = actuator;
  }
  const std::string prefix = NameLock::NameOf(transport::DomainId({}).value(), name_space_, "");
  for (const std::string& name : NameLock::HeldBelow(prefix)) {
    if (received_.contains(name)) continue;
    Actuator& silent = running[name];
    silent.has_status = false;
    silent.status.name = name;
    silent.status.pid = NameLock::HolderOf(prefix + name).pid;
    silent.status.host = HostId();
  }
  for (const ChildProcess& child : children_) {
    const bool known = received_.contains(child.actuator) || running.contains(child.actuator);
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
