#include "musher/cli/render/json.hpp"

#include <nlohmann/json.hpp>

#include "musher/base/date_text.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/wall_time.hpp"

namespace musher {

// The library finds it by its argument.
template <typename Kind>
void to_json(cli::OrderedJson& json, StrongNumber<Kind> number) {
  json = number.value();
}

}  // namespace musher

namespace musher::cli {
namespace {

OrderedJson Of(const std::optional<StandbyReport>& standby) {
  if (!standby) return {};
  return {{"machine", Known(standby->machine.name)},
          {"machine_id", Known(standby->machine.id)},
          {"pid", Known(standby->pid)},
          {"why_not_leading", standby->why_not}};
}

// A number of its own type, or of the wire.
template <class N>
OrderedJson KnownId(const N& number) {
  if constexpr (requires { number.value(); }) {
    return Known(number.value());
  } else {
    return Known(number);
  }
}

OrderedJson Of(const msg::Capability& c) {
  return {{"capability", c.name}, {"description", c.description}, {"allowed", c.allowed},
          {"code", c.code},       {"reason", c.reason},           {"uses", c.actuators},
          {"states", c.states}};
}

OrderedJson Of(const std::map<std::string, RunningActuators::Actuator>& running) {
  OrderedJson actuators = OrderedJson::object();
  for (const auto& [name, actuator] : running) {
    OrderedJson json = ActuatorJson(actuator.status);
    json["status_received"] = actuator.has_status;
    json["emergency_stop"] = StopJson(actuator.status);
    actuators[name] = std::move(json);
  }
  return actuators;
}

std::string EventOf(const std::vector<std::string>& events, std::size_t i) {
  return i < events.size() ? events[i] : "";
}

// What an entry's data says: the arguments of its sentence (empty: it has none), and the rest as an
// object, or as text that is no JSON (a backtrace).
struct EntryData {
  OrderedJson arguments = OrderedJson::object();
  OrderedJson rest;
};
EntryData Read(const std::string& data) {
  OrderedJson json =
      data.starts_with('{') ? OrderedJson::parse(data, nullptr, false) : OrderedJson();
  if (!json.is_object()) return {OrderedJson::object(), Known(data)};
  EntryData read;
  const auto found = json.find("arguments");
  if (found != json.end() && found->is_object()) {
    read.arguments = *found;
    json.erase(found);
  }
  if (!json.empty()) read.rest = std::move(json);
  return read;
}

// An entry of the journal or of the wire.
template <class Entry>
OrderedJson OfEntry(const Entry& e, const std::string& event) {
  EntryData data = Read(e.data);
  return {{"time", UtcText(e.wall_ns)},
          {"epoch", e.epoch},
          {"switch", KnownId(e.switch_number)},
          {"kind", e.kind},
          {"event", Known(event)},
          {"actuator", Known(e.actuator)},
          {"code", e.code},
          {"message", e.message},
          {"id", e.id},
          {"cause", KnownId(e.cause)},
          {"new_state", Known(e.state)},
          {"data", std::move(data.rest)},
          {"arguments", std::move(data.arguments)}};
}

const char* MarkName(recording::ReplayLine::Mark mark) {
  switch (mark) {
    case recording::ReplayLine::Mark::kRecorded:
      return "-";
    case recording::ReplayLine::Mark::kNew:
      return "+";
    case recording::ReplayLine::Mark::kSame:
      break;
  }
  return "=";
}

OrderedJson Of(const msg::PolicyInfo& p) {
  return {{"battery", p.battery < 0 ? OrderedJson() : OrderedJson(p.battery)},
          {"charging", p.charging},
          {"battery_silent", p.battery_silent},
          {"ceiling", Known(p.ceiling)},
          {"ceiling_reason", p.ceiling_reason},
          {"kept", Known(p.kept)},
          {"keep_s", p.keep_s},
          {"low_power_switch", p.low_power_switch},
          {"power", Known(p.power)}};
}

OrderedJson Of(const std::vector<HostClock>& hosts) {
  OrderedJson json = OrderedJson::object();
  for (const HostClock& host : hosts) {
    json[host.name] = {
        {"login", host.login},
        {"runs", host.actuators},
        {"clock_ahead_s", host.ahead ? OrderedJson(ToSeconds(*host.ahead)) : OrderedJson()},
        {"trouble", Known(host.trouble)}};
  }
  return json;
}

}  // namespace

OrderedJson ActuatorJson(const msg::ActuatorInfo& a) {
  return {{"state", Known(a.state)},
          {"pid", Known(a.pid)},
          {"target", Known(a.target)},
          {"presence", Known(a.presence)},
          {"stage", a.stage},
          {"critical", a.critical},
          {"held", a.held},
          {"degraded", a.degraded},
          {"code", a.code},
          {"message", a.message},
          {"host", Known(a.host)},
          {"health", Known(a.health)},
          {"restarts", a.restarts},
          {"restarting", a.restarting}};
}

OrderedJson ActuatorJson(const msg::ActuatorStatus& s) {
  OrderedJson json = ActuatorJson(msg::ActuatorInfo());
  for (auto& [key, value] : json.items()) value = OrderedJson();
  json.update({{"state", Known(s.state)},
               {"pid", Known(s.pid)},
               {"target", Known(s.target)},
               {"code", s.outcome_code},
               {"message", s.outcome_message},
               {"host", Known(s.host)}});
  return json;
}

OrderedJson StopJson(const msg::ActuatorStatus& status) {
  return {{"engaged", status.emergency_stop != 0},
          {"by", Known(status.emergency_stop_by)},
          {"reason", status.emergency_stop_reason}};
}

std::string StatusJson(const msg::MachineStatus& status,
                       const std::map<std::string, RunningActuators::Actuator>& unlisted,
                       const StatusSince& since,
                       const std::optional<std::vector<HostClock>>& hosts) {
  OrderedJson actuators = OrderedJson::object();
  for (const msg::ActuatorInfo& a : status.actuators) {
    const auto unit = since.units.find(a.name);
    actuators[a.name] = ActuatorJson(a);
    actuators[a.name]["unit"] =
        unit == since.units.end() ? OrderedJson() : OrderedJson(unit->second);
  }
  return JsonLine({{"machine", status.machine},
                   {"pid", Known(status.pid)},
                   {"state", Known(status.state)},
                   {"degraded", status.degraded},
                   {"actuators", actuators},
                   {"unlisted", Of(unlisted)},
                   {"phase", status.phase},
                   {"target", Known(status.target)},
                   {"epoch", status.epoch},
                   {"switch", KnownId(status.switch_number)},
                   {"namespace", status.name_space},
                   {"config", status.config_file},
                   {"config_hash", Known(status.config_hash)},
                   {"host", Known(status.host)},
                   {"emergency_stop",
                    {{"engaged", status.emergency_stop},
                     {"by", Known(status.emergency_stop_by)},
                     {"reason", status.emergency_stop_reason}}},
                   {"held_by_stop", status.held_by_stop},
                   {"not_on_disk", status.not_on_disk},
                   {"policy", status.policy.active ? Of(status.policy) : OrderedJson()},
                   {"machine_id", Known(status.machine_id)},
                   {"other_machines", status.other_machines},
                   {"other_vendors", status.other_vendors},
                   {"requested_by", Known(status.requested_by)},
                   {"since", since.state_since_ns ? OrderedJson(UtcText(*since.state_since_ns))
                                                  : OrderedJson()},
                   {"uptime_s", since.up_s ? OrderedJson(*since.up_s) : OrderedJson()},
                   {"violated_rules", status.violated_rules},
                   {"not_stopped", status.not_stopped},
                   {"hosts", hosts ? Of(*hosts) : OrderedJson()},
                   {"standby", Of(since.standby)}});
}

std::string SwitchJson(const msg::SetState::Response& result) {
  OrderedJson actuators = OrderedJson::object();
  for (const msg::ActuatorOutcome& a : result.actuators) {
    actuators[a.name] = {{"outcome", a.outcome},
                         {"code", a.code},
                         {"message", a.message},
                         {"duration_ms", a.duration_ms},
                         {"state", Known(a.state)}};
  }
  return JsonLine({{"switch", KnownId(result.switch_number)},
                   {"target", result.target},
                   {"actuator", Known(result.actuator)},
                   {"outcome", result.outcome},
                   {"code", result.code},
                   {"reason", result.reason},
                   {"state", Known(result.state)},
                   {"degraded", result.degraded},
                   {"actuators", actuators}});
}

std::string EstopJson(const EstopReport& report) {
  OrderedJson actuators = OrderedJson::object();
  for (const EstopReport::Actuator& a : report.actuators) {
    const double after_ms = std::chrono::duration<double, std::milli>(a.after).count();
    actuators[a.name] = {{"stopped", a.stopped},
                         {"before", a.before},
                         {"after_ms", a.stopped ? OrderedJson(after_ms) : OrderedJson()},
                         {"trouble", Known(a.trouble)}};
  }
  OrderedJson machines = OrderedJson::array();
  for (const MachineIdentity& one : report.machines) {
    if (one.name.empty() && one.id.empty()) continue;
    machines.push_back({{"machine", Known(one.name)}, {"machine_id", Known(one.id)}});
  }
  OrderedJson earlier;  // null
  if (report.earlier) earlier = {{"by", report.earlier->by}, {"reason", report.earlier->reason}};
  return JsonLine({{"engaged", true},
                   {"by", report.by},
                   {"reason", report.reason},
                   {"complete", report.complete()},
                   {"controller", report.controller},
                   {"earlier", earlier},
                   {"actuators", actuators},
                   {"machines", machines}});
}

std::string ReleaseJson(const msg::MachineStatus& machine,
                        const std::vector<std::string>& released) {
  return JsonLine({{"engaged", machine.emergency_stop},
                   {"machine", machine.machine},
                   {"state", Known(machine.state)},
                   {"phase", machine.phase},
                   {"released", released}});
}

std::string PolicyJson(const msg::RequestPolicy::Request& request,
                       const msg::RequestPolicy::Response& response) {
  return JsonLine({{"request", request.request}, {"state", Known(response.state)}});
}

std::string RestartJson(const msg::ActuatorInfo& actuator) {
  OrderedJson json = {{"actuator", actuator.name}};
  json.update(ActuatorJson(actuator));
  return JsonLine(json);
}

std::string CapabilitiesJson(const msg::Capabilities& all) {
  OrderedJson list = OrderedJson::array();
  for (const msg::Capability& c : all.capabilities) list.push_back(Of(c));
  return JsonLine({{"capabilities", list}});
}

std::string CapabilityJson(const msg::Capability& one) {
  return JsonLine(Of(one));
}

std::string PlanJson(const msg::GetPlan::Response& plan) {
  OrderedJson steps = OrderedJson::array();
  for (const msg::PlanStep& s : plan.steps) {
    steps.push_back({{"actuator", s.name},
                     {"wave", s.wave},
                     {"from", Known(s.from)},
                     {"to", Known(s.to)},
                     {"deadline_ms", s.deadline_ms},
                     {"note", s.note}});
  }
  return JsonLine({{"target", plan.target},
                   {"actuator", Known(plan.actuator)},
                   {"allowed", plan.allowed},
                   {"code", plan.code},
                   {"reason", plan.reason},
                   {"direction", plan.direction},
                   {"state", Known(plan.state)},
                   {"steps", steps}});
}

std::string HistoryJson(const msg::GetHistory::Response& history) {
  OrderedJson list = OrderedJson::array();
  for (std::size_t i = 0; i < history.entries.size(); ++i) {
    list.push_back(OfEntry(history.entries[i], EventOf(history.events, i)));
  }
  return JsonLine({{"entries", list}, {"damage", Known(history.error)}});
}

std::string WhyJson(const Why& why) {
  const auto entries_of = [](const CauseChain& chain) {
    OrderedJson entries = OrderedJson::array();
    for (std::size_t i = 0; i < chain.entries.size(); ++i) {
      entries.push_back(OfEntry(chain.entries[i], EventOf(chain.events, i)));
    }
    return entries;
  };
  return JsonLine({{"state", Known(why.state)},
                   {"chain", entries_of(why.change)},
                   {"complete", why.complete()},
                   {"failure", entries_of(why.failure)},
                   {"refused", entries_of(why.refused)},
                   {"damage", Known(why.damage)}});
}

std::string ReplayJson(const recording::ReplayReport& report, const std::string& damage) {
  OrderedJson lines = OrderedJson::array();
  for (const recording::ReplayLine& line : report.lines) {
    OrderedJson json = {{"mark", MarkName(line.mark)}};
    json.update(OfEntry(line.entry, line.entry.event));
    json["input"] = line.input.empty() ? OrderedJson() : OrderedJson::parse(line.input);
    lines.push_back(json);
  }
  return JsonLine({{"equal", report.equal()},
                   {"inputs", report.inputs},
                   {"decisions", report.decisions},
                   {"differences", report.differences},
                   {"not_replayed", report.not_replayed},
                   {"recorded_state", Known(report.recorded_state)},
                   {"replayed_state", Known(report.replayed_state)},
                   {"lines", lines},
                   {"notes", report.notes},
                   {"damage", Known(damage)}});
}

std::string KeysJson(const std::string& folder,
                     const std::vector<transport::keys::Identity>& identities) {
  OrderedJson all = OrderedJson::object();
  for (const transport::keys::Identity& identity : identities) {
    all[identity.name] = {
        {"role", identity.role ? OrderedJson(RoleName(*identity.role)) : OrderedJson()},
        {"valid_until", FormatUtc(identity.not_after)},
        {"revoked", identity.revoked},
        {"has_key", identity.has_key}};
  }
  return JsonLine({{"folder", folder}, {"identities", all}});
}

std::string BehaviorJson(const std::string& name, const msg::GetBehavior::Response& report) {
  OrderedJson changes = OrderedJson::array();
  for (const msg::BehaviorChange& change : report.history) {
    changes.push_back({{"time_s", change.time_s},
                       {"tick", change.tick},
                       {"from", Known(change.from)},
                       {"to", Known(change.to)},
                       {"cause", Known(change.cause)},
                       {"command", Known(change.command)}});
  }
  return JsonLine({{"actuator", name},
                   {"running", report.running},
                   {"ticking", report.ticking},
                   {"held_by_stop", report.held_by_stop},
                   {"state", Known(report.current_state)},
                   {"mode", Known(report.operating_mode)},
                   {"ticks", report.iter_count},
                   {"safety_triggered", report.safety_triggered},
                   {"unsafe", Known(report.unsafe)},
                   {"time_s", report.time_s},
                   {"time_in_state_s", report.time_in_state_s},
                   {"last_fault", Known(report.last_fault)},
                   {"history", changes}});
}

std::string BehaviorSentJson(const std::string& name, const std::string& command) {
  return JsonLine({{"actuator", name}, {"sent", command}});
}

std::string GraphJson(const std::string& format, const std::string& drawing) {
  return JsonLine({{"format", format}, {"graph", drawing}});
}

std::string GraphFileJson(const std::string& format, const std::string& file) {
  return JsonLine({{"format", format}, {"output", file}});
}

std::string ProgressJson(const Progress& progress) {
  return JsonLine({{"time", UtcText(progress.wall_ns)},
                   {"kind", progress.kind},
                   {"actuator", Known(progress.actuator)},
                   {"switch", KnownId(progress.switch_number)},
                   {"code", progress.code},
                   {"message", progress.message}});
}

std::string RunningJson(const Failure& failure,
                        const std::map<std::string, RunningActuators::Actuator>& running,
                        const std::optional<StandbyReport>& standby) {
  OrderedJson json = OrderedJson::parse(FailureJson(failure));
  json["actuators"] = Of(running);
  json["standby"] = Of(standby);
  return JsonLine(json);
}

std::string EndingJson(const std::vector<DirectTearDown::Outcome>& outcomes) {
  OrderedJson actuators = OrderedJson::object();
  for (const DirectTearDown::Outcome& o : outcomes) {
    actuators[o.name] = {{"pid", Known(o.pid)},
                         {"ended", o.ended},
                         {"torn_down", o.torn_down},
                         {"signal", Known(o.signal)},
                         {"message", o.trouble}};
  }
  return JsonLine({{"actuators", actuators}});
}

}  // namespace musher::cli
