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

Json Of(const ActuatorConfig& c, const Description& d) {
  Json times = Json::object();
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

Json Of(const ProcessFacts& p) {
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
  Json heartbeat;
  if (d.heartbeat) {
    heartbeat = {{"age_s", d.heartbeat_age_s},
                 {"period_s", static_cast<double>(d.heartbeat->period_ns) / 1e9},
                 {"checkpoint_silent_s", static_cast<double>(d.heartbeat->silent_ns) / 1e9},
                 {"during", Known(d.heartbeat->during)}};
  }
  Json stop;
  if (d.status) {
    stop = StopJson(*d.status);
    stop["held"] = d.status->held_by_stop;
  }
  Json reach = Json::array();
  for (const auto& r : d.reach) {
    reach.push_back(
        {{"state", r.state}, {"allowed", r.allowed}, {"code", r.code}, {"reason", r.reason}});
  }
  Json capabilities = Json::array();
  for (const msg::Capability& c : d.capabilities) {
    capabilities.push_back(
        {{"capability", c.name}, {"allowed", c.allowed}, {"code", c.code}, {"reason", c.reason}});
  }
  Json history = Json::array();
  for (std::size_t i = 0; i < d.history.size(); ++i) {
    const msg::HistoryEntry& e = d.history[i];
    history.push_back({{"time", UtcText(e.wall_ns)},
                       {"event", Known(i < d.events.size() ? d.events[i] : "")},
                       {"code", e.code},
                       {"message", e.message}});
  }
  Json log = Json::array();
  for (const LogEntry& e : d.log) log.push_back(Json::parse(LogJson(e)));
  Json next = Json::array();
  for (const Advice& step : AdviceFor(d)) {
    next.push_back({{"command", step.command}, {"purpose", step.purpose}});
  }
  const std::int64_t since = SinceOf(d);
  Json json = {{"actuator", d.name}};
  json.update(d.info ? ActuatorJson(*d.info)
                     : ActuatorJson(d.status.value_or(msg::ActuatorStatus())));
  json.update(
      {{"machine", Known(d.machine)},
       {"machine_state", Known(d.machine_state)},
       {"machine_phase", Known(d.machine_phase)},
       {"no_machine", Known(d.why_no_machine)},
       {"since", since == 0 ? Json() : Json(UtcText(since))},
       {"emergency_stop", stop},
       {"heartbeat", heartbeat},
       {"process", d.process ? Of(*d.process) : Json()},
       {"configured", d.config ? Of(*d.config, d) : Json()},
       {"reachable", reach},
       {"capabilities", capabilities},
       {"offers", d.offers},
       {"history", history},
       {"log", {{"file", Known(d.log_file)}, {"missing", Known(d.why_no_log)}, {"lines", log}}},
       {"next", next}});
  return JsonLine(json);
}

}  // namespace musher::cli
