#include "musher/controller/cli/latching.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/health.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/transport/lifecycle_wire.hpp"

namespace musher::cli {
namespace {

// Whether it may move: one that crashed does not, one that is out of reach may.
bool IsThere(const msg::ActuatorInfo& actuator) {
  return actuator.presence == PresenceName(Presence::kPresent) ||
         actuator.health == HealthName(Health::kHung) ||
         actuator.health == HealthName(Health::kPartitioned);
}

}  // namespace

std::vector<std::string> EstopReport::Missing() const {
  std::vector<std::string> missing;
  for (const Actuator& actuator : actuators) {
    if (!actuator.stopped) missing.push_back(actuator.name);
  }
  return missing;
}

bool EstopReport::settled() const {
  return controller == controller_took && (!controller || knows_who) &&
         std::all_of(actuators.begin(), actuators.end(),
                     [](const Actuator& actuator) { return actuator.stopped || actuator.deaf; });
}

Latching::Latching(transport::Node& node, msg::EmergencyStop stop)
    : loop_(node.loop()), stop_(std::move(stop)), begun_(loop_.Now()) {}

Result<std::unique_ptr<Latching>> Latching::Begin(transport::Node& node,
                                                  const std::string& name_space,
                                                  const msg::EmergencyStop& stop, bool with_keys) {
  std::unique_ptr<Latching> latching(new Latching(node, stop));
  auto stops = transport::MakePublisher<msg::EmergencyStop>(
      node, transport::EmergencyStopTopic(name_space), transport::kLatchedQos);
  if (!stops) return stops.error();
  latching->stops_ = std::move(stops).value();
  if (auto told = latching->stops_->Publish(stop); !told) return told.error();
  transport::SubscriptionEvents events;
  events.on_writer_lost = [self = latching.get()](transport::PeerId writer) {
    std::erase_if(self->heard_,
                  [writer](const auto& heard) { return heard.second.writer == writer; });
  };
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::HearingPartition(with_keys);
  auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      node, transport::ActuatorStatusTopic(name_space),
      [self = latching.get()](const msg::ActuatorStatus& status,
                              const transport::SampleInfo& info) {
        if (transport::IsFrom(status.name, info)) self->OnStatus(status, info);
      },
      qos, std::move(events));
  if (!statuses) return statuses.error();
  latching->statuses_ = std::move(statuses).value();
  return latching;
}

void Latching::OnStatus(const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
  Heard& heard = heard_[status.name];
  const bool news = heard.writer != info.writer || heard.latched != status.emergency_stop;
  if (news) heard = {info.writer, status.emergency_stop, loop_.Now() - begun_};
}

EstopReport Latching::Report(const std::optional<msg::MachineStatus>& controller) const {
  EstopReport report;
  report.by = stop_.by;
  report.reason = stop_.reason;
  if (controller) {
    report.controller = true;
    report.controller_took = controller->emergency_stop;
    for (const msg::ActuatorInfo& actuator : controller->actuators) {
      const bool well = actuator.health == HealthName(Health::kWell);
      if (!IsThere(actuator) && !heard_.contains(actuator.name)) continue;
      auto& taken = Take(report, actuator.name, well ? "" : actuator.health);
      taken.deaf = actuator.protocol != ProtocolName(Protocol::kMusher);
      if (taken.deaf) taken.trouble = "knows no emergency stop (" + actuator.protocol + ")";
    }
  }
  const auto listed = [&report](const std::string& name) {
    return std::any_of(report.actuators.begin(), report.actuators.end(),
                       [&name](const auto& actuator) { return actuator.name == name; });
  };
  for (const auto& [name, heard] : heard_) {
    if (!listed(name)) Take(report, name, "");
  }
  const bool other = controller && !controller->emergency_stop_by.empty() &&
                     (controller->emergency_stop_by != stop_.by ||
                      controller->emergency_stop_reason != stop_.reason);
  const bool before = std::any_of(report.actuators.begin(), report.actuators.end(),
                                  [](const auto& actuator) { return actuator.before; });
  // It may have heard of the stop from an actuator first. Whoever engaged this one must not go
  // before he was heard himself.
  report.knows_who = before || (controller && !controller->emergency_stop_by.empty());
  if (before || other) report.earlier.emplace();
  if (report.earlier && controller) {
    *report.earlier = {controller->emergency_stop_by, controller->emergency_stop_reason};
  }
  return report;
}

EstopReport::Actuator& Latching::Take(EstopReport& report, const std::string& name,
                                      const std::string& trouble) const {
  EstopReport::Actuator& actuator = report.actuators.emplace_back();
  actuator.name = name;
  actuator.trouble = trouble;
  const auto heard = heard_.find(name);
  if (heard == heard_.end() || heard->second.latched == 0) return actuator;
  actuator.stopped = true;
  actuator.before = heard->second.latched != stop_.id;
  if (!actuator.before) actuator.after = heard->second.after;
  return actuator;
}

}  // namespace musher::cli
