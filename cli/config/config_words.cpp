#include "musher/cli/config/config_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace musher::cli {
namespace {

using Strings = std::vector<std::string>;
using enum ChangeEffect;

std::string Ms(Duration duration) {
  return fmt::format("{} ms", ToMilliseconds(duration));
}
std::string Seconds(Duration duration) {
  return fmt::format("{:g} s", ToSeconds(duration));
}
std::string Mb(std::int64_t bytes) {
  return fmt::format("{} MiB", bytes >> 20);
}
std::string Percent(int percent) {
  return fmt::format("{} %", percent);
}
std::string Bool(bool value) {
  return value ? "true" : "false";
}
std::string Or(const std::string& value, const char* absent) {
  return value.empty() ? absent : value;
}
std::string Argv(const Strings& words) {
  return words.empty() ? "none" : fmt::format("{}", fmt::join(words, " "));
}
template <class Range>
Strings Texts(const Range& values) {
  Strings texts;
  for (const auto& value : values) texts.push_back(fmt::format("{}", value));
  return texts;
}

std::string DistroName(const std::optional<RosDistro>& distro) {
  constexpr const char* kNames[] = {"galactic", "humble", "iron", "jazzy", "kilted"};
  return distro ? kNames[static_cast<int>(*distro)] : "that of ROS_DISTRO";
}

std::string RestartName(RestartPolicy policy) {
  switch (policy) {
    case RestartPolicy::kNo:
      return "no";
    case RestartPolicy::kOnFailure:
      return "on-failure";
    case RestartPolicy::kAlways:
      break;
  }
  return "always";
}

class WordList {
 public:
  void Table(std::string name, ChangeEffect effect = kTakeover) {
    table_ = std::move(name);
    words_.push_back({table_, "", {}, false, effect});
  }
  void Key(std::string key, std::string value, ChangeEffect effect = kTakeover) {
    words_.push_back({table_, std::move(key), {std::move(value)}, false, effect});
  }
  void Set(std::string key, Strings members, ChangeEffect effect = kTakeover) {
    std::sort(members.begin(), members.end());
    words_.push_back({table_, std::move(key), std::move(members), true, effect});
  }
  void Set(std::string key, const std::vector<State>& states, ChangeEffect effect = kTakeover) {
    Set(std::move(key), Strings(states.begin(), states.end()), effect);
  }
  std::vector<ConfigWord> Take() { return std::move(words_); }

 private:
  std::string table_;
  std::vector<ConfigWord> words_;
};

void AddController(const MachineConfig& config, WordList& words) {
  words.Table("controller");
  words.Key("name", config.name, kNewStart);
  words.Key("namespace", "\"" + config.name_space + "\"", kNewStart);
  words.Set("states", config.states);
  words.Key("default_time", Ms(config.default_time));
  words.Key("default_state", config.default_state);
  words.Key("state_dir", config.state_dir, kNewStart);
  words.Key("clock", config.clock == ClockSource::kTopic ? "topic" : "steady", kNewStart);
  words.Key("shutdown_budget_ms", Ms(config.shutdown_budget));
  words.Key("log", Or(config.log, "controller.log"));
  words.Key("log_group", Or(config.log_group, "none"));
  words.Key("units", config.own_units ? "always" : "never");
  words.Key("failover_ms", config.failover ? Ms(*config.failover) : "none");
  words.Key("journal_size_mb", Mb(config.journal_size_bytes));
  words.Key("log_size_mb", Mb(config.log_size_bytes));
  words.Key("logs_size_mb", Mb(config.logs_size_bytes));
}

// What the controller does when the actuator exits, hangs or is lost.
void AddHealth(const ActuatorConfig& actuator, WordList& words) {
  const RestartConfig& restart = actuator.restart;
  words.Key("restart", RestartName(restart.policy));
  words.Key("restart_delay_ms", Ms(restart.delay));
  words.Key("restart_growth", fmt::format("{:g}", restart.growth));
  words.Key("restart_max_ms", Ms(restart.max_delay));
  words.Key("restart_limit", std::to_string(restart.limit));
  words.Key("restart_reset_ms", Ms(restart.reset_after));
  words.Key("restart_finalized", Bool(restart.finalized));
  words.Set("restart_prevent_exit_codes", Texts(restart.prevent_exit_codes));
  words.Key("checkpoint_ms", actuator.checkpoint ? Ms(*actuator.checkpoint) : "none", kRestart);
  for (const auto& [state, time] : actuator.checkpoint_in) {
    words.Key("checkpoint_ms (" + state + ")", Ms(time), kRestart);
  }
  words.Key("controller_lost_ms", actuator.controller_lost ? Ms(*actuator.controller_lost) : "none",
            kRestart);
  words.Key("on_controller_lost", Or(actuator.on_controller_lost, "none"), kRestart);
  words.Key("on_lost", Or(actuator.on_lost, "none"));
}

void AddLimits(const ProcessLimits& limits, WordList& words) {
  const auto text = [](const auto& limit) { return limit ? fmt::format("{}", *limit) : "none"; };
  const auto& memory = limits.memory_max_bytes;
  words.Key("memory_max_mb", memory ? Mb(*memory) : "none", kRestart);
  words.Key("cpus", text(limits.cpus), kRestart);
  words.Key("nice", text(limits.nice), kRestart);
  words.Key("realtime_priority", text(limits.realtime_priority), kRestart);
  words.Key("user", Or(limits.user, "the controller's"), kRestart);
  for (const auto& [name, sandbox] : kSandboxNames) {
    if (sandbox == limits.sandbox) words.Key("sandbox", std::string(name), kRestart);
  }
  if (limits.devices) {
    words.Set("devices", *limits.devices, kRestart);
  } else {
    words.Key("devices", limits.LimitsDevices() ? "none" : "all", kRestart);
  }
}

void AddActuator(const ActuatorConfig& actuator, WordList& words) {
  words.Table("actuator." + actuator.name);
  words.Set("states", actuator.states, kRestart);
  for (std::size_t i = 0; i < actuator.states.size(); ++i) {
    words.Key("times (" + actuator.states[i] + ")", Ms(actuator.times[i]));
  }
  words.Key("command", Argv(actuator.command), kRestart);
  if (!actuator.host.empty()) words.Key("host", actuator.host, kNewStart);
  words.Key("cwd", Or(actuator.cwd, actuator.host.empty() ? "the controller's" : "/"), kRestart);
  for (const auto& [name, value] : actuator.env) words.Key("env (" + name + ")", value, kRestart);
  AddLimits(actuator.limits, words);
  words.Key("log_size_mb", Mb(actuator.log_size_bytes));
  words.Key("stage", std::to_string(actuator.stage));
  words.Set("after", actuator.after);
  words.Set("binds_to", actuator.binds_to);
  words.Key("critical", Bool(actuator.critical));
  if (actuator.critical_codes) {
    words.Set("critical_codes", Texts(*actuator.critical_codes));
  } else {
    words.Key("critical_codes", "all");
  }
  words.Key("protocol", std::string(ProtocolName(actuator.protocol)), kNewStart);
  if (!actuator.heartbeat_name.empty()) words.Key("heartbeat_name", actuator.heartbeat_name);
  for (const auto& [state, node] : actuator.ros2_states) {
    words.Key("ros2_states (" + state + ")", std::string(Ros2StateName(node)));
  }
  AddHealth(actuator, words);
}

// Only own states: the built-in ones have their ranks in every config.
void AddStatesAndFlow(const MachineConfig& config, WordList& words) {
  for (const auto& [state, rank] : config.ranks) {
    if (IsBuiltInState(state)) continue;
    words.Table("state." + state);
    words.Key("rank", std::to_string(rank), kRestart);
  }
  if (config.flow == DefaultFlow(config.states)) return;
  words.Table("transition");
  Strings edges;
  edges.reserve(config.flow.size());
  for (const FlowEdge& edge : config.flow) edges.push_back(edge.from + " → " + edge.to);
  words.Set("from → to", std::move(edges));
}

// Adds a word for each key of a policy.
class PolicyWords {
 public:
  explicit PolicyWords(WordList& words) : words_(words) {}

  void Topic(const char* key, const std::string& topic) { words_.Key(key, topic); }
  void Percent(const char* key, int percent) { words_.Key(key, cli::Percent(percent)); }
  void Seconds(const char* key, Duration time, double /*least*/) {
    words_.Key(key, cli::Seconds(time));
  }
  void Bool(const char* key, bool value) { words_.Key(key, cli::Bool(value)); }
  void Set(const char* key, const std::vector<std::int32_t>& numbers) {
    words_.Set(key, Texts(numbers));
  }
  void Program(const char* key, const Strings& argv) { words_.Key(key, Argv(argv)); }

 private:
  WordList& words_;
};

void AddPolicy(const PolicyConfig& policy, WordList& words) {
  PolicyWords keys(words);
  words.Table("policy");
  words.Key("manager", Bool(policy.manager));
  if (policy.battery) {
    words.Table("policy.battery");
    BatteryPolicy::Keys(*policy.battery, keys);
  }
  if (policy.low_power) {
    words.Table("policy.low_power");
    LowPowerPolicy::Keys(*policy.low_power, keys);
  }
  // Every [policy] has these; a file with the usual values has no table for them.
  const PowerPolicy& power = policy.power;
  const PowerPolicy usual;
  const bool reboots = power.reboot_command != usual.reboot_command;
  const PowerPolicy off{power.delay, power.force_after, power.off_command, usual.reboot_command};
  if (off != usual) {
    words.Table("policy.power_off");
    PowerPolicy::OffKeys(power, keys);
  }
  if (reboots) {
    words.Table("policy.reboot");
    PowerPolicy::RebootKeys(power, keys);
  }
  std::string table;
  for (ManagerPolicy::Key& key : policy.manager_policy.Keys()) {
    if (std::exchange(table, key.table) != key.table) words.Table(key.table);
    key.is_set ? words.Set(key.name, std::move(key.values)) : words.Key(key.name, Argv(key.values));
  }
}

void AddCapability(const CapabilityConfig& capability, WordList& words) {
  words.Table("capability." + capability.name, kRestart);
  words.Set("actuators", capability.actuators, kRestart);
  words.Set("states", capability.states, kRestart);
  words.Key("min_battery", capability.min_battery ? Percent(*capability.min_battery) : "none",
            kRestart);
  words.Key("description", "\"" + capability.description + "\"");
}

void AddRos2(const Ros2Config& ros2, WordList& words) {
  words.Table("ros2");
  words.Key("managed_nodes", Bool(ros2.managed_nodes), kNewStart);
  words.Key("start", ros2.started_by_manager ? "manager" : "self", kNewStart);
  words.Key("configure", ros2.configure);
  words.Key("activate", ros2.activate);
  words.Key("deactivate", ros2.deactivate);
  words.Key("cleanup", ros2.cleanup);
  words.Key("shutdown", ros2.shutdown);
  words.Key("diagnostics", Bool(ros2.diagnostics));
  words.Key("rosout", Bool(ros2.rosout));
}

}  // namespace

std::vector<ConfigWord> WordsOf(const MachineConfig& config) {
  WordList words;
  AddController(config, words);
  for (const ActuatorConfig& actuator : config.actuators) AddActuator(actuator, words);
  for (const HostConfig& host : config.hosts) {
    words.Table("host." + host.name);
    words.Key("address", host.address);
    words.Key("user", Or(host.user, "ssh's"));
    words.Key("key", Or(host.key, "ssh's"));
    words.Key("known_hosts", Or(host.known_hosts, "ssh's"));
  }
  AddStatesAndFlow(config, words);
  words.Table("transport", kNewStart);
  words.Key("profile", config.transport == TransportProfile::kLan ? "lan" : "local", kNewStart);
  words.Set("interfaces", Strings(config.interfaces.begin(), config.interfaces.end()), kNewStart);
  words.Key("ros_distro", DistroName(config.ros_distro), kNewStart);
  if (!config.keys.empty()) {
    words.Table("security", kNewStart);
    words.Key("keys", config.keys, kNewStart);
  }
  if (config.permit || !config.rules_file.empty()) {
    words.Table("safety", config.permit ? kNewStart : kTakeover);
    const std::string permit_ms =
        config.permit ? std::to_string(ToMilliseconds(*config.permit)) : "none";
    words.Key("permit_ms", permit_ms, kNewStart);
    words.Key("rules", Or(config.rules_file, "none"));
  }
  if (const auto& view = config.view) {
    words.Table("view");
    words.Key("port", std::to_string(view->port));
    words.Key("bind", view->bind);
    words.Key("token_file", Or(view->token_file, "view_token"));
    words.Set("hosts", view->hosts);
    words.Key("stop_needs_login", view->stop_needs_login ? "true" : "false");
  }
  if (config.policy) AddPolicy(*config.policy, words);
  for (const CapabilityConfig& capability : config.capabilities) AddCapability(capability, words);
  AddRos2(config.ros2, words);
  return words.Take();
}

}  // namespace musher::cli
