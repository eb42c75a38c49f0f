#include "musher/controller/shell/health_watch.hpp"

#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher {

HealthWatch::HealthWatch(transport::Node& node, const MachineConfig& config,
                         ProcessProbe& process_probe, std::string host, Emit emit, Query query)
    : node_(node),
      process_probe_(process_probe),
      host_(std::move(host)),
      emit_(std::move(emit)),
      query_(std::move(query)),
      monitor_(config),
      pids_(config.actuators.size()) {
  for (const ActuatorIndex i : config.actuators.Indices()) index_[config.actuators[i].name] = i;
}

Result<std::unique_ptr<HealthWatch>> HealthWatch::Make(transport::Node& node,
                                                       const MachineConfig& config,
                                                       ProcessProbe& process_probe,
                                                       std::string host, Emit emit, Query query) {
  std::unique_ptr<HealthWatch> watch(new HealthWatch(node, config, process_probe, std::move(host),
                                                     std::move(emit), std::move(query)));
  transport::Qos qos = transport::kHeartbeatQos;
  qos.partition = transport::ReaderPartition(!config.keys.empty());
  auto heartbeats = transport::MakeSubscription<msg::ActuatorBeat>(
      node, transport::ActuatorBeatTopic(config.name_space),
      [self = watch.get()](const msg::ActuatorBeat& heartbeat, const transport::SampleInfo& info) {
        if (transport::IsFrom(heartbeat.name, info)) self->OnHeartbeat(heartbeat);
      },
      qos);
  if (!heartbeats) return heartbeats.error();
  watch->heartbeats_ = std::move(heartbeats).value();
  return watch;
}

void HealthWatch::OnReport(ActuatorIndex actuator, const ActuatorReport& report) {
  const Time now = node_.loop().Now();
  const bool local = !host_.empty() && report.host == host_ && report.pid != 0;
  pids_[actuator] = report.pid;
  monitor_.Watch(actuator, report.incarnation, report.host, local, now);
  Act(monitor_.OnSample(actuator, report.incarnation, now));
}

void HealthWatch::Forget(ActuatorIndex actuator) {
  monitor_.Forget(actuator);
  ArmTimer();
}

void HealthWatch::OnHeartbeat(const msg::ActuatorBeat& heartbeat) {
  const auto found = index_.find(heartbeat.name);
  if (found == index_.end()) return;
  const Heartbeat received{Duration(heartbeat.period_ns), transport::WorkFrom(heartbeat.work),
                           State(heartbeat.during), Duration(heartbeat.silent_ns),
                           Duration(heartbeat.waited_ns)};
  Act(monitor_.OnSample(found->second, Incarnation(heartbeat.incarnation), received,
                        node_.loop().Now()));
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
  const pid_t pid = pids_[f.actuator];
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
