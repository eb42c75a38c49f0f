// [controller], [transport], [security] and [safety].

#include <algorithm>

#include "musher/base/suggest.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::config_toml {
namespace {

constexpr std::int64_t kLargestJournalMb = 100'000;
constexpr std::int64_t kLargestControllerLogMb = 100'000;
// A controller gives up after half of it, and needs some 500 ms of that to see that a host is out
// of reach.
constexpr std::int64_t kShortestFailoverMs = 3000;

void ReadActuatorNames(TableReader& controller, Draft& draft) {
  constexpr std::string_view kKey = "actuators";
  draft.actuator_names = controller.Strings(kKey);
  draft.actuators_at = controller.At(kKey);
  if (!draft.actuator_names) return;
  if (draft.actuator_names->size() > kMostActuators) {
    controller.Fault(draft.actuators_at, kKey,
                     "expected at most " + std::to_string(kMostActuators) + " actuators, found " +
                         std::to_string(draft.actuator_names->size()));
  }
  for (const Word& name : *draft.actuator_names) {
    if (IsName(name.text)) continue;
    controller.Fault(name.at, kKey,
                     "expected " + std::string(kNameRule) + ", found " + Quote(name.text));
  }
}

void ReadState(const Word& state, TableReader& controller, Draft& draft) {
  const auto& known = draft.known_states;
  if (std::find(known.begin(), known.end(), state.text) != known.end()) {
    draft.config.states.emplace_back(state.text);
    draft.listed_states.insert(state.text);
    return;
  }
  std::string guess = draft.findings.Guess(state.text, known);
  if (guess.empty()) guess = "; expected a built-in state or one declared by [[state]]";
  controller.Fault(state.at, "states", "unknown state " + Quote(state.text) + guess);
  draft.listed_states.insert(state.text);
  draft.listed_states.insert(Nearest(state.text, known));
}

void ReadStates(TableReader& controller, Draft& draft) {
  constexpr std::string_view kKey = "states";
  const auto states = controller.Strings(kKey);
  if (!states) return;
  const Position at = controller.At(kKey);
  if (states->size() > kMostStates) {
    controller.Fault(at, kKey,
                     "expected at most " + std::to_string(kMostStates) + " states, found " +
                         std::to_string(states->size()));
    return;
  }
  for (const Word& state : *states) ReadState(state, controller, draft);
  draft.states_read = true;
  const auto listed = [&](std::string_view state) {
    return draft.listed_states.contains(std::string(state));
  };
  if (!listed(kSetUp)) {
    controller.Fault(at, kKey, "expected \"SetUp\" among them, which every start begins with");
    draft.listed_states.emplace(kSetUp);
  }
  for (const std::string_view state : {kSelfCheck, kActive}) {
    if (!listed(state)) {
      controller.Warn(at, kKey, Quote(state) + " is not listed: the machine can never be in it");
    }
  }
  // Every machine can be stopped: without the state, its processes are ended by signals only.
  if (listed(kTearDown)) return;
  controller.Warn(at, kKey,
                  Quote(kTearDown) + " is not listed; it is added: the machine ends in it");
  draft.config.states.emplace_back(kTearDown);
  draft.listed_states.emplace(kTearDown);
}

void ReadDefaultState(TableReader& controller, Draft& draft) {
  const auto state = controller.String("default_state");
  if (!state || state->text == kUninitialized) return;
  if (!Nearest(state->text, std::vector<std::string_view>{kUninitialized}).empty()) {
    controller.Fault(state->at, "default_state",
                     "unknown state " + Quote(state->text) + DidYouMean(Quote(kUninitialized)));
    return;
  }
  if (!CheckState(*state, "default_state", controller, draft)) return;
  const auto rank = draft.config.RankOf(state->text);
  if (rank && *rank > *BuiltInRank(kError)) {
    controller.Fault(state->at, "default_state",
                     Quote(state->text) +
                         " is a state of a running robot, and an actuator is in the default state "
                         "until its SetUp has ended; expected \"Uninitialized\"");
    return;
  }
  draft.config.default_state = State(state->text);
}

void ReadIdentity(TableReader& controller, Draft& draft) {
  MachineConfig& config = draft.config;
  config.name = NameOf(config.file);
  if (const auto name = controller.String("name")) {
    if (!IsName(name->text)) {
      controller.Fault(name->at, "name",
                       "expected " + std::string(kNameRule) + ", found " + Quote(name->text));
    }
    config.name = name->text;
  }
  if (const auto word = controller.String("namespace")) {
    config.name_space = word->text.substr(word->text.starts_with('/') ? 1 : 0);
    if (!IsNamespace(config.name_space)) {
      controller.Fault(word->at, "namespace",
                       "expected " + std::string(kNamespaceRule) + ", found " + Quote(word->text));
    }
  }
}

std::optional<std::string> ReadPath(std::string_view key, TableReader& controller,
                                    const Draft& draft) {
  const auto path = controller.String(key);
  if (!path) return std::nullopt;
  if (path->text.empty()) {
    controller.Fault(path->at, key, "expected a path, found an empty string");
    return std::nullopt;
  }
  return Absolute(draft.folder, path->text);
}

// Whether the host has it is asked where the machine is started.
void ReadLogGroup(TableReader& controller, Draft& draft) {
  const auto group = controller.String("log_group");
  if (!group) return;
  draft.config.log_group = group->text;
  if (group->text.empty() || group->text.find_first_of(":/ \t\n,") != std::string::npos) {
    controller.Fault(group->at, "log_group",
                     "expected the name of a group, found " + Quote(group->text));
  }
}

// Whether systemd runs here is asked where the machine is started.
void ReadUnits(TableReader& controller, Draft& draft) {
  constexpr std::string_view kKey = "units";
  const auto always = controller.Choice<bool>(kKey, {{"never", false}, {"always", true}});
  draft.config.own_units = always.value_or(false);
  if (!draft.config.own_units || SupportsHosts()) return;
  controller.Fault(controller.At(kKey), kKey,
                   "not supported by this build, which was made without libsystemd-dev");
}

}  // namespace

void ReadController(TableReader& root, Draft& draft) {
  const Table* table = root.SubTable("controller");
  if (table == nullptr) return;
  TableReader controller(*table, root.At("controller"), "controller", draft.findings);
  controller.Require("actuators", "an array of strings");
  controller.Require("states", "an array of strings");
  controller.Require("default_time", "an integer (milliseconds)");
  MachineConfig& config = draft.config;
  ReadActuatorNames(controller, draft);
  ReadStates(controller, draft);
  config.default_time = controller.Time("default_time").value_or(config.default_time);
  ReadDefaultState(controller, draft);
  ReadIdentity(controller, draft);
  const auto state_dir = ReadPath("state_dir", controller, draft);
  config.state_dir = state_dir ? *state_dir : DefaultStateDir(config.name, config.name_space);
  const auto budget = controller.Time("shutdown_budget_ms");
  config.shutdown_budget = budget.value_or(config.shutdown_budget);
  config.log = ReadPath("log", controller, draft).value_or("");
  ReadLogGroup(controller, draft);
  ReadUnits(controller, draft);
  config.failover = controller.Time("failover_ms", kShortestFailoverMs);
  draft.failover_at = controller.At("failover_ms");
  const auto clock = controller.Choice<ClockSource>(
      "clock", {{"steady", ClockSource::kSteady}, {"topic", ClockSource::kTopic}});
  config.clock = clock.value_or(config.clock);
  if (const auto mb = controller.Integer("journal_size_mb", 1, kLargestJournalMb)) {
    config.journal_size_bytes = *mb << 20;
  }
  if (const auto mb = controller.Integer("log_size_mb", 1, kLargestControllerLogMb)) {
    config.log_size_bytes = *mb << 20;
  }
  if (const auto mb = controller.Integer("logs_size_mb", 1, kLargestControllerLogMb)) {
    config.logs_size_bytes = *mb << 20;
  }
  controller.RefuseOthers();
}

// Whether the kernel permits the name for a network interface (IFNAMSIZ).
bool IsInterfaceName(const std::string& name) {
  constexpr std::size_t kLongest = 15;
  return name.size() <= kLongest &&
         name.find_first_not_of(
             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-") ==
             std::string::npos;
}

void ReadInterfaces(TableReader& transport, Draft& draft) {
  constexpr std::string_view kKey = "interfaces";
  constexpr std::size_t kMost = 3;  // of Cyclone, beside the loopback
  const auto names = transport.Strings(kKey);
  if (!names) return;
  for (const Word& name : *names) {
    if (name.text == "lo") {
      transport.Fault(name.at, kKey, "\"lo\" is used always; name interfaces to other hosts");
    } else if (!IsInterfaceName(name.text)) {
      transport.Fault(name.at, kKey,
                      "expected the name of a network interface, such as \"wlan0\", found \"" +
                          name.text + "\"");
    } else {
      draft.config.interfaces.push_back(name.text);
    }
  }
  if (names->size() > kMost) {
    transport.Fault((*names)[kMost].at, kKey, "expected at most 3 names");
  }
  if (draft.config.transport == TransportProfile::kLocal) {
    transport.Warn(transport.At(kKey), kKey, "has no effect without profile = \"lan\"");
  }
}

void ReadTransport(TableReader& root, Draft& draft) {
  const Table* table = root.SubTable("transport");
  if (table == nullptr) return;
  TableReader transport(*table, root.At("transport"), "transport", draft.findings);
  const auto profile = transport.Choice<TransportProfile>(
      "profile", {{"local", TransportProfile::kLocal}, {"lan", TransportProfile::kLan}});
  draft.config.transport = profile.value_or(draft.config.transport);
  draft.transport_at = transport.At("profile");
  ReadInterfaces(transport, draft);
  draft.config.ros_distro =
      transport.Choice<RosDistro>("ros_distro", {{"galactic", RosDistro::kGalactic},
                                                 {"humble", RosDistro::kHumble},
                                                 {"iron", RosDistro::kIron},
                                                 {"jazzy", RosDistro::kJazzy},
                                                 {"kilted", RosDistro::kKilted}});
  transport.RefuseOthers();
}

void CheckFailover(Draft& draft) {
  if (!draft.config.failover || draft.config.transport == TransportProfile::kLan) return;
  draft.findings.Error(draft.failover_at,
                       "controller.failover_ms: needs profile = \"lan\" in [transport]: with "
                       "\"local\" no standby of another host is reached");
}

void ReadSecurity(TableReader& root, Draft& draft) {
  const Table* table = root.SubTable("security");
  if (table == nullptr) return;
  TableReader security(*table, root.At("security"), "security", draft.findings);
  security.Require("keys", "a string (the folder of keys)");
  draft.config.keys = ReadPath("keys", security, draft).value_or("");
  security.RefuseOthers();
}

void ReadSafety(TableReader& root, Draft& draft) {
  constexpr std::int64_t kShortestPermitMs = 200;  // four permits of `musher permit`
  const Table* table = root.SubTable("safety");
  if (table == nullptr) return;
  TableReader safety(*table, root.At("safety"), "safety", draft.findings);
  draft.config.permit = safety.Time("permit_ms", kShortestPermitMs);
  draft.config.rules_file = ReadPath("rules", safety, draft).value_or("");
  safety.RefuseOthers();
}

// Two robots of one network, neither with a namespace: their topics have the same names.
void WarnOfSharedNetwork(Draft& draft) {
  const MachineConfig& config = draft.config;
  const bool open = config.name_space.empty() && config.keys.empty();
  if (config.transport != TransportProfile::kLan || !open) return;
  draft.findings.Warning(draft.transport_at,
                         "transport.profile: with \"lan\", and without a namespace or keys, the "
                         "topics of this machine are mixed with those of every other one in the "
                         "network; set `namespace` in [controller], or `keys` in [security]");
}

void ReadView(TableReader& root, Draft& draft) {
  const Table* table = root.SubTable("view");
  if (table == nullptr) return;
  TableReader reader(*table, root.At("view"), "view", draft.findings);
  ViewConfig& view = draft.config.view.emplace();
  view.port = static_cast<int>(reader.Integer("port", 1, 65535).value_or(view.port));
  if (const auto bind = reader.String("bind")) {
    const bool address =
        !bind->text.empty() &&
        bind->text.find_first_not_of("0123456789abcdefABCDEF.:") == std::string::npos;
    if (address) {
      view.bind = bind->text;
    } else {
      reader.Fault(bind->at, "bind",
                   "expected an address of this host, such as \"127.0.0.1\" or \"0.0.0.0\"");
    }
  }
  view.token_file = ReadPath("token_file", reader, draft).value_or("");
  for (const Word& host : reader.Strings("hosts").value_or(std::vector<Word>())) {
    view.hosts.push_back(host.text);
  }
  view.stop_needs_login = reader.Bool("stop_needs_login").value_or(view.stop_needs_login);
  reader.RefuseOthers();
}

}  // namespace musher::config_toml
