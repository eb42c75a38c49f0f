#include "musher/transport/sim/network.hpp"

#include "musher/transport/sim/sim_loop.hpp"
#include "musher/transport/sim/sim_node.hpp"

namespace musher::transport::sim {

namespace {

ProcessId ProcessOf(Node& node) {
  return static_cast<SimNode&>(node).process();
}

}  // namespace

std::unique_ptr<Node> Network::MakeNode(const std::string& host) {
  return std::make_unique<SimNode>(*this, links_.Host(host));
}

void Network::SetFaults(const std::string& from, const std::string& to, const LinkFaults& faults) {
  const HostId source = links_.Host(from);
  links_.SetFaults(source, links_.Host(to), faults);
}

void Network::Partition(const std::string& a, const std::string& b) {
  Block(a, b);
  Block(b, a);
}

void Network::Heal(const std::string& a, const std::string& b) {
  Free(a, b);
  Free(b, a);
}

void Network::SetClockOffset(const std::string& host, Duration offset) {
  links_.SetClockOffset(links_.Host(host), offset);
}

ParticipantId Network::ParticipantOf(Node& node) const {
  return static_cast<SimNode&>(node).participant();
}

void Network::Crash(Node& node) {
  scheduler_.Kill(ProcessOf(node));
  discovery_.Crash(ProcessOf(node));
}

void Network::Pause(Node& node) {
  scheduler_.Pause(ProcessOf(node));
}

void Network::Resume(Node& node) {
  scheduler_.Resume(ProcessOf(node));
}

void Network::RunFor(Duration duration) {
  const Time until = now() + duration;
  while (scheduler_.Step(until)) {
  }
  scheduler_.AdvanceTo(until);
}

bool Network::RunUntil(const std::function<bool()>& done, Time deadline) {
  return RunEventsUntil(scheduler_, done, deadline);
}

void Network::SetBlocked(const std::string& from, const std::string& to, bool blocked) {
  const HostId source = links_.Host(from);
  const HostId target = links_.Host(to);
  if (links_.Blocked(source, target) == blocked) return;
  links_.SetBlocked(source, target, blocked);
  discovery_.LinkChanged(source, target);
}

}  // namespace musher::transport::sim
