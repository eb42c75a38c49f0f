#include "musher/controller/shell/health_watch.hpp"

#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher {

HealthWatch::HealthWatch(transport::Node& node, const MachineConfig& config,
                         ProcessProbe& process_probe, std::string host, Emit emit, Query query,
                         OnAlive on_alive)
    : node_(node),
      process_probe_(process_probe),
      host_(std::move(host)),
      emit_(std::move(emit)),
      query_(std::move(query)),
      on_alive_(std::move(on_alive)),
      monitor_(config),
      watched_(config.actuators.size()) {
  for (const ActuatorIndex i : config.actuators.Indices()) index_[config.actuators[i].name] = i;
}

Result<std::unique_ptr<HealthWatch>> HealthWatch::Make(transport::Node& node,
                                                       const MachineConfig& config,
                                                       ProcessProbe& process_probe,
                                                       std::string host, Emit emit, Query query,
                                                       OnAlive on_alive) {
  std::unique_ptr<HealthWatch> watch(new HealthWatch(node, config, process_probe, std::move(host),
                                                     std::move(emit), std::move(query),
                                                     std::move(on_alive)));
  transport::Qos qos = transport::kHeartbeatQos;
  qos.partition = transport::ReaderPartition(!config.keys.empty());
  auto heartbeats = transport::MakeSubscription<msg::ActuatorHeartbeat>(
      node, transport::ActuatorHeartbeatTopic(config.name_space),
      [self = watch.get()](const msg::ActuatorHeartbeat& heartbeat,
                           const transport::SampleInfo& info) {
        if (transport::IsFrom(heartbeat.name, info)) self->OnHeartbeat(heartbeat, info.participant);
      },
      qos);
  if (!heartbeats) return heartbeats.error();
  watch->heartbeats_ = std::move(heartbeats).value();
  return watch;
}

void HealthWatch::OnReport(ActuatorIndex actuator, const ActuatorReport& report,
                           transport::ParticipantId participant) {
  const Time now = node_.loop().Now();
  const bool local = !host_.empty() && report.host == host_ && report.pid != 0;
  watched_[actuator] = {report.pid, participant};
  monitor_.Watch(actuator, report.incarnation, report.host, local, now);
  Act(monitor_.OnSample(actuator, report.incarnation, now));
}

void HealthWatch::Forget(ActuatorIndex actuator) {
  monitor_.Forget(actuator);
  ArmTimer();
}

void HealthWatch::ForgetUnlessPresent(ActuatorIndex actuator, const KnownActuator& known) {
  if (known.presence != Presence::kPresent) Forget(actuator);
}

void HealthWatch::OnHeartbeat(const msg::ActuatorHeartbeat& heartbeat,
                              transport::ParticipantId sender) {
  const auto found = index_.find(heartbeat.name);
  if (found == index_.end()) return;
  const transport::ParticipantId own = watched_[found->second].participant;
  if (own != 0 && sender != own) return;  // of another process, or repeated by one
  const Heartbeat received{Duration(heartbeat.period_ns), transport::WorkFrom(heartbeat.work),
                           State(heartbeat.during), Duration(heartbeat.silent_ns),
                           Duration(heartbeat.waited_ns)};
  const Incarnation incarnation(heartbeat.incarnation);
  Act(monitor_.OnSample(found->second, incarnation, received, node_.loop().Now()));
  if (received.work != Health::kHung) on_alive_(found->second, incarnation);
}

void HealthWatch::Act(const std::vector<HealthEvent>& events) {
  for (const HealthEvent& f : events) {
    std::visit([this](const auto& one) { Do(one); }, f);
  }
  ArmTimer();
}

void HealthWatch::Do(const health_event::Probe& f) {
  query_(f.actuator);
}

void HealthWatch::Do(const health_event::Examine& f) {
  const pid_t pid = watched_[f.actuator].pid;
  const Time now = node_.loop().Now();
  if (f.mark) return process_probe_.Mark(f.actuator, pid, now);
  Act(monitor_.Examined(f.actuator, process_probe_.Examine(f.actuator, pid, now), now));
}

void HealthWatch::Do(const health_event::Changed& f) {
  emit_(event::HealthChanged{f.actuator, f.incarnation, f.health, f.silent, f.how});
}

void HealthWatch::ArmTimer() {
  const std::optional<Time> next = monitor_.NextDeadline();
  // A timer that fires too early checks, finds nothing and is armed again: heartbeats need not
  // move it.
  if (!next || (armed_for_ && *armed_for_ <= *next)) return;
  armed_for_ = next;
  timer_ = node_.loop().At(*next, [this] {
    armed_for_.reset();
    Act(monitor_.TimePassed(node_.loop().Now()));
  });
}

}  // namespace musher
