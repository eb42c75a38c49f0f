#include "musher/cli/machine/direct_tear_down.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {
namespace {

constexpr Duration kPeriod = Milliseconds(50);
constexpr Duration kExitGrace = Milliseconds(1000);  // a process that is torn down exits by itself
constexpr Duration kTerminateTime = Milliseconds(2000);
constexpr Duration kKillTime = Milliseconds(1000);
constexpr Duration kHeartbeatPeriod = Milliseconds(200);

bool HasEnded(const UniqueFd& process) {
  pollfd ended{process.get(), POLLIN, 0};
  return poll(&ended, 1, 0) == 1;
}

// Signals its whole process group if it leads one other than that of this process.
void Send(const UniqueFd& process, pid_t pid, int signal) {
  if (!SendSignal(process.get(), signal)) return;
  if (getpgid(pid) == pid && pid != getpgrp()) kill(-pid, signal);
}

}  // namespace

DirectTearDown::DirectTearDown(transport::Node& node, std::string name_space,
                               const RunningActuators& running, Duration timeout)
    : node_(node),
      name_space_(std::move(name_space)),
      running_(running),
      deadline_(node.loop().Now() + timeout) {}

Result<std::unique_ptr<DirectTearDown>> DirectTearDown::Begin(transport::Node& node,
                                                              const std::string& name_space,
                                                              const RunningActuators& running,
                                                              Duration timeout) {
  std::unique_ptr<DirectTearDown> ending(new DirectTearDown(node, name_space, running, timeout));
  if (auto opened = ending->Open(); !opened) return opened.error();
  return ending;
}

Result<> DirectTearDown::Open() {
  const int domain = transport::DomainId({}).value();
  for (const auto& [name, actuator] : running_.Now()) {
    Target& target = targets_[name];
    target.outcome.name = name;
    target.outcome.pid = actuator.status.pid;
    target.elsewhere = actuator.status.host != HostId();
    if (actuator.status.host == HostId()) {
      const std::string lock = NameLock::NameOf(domain, name_space_, name);
      auto process = OpenPidfd(actuator.status.pid);
      // Opens the pidfd first, then checks it: a pid in a status is unproven.
      const bool proven = actuator.child ? IsRunning(*actuator.child)
                                         : NameLock::CheckHolder(lock, actuator.status.pid).ok();
      target.here = process && proven;
      if (target.here) target.process = std::move(process).value();
    }
    target.outcome.has_tear_down = !actuator.child;
    target.outcome.trouble = "its process publishes no status";
    if (actuator.has_status) Know(target, actuator.status);
    if (actuator.child) continue;
    auto commands = transport::MakeClient<msg::ActuatorCommand>(
        node_, transport::CommandService(name_space_, name));
    if (!commands) return commands.error();
    target.commands = std::move(commands).value();
  }
  auto heartbeats = transport::MakePublisher<msg::ControllerHeartbeat>(
      node_, transport::ControllerHeartbeatTopic(name_space_), transport::kLatchedQos);
  if (!heartbeats) return heartbeats.error();
  heartbeats_ = std::move(heartbeats).value();
  heartbeat_ = {machine_.name, epoch_.value(), NewIncarnation(),
                HostId(),      getpid(),       kHeartbeatPeriod.count(),
                HostName(),    machine_.id,    node_.participant().value()};
  if (auto published = heartbeats_->Publish(heartbeat_); !published) return published;
  timer_ = node_.loop().Every(kPeriod, [this] { Advance(); });
  return Ok();
}

void DirectTearDown::Know(Target& target, const msg::ActuatorStatus& status) {
  target.known = true;
  target.host = status.host;
  target.incarnation = status.incarnation;
  target.outcome.trouble = "";
  epoch_ = std::max(epoch_, Epoch(status.epoch) + 1);
  machine_ = {status.machine, status.machine_id};
}

void DirectTearDown::Advance() {
  const Time now = node_.loop().Now();
  const auto running = running_.Now();
  // A status that is late may show that what holds the name is of another machine.
  std::erase_if(targets_, [this](const auto& one) {
    const auto& [name, target] = one;
    return !target.known && target.outcome.has_tear_down && !target.terminated_at &&
           !running_.HasStatusOf(name) && running_.IsOfAnotherMachine(name);
  });
  for (auto& [name, target] : targets_) {
    Check(target, running);
    if (target.outcome.ended) continue;
    const bool torn_down = target.outcome.torn_down;
    if (!torn_down && now < deadline_ && target.commands) {
      CommandTearDown(target, running);
    } else if (MayBeSignalled(target, now)) {
      Signal(target);
    }
  }
}

// Not while another actuator of its process is torn down, nor just after that.
bool DirectTearDown::MayBeSignalled(const Target& target, Time now) const {
  return std::all_of(targets_.begin(), targets_.end(), [&](const auto& one) {
    const Target& other = one.second;
    const bool of_process =
        &other == &target || (other.here && target.here && other.outcome.pid == target.outcome.pid);
    if (!of_process) return true;
    if (other.torn_down_at) return now >= *other.torn_down_at + kExitGrace;
    return &other == &target || !other.commands || now >= deadline_;
  });
}

void DirectTearDown::Check(Target& target, const Actuators& running) {
  const bool runs = running.contains(target.outcome.name);
  const bool has_status = running_.HasStatusOf(target.outcome.name);
  if (!runs && !target.outcome.torn_down && running_.IsTornDown(target.outcome.name)) {
    target.outcome.torn_down = true;
    target.torn_down_at = node_.loop().Now();
  }
  if (target.here) {
    target.outcome.ended = HasEnded(target.process);
    return;
  }
  // One of another host is lost with the link, too; one of this host holds its name as long as it
  // runs.
  const bool lost = !runs && !has_status;
  target.outcome.ended = lost && (target.outcome.torn_down || !target.elsewhere);
  if (lost && !target.outcome.ended) target.outcome.trouble = "its status is lost, it may run on";
}

void DirectTearDown::CommandTearDown(Target& target, const Actuators& running) {
  const auto found = running.find(target.outcome.name);
  if (target.commanded || found == running.end() || !found->second.has_status) return;
  // What was found by its name runs here; a process elsewhere may announce itself first.
  if (!target.known && !IsOfThisBoot(found->second.status.host)) return;
  // An actuator of another machine may have the same name: only this process is commanded.
  const transport::ParticipantId participant = found->second.participant;
  const std::vector<transport::ParticipantId> servers = target.commands->Servers();
  if (std::find(servers.begin(), servers.end(), participant) == servers.end()) return;
  const msg::ActuatorStatus& status = found->second.status;
  const Time now = node_.loop().Now();
  if (!target.known) Know(target, status);
  target.commanded = true;
  heartbeat_.epoch = epoch_.value();
  heartbeat_.machine = machine_.name;
  heartbeat_.machine_id = machine_.id;
  static_cast<void>(heartbeats_->Publish(heartbeat_));  // it obeys only an announced controller
  msg::ActuatorCommand::Request request;
  request.kind = msg::ActuatorCommand::kKindSwitch;
  request.epoch = epoch_.value();
  request.number = std::max(CommandNumber(status.number), target.last_number).value() + 1;
  request.target = State(kTearDown);
  request.budget_ns = Duration(deadline_ - now).count();
  const bool replied = target.stamp_ns != 0;
  request.status_stamp_ns = replied ? target.stamp_ns : status.stamp_ns;
  request.since_status_ns =
      Duration(now - (replied ? target.stamped_at : found->second.at)).count();
  request.incarnation = status.incarnation;
  request.machine = machine_.name;
  request.machine_id = machine_.id;
  const auto on_reply = [this, &target](const auto& reply) {
    target.commanded = false;  // commanded again if it was refused
    if (!reply) return;
    const bool done = reply.value().verdict == msg::ActuatorCommand::kVerdictDone;
    target.outcome.trouble = done ? "" : reply.value().message;
    if (!done) return Learn(target, reply.value().status);
    if (target.outcome.torn_down) return;
    target.outcome.torn_down = true;
    target.torn_down_at = node_.loop().Now();
  };
  target.commands->Call(request, deadline_ - now, on_reply, participant);
}

// A command that was refused counts in the actuator, and is in no status that it publishes: its
// next one has to have a higher number, and an epoch above that of its sender.
void DirectTearDown::Learn(Target& target, const msg::ActuatorStatus& status) {
  target.last_number = std::max(target.last_number, CommandNumber(status.number));
  epoch_ = std::max(epoch_, Epoch(status.epoch) + 1);
  target.stamp_ns = status.stamp_ns;
  target.stamped_at = node_.loop().Now();
}

void DirectTearDown::Signal(Target& target) {
  const Time now = node_.loop().Now();
  if (!target.here) return;
  if (!target.terminated_at) {
    target.terminated_at = now;
    target.outcome.signal = "SIGTERM";
    Send(target.process, target.outcome.pid, SIGTERM);
    Send(target.process, target.outcome.pid, SIGCONT);  // a stopped one handles SIGTERM only then
  } else if (!target.killed && now >= *target.terminated_at + kTerminateTime) {
    target.killed = true;
    target.outcome.signal = "SIGKILL";
    Send(target.process, target.outcome.pid, SIGKILL);
  }
}

bool DirectTearDown::Ended() const {
  return std::all_of(targets_.begin(), targets_.end(),
                     [](const auto& one) { return one.second.outcome.ended; });
}

bool DirectTearDown::OutOfTime() const {
  return node_.loop().Now() >= deadline_ + kExitGrace + kTerminateTime + kKillTime;
}

std::vector<DirectTearDown::Outcome> DirectTearDown::Outcomes() const {
  std::vector<Outcome> outcomes;
  for (const auto& [name, target] : targets_) outcomes.push_back(target.outcome);
  return outcomes;
}

// Also a status that has arrived only when its process, found by its name, was ended by a signal.
bool DirectTearDown::IsOf(const msg::ActuatorStatus& status, const Target& target) {
  const bool known = target.host == status.host && target.incarnation == status.incarnation;
  return known || (target.here && status.host == HostId() && status.pid == target.outcome.pid);
}

std::vector<DirectTearDown::Other> DirectTearDown::Others() const {
  std::vector<Other> others;
  const std::vector<transport::PeerInfo> peers = node_.Peers();
  for (const RunningActuators::Actuator& actuator : running_.All()) {
    const msg::ActuatorStatus& status = actuator.status;
    const auto found = targets_.find(status.name);
    if (found != targets_.end() && IsOf(status, found->second)) continue;
    const auto peer = std::ranges::find(peers, actuator.participant, &transport::PeerInfo::id);
    const bool named = peer != peers.end() && !peer->host.empty();
    others.push_back({status.name, status.pid, named ? peer->host : status.host});
  }
  return others;
}

}  // namespace musher::cli
