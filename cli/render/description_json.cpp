#include <nlohmann/json.hpp>

#include "musher/base/code.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/description.hpp"
#include "musher/cli/render/json.hpp"

namespace musher::cli {
namespace {

double Ms(Duration duration) {
  return ToSeconds(duration) * 1000;
}

OrderedJson Of(const ActuatorConfig& c, const Description& d) {
  OrderedJson times = OrderedJson::object();
  for (std::size_t i = 0; i < c.states.size() && i < c.times.size(); ++i) {
    times[c.states[i]] = Ms(c.times[i]);
  }
  return {{"file", d.config_file},
          {"line", Known(d.config_line)},
          {"times_ms", times},
          {"argv", c.command},
          {"cwd", Known(c.cwd)},
          {"protocol", ProtocolName(c.protocol)},
          {"stage", c.stage},
          {"after", c.after},
          {"binds_to", c.binds_to},
          {"critical", c.critical},
          {"on_lost", Known(c.on_lost)},
          {"restart_limit", c.restart.policy == RestartPolicy::kNo ? 0 : c.restart.limit}};
}

OrderedJson Of(const ProcessFacts& p) {
  return {{"pid", p.usage.pid},
          {"command", p.command},
          {"cwd", Known(p.cwd)},
          {"started", UtcText(p.started_wall_ns)},
          {"age_s", p.age_s},
          {"cpu_s", p.usage.cpu_seconds},
          {"memory_bytes", p.usage.resident_bytes},
          {"threads", p.usage.threads},
          {"stopped", p.stopped}};
}

}  // namespace

std::string DescriptionJson(const Description& d) {
  OrderedJson heartbeat;
  if (d.heartbeat) {
    heartbeat = {{"age_s", d.heartbeat_age_s},
                 {"period_s", static_cast<double>(d.heartbeat->period_ns) / 1e9},
                 {"checkpoint_silent_s", static_cast<double>(d.heartbeat->silent_ns) / 1e9},
                 {"during", Known(d.heartbeat->during)}};
  }
  OrderedJson stop;
  if (d.status) {
    stop = StopJson(*d.status);
    stop["held"] = d.status->held_by_stop;
  }
  OrderedJson reach = OrderedJson::array();
  for (const auto& r : d.reach) {
    reach.push_back(
        {{"state", r.state}, {"allowed", r.allowed}, {"code", r.code}, {"reason", r.reason}});
  }
  OrderedJson capabilities = OrderedJson::array();
  for (const msg::Capability& c : d.capabilities) {
    capabilities.push_back(
        {{"capability", c.name}, {"allowed", c.allowed}, {"code", c.code}, {"reason", c.reason}});
  }
  OrderedJson history = OrderedJson::array();
  for (std::size_t i = 0; i < d.history.size(); ++i) {
    const msg::HistoryEntry& e = d.history[i];
    history.push_back({{"time", UtcText(e.wall_ns)},
                       {"event", Known(i < d.events.size() ? d.events[i] : "")},
                       {"code", e.code},
                       {"message", e.message}});
  }
  OrderedJson log = OrderedJson::array();
  for (const LogEntry& e : d.log) log.push_back(OrderedJson::parse(LogJson(e)));
  OrderedJson next = OrderedJson::array();
  for (const Advice& step : AdviceFor(d)) {
    next.push_back({{"command", step.command}, {"purpose", step.purpose}});
  }
  const std::int64_t since = SinceOf(d);
  OrderedJson json = {{"actuator", d.name}};
  json.update(d.info ? ActuatorJson(*d.info)
                     : ActuatorJson(d.status.value_or(msg::ActuatorStatus())));
  json.update(
      {{"machine", Known(d.machine)},
       {"machine_state", Known(d.machine_state)},
       {"machine_phase", Known(d.machine_phase)},
       {"no_machine", Known(d.why_no_machine)},
       {"since", since == 0 ? OrderedJson() : OrderedJson(UtcText(since))},
       {"emergency_stop", stop},
       {"heartbeat", heartbeat},
       {"process", d.process ? Of(*d.process) : OrderedJson()},
       {"configured", d.config ? Of(*d.config, d) : OrderedJson()},
       {"reachable", reach},
       {"capabilities", capabilities},
       {"offers", d.offers},
       {"history", history},
       {"log", {{"file", Known(d.log_file)}, {"missing", Known(d.why_no_log)}, {"lines", log}}},
       {"next", next}});
  return JsonLine(json);
}

}  // namespace musher::cli
