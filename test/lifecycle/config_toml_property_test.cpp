// Properties of the reader: it never crashes and its result is consistent for every text; and every
// machine that is written to a text is read back unchanged.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <sstream>

#include "musher/lifecycle/config/config_toml.hpp"

namespace musher::config_toml_property_test {

constexpr const char* kPath = "/robots/sled.toml";

template <typename T>
T Any(std::vector<T> values) {
  return *rc::gen::elementOf(std::move(values));
}

Duration AnyTime(int least_ms = 1) {
  return Milliseconds(*rc::gen::inRange(least_ms, 3'600'001));
}

bool AnyBool() {
  return *rc::gen::arbitrary<bool>();
}

// Some of `all`, in its order.
template <typename T>
std::vector<T> AnySubset(const std::vector<T>& all) {
  std::vector<T> some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some),
               [](const T&) { return AnyBool(); });
  return some;
}

std::string AnyText() {
  return *rc::gen::container<std::string>(rc::gen::inRange<char>(0x20, 0x7F));
}

RestartConfig AnyRestart() {
  RestartConfig restart;
  restart.policy =
      Any<RestartPolicy>({RestartPolicy::kNo, RestartPolicy::kOnFailure, RestartPolicy::kAlways});
  restart.delay = Milliseconds(*rc::gen::inRange(0, 1000));
  restart.max_delay = Milliseconds(*rc::gen::inRange(1000, 100'000));
  restart.growth = *rc::gen::inRange(4, 40) * 0.25;
  restart.limit = *rc::gen::inRange(0, 10'001);
  restart.reset_after = AnyTime();
  restart.prevent_exit_codes = AnySubset<int>({1, 2, 3, 78, 255});
  return restart;
}

ActuatorConfig AnyActuator(std::size_t number, const MachineConfig& machine) {
  ActuatorConfig actuator;
  actuator.name = "act_" + std::to_string(number);
  actuator.states = AnySubset(machine.states);
  if (!actuator.Lists(kSetUp)) actuator.states.emplace_back(kSetUp);
  if (!actuator.Lists(kTearDown)) actuator.states.emplace_back(kTearDown);
  for (std::size_t i = 0; i < actuator.states.size(); ++i) actuator.times.push_back(AnyTime());
  if (AnyBool()) actuator.command = {"/bin/" + actuator.name, AnyText(), AnyText()};
  if (AnyBool()) actuator.cwd = "/run/" + actuator.name;
  if (AnyBool()) actuator.env = {{"A", AnyText()}, {"b c", AnyText()}};
  actuator.protocol =
      Any<Protocol>({Protocol::kMusher, Protocol::kCyberdog, Protocol::kRos2Lifecycle});
  if (actuator.protocol == Protocol::kCyberdog) {
    actuator.heartbeat_name = Any<std::string>({actuator.name, "device"});
  }
  if (actuator.protocol == Protocol::kRos2Lifecycle && AnyBool()) {
    actuator.ros2_states = {
        {"TearDown", Any<Ros2State>({Ros2State::kUnconfigured, Ros2State::kInactive,
                                     Ros2State::kActive, Ros2State::kFinalized})}};
  }
  actuator.log_size_bytes =
      AnyBool() ? machine.log_size_bytes : *rc::gen::inRange<std::int64_t>(1, 1000) << 20;
  actuator.critical = AnyBool();
  actuator.restart = AnyRestart();
  if (AnyBool()) actuator.checkpoint = AnyTime(20);
  // The default of a node that the controller does not start.
  const bool by_hand = actuator.protocol == Protocol::kRos2Lifecycle && actuator.command.empty();
  if (by_hand && !actuator.checkpoint) actuator.checkpoint = Milliseconds(5000);
  if (AnyBool()) actuator.checkpoint_in = {{"SetUp", AnyTime(20)}, {"TearDown", AnyTime(20)}};
  if (AnyBool()) actuator.controller_lost = AnyTime(1000);
  actuator.on_controller_lost = kTearDown;
  actuator.on_lost = Any<State>({"Protected", "Error", "Parked"});
  // Only to earlier ones of no later stage, so that there is no cycle.
  actuator.stage = *rc::gen::inRange(1, 10);
  for (const ActuatorConfig& other : machine.actuators) {
    if (other.stage <= actuator.stage && AnyBool()) actuator.after.push_back(other.name);
    if (AnyBool()) actuator.binds_to.push_back(other.name);
  }
  return actuator;
}

CapabilityConfig AnyCapability(int number, const MachineConfig& machine) {
  CapabilityConfig capability;
  capability.name = "can_" + std::to_string(number);
  capability.description = AnyText();
  capability.actuators = {machine.actuators[0].name};
  for (const State& state : machine.actuators[0].states) {
    if (state != kSetUp && AnyBool()) capability.states.push_back(state);
  }
  if (capability.states.empty()) capability.states = {State(kTearDown)};
  if (AnyBool()) capability.min_battery = *rc::gen::inRange(1, 101);
  return capability;
}

MachineConfig AnyMachine() {
  MachineConfig machine;
  machine.name = "sled_" + std::to_string(*rc::gen::inRange(0, 100));
  machine.file = kPath;
  machine.name_space = Any<std::string>({"", "dog1", "fleet/dog1"});
  machine.state_dir = "/var/state/x";
  machine.states = {"SetUp", "TearDown", "SelfCheck", "Active", "Protected", "Error", "Parked"};
  machine.default_time = AnyTime();
  machine.default_state = Any<State>({"Uninitialized", "Error"});
  machine.shutdown_budget = AnyTime();
  machine.log = Any<std::string>({"", "/var/log/sled.log"});
  machine.log_group = Any<std::string>({"", "robots"});
  machine.journal_size_bytes = *rc::gen::inRange<std::int64_t>(1, 1000) << 20;
  machine.log_size_bytes = *rc::gen::inRange<std::int64_t>(1, 1000) << 20;
  machine.logs_size_bytes = *rc::gen::inRange<std::int64_t>(1, 1000) << 20;
  for (const std::string_view state : BuiltInStates()) {
    if (const auto rank = BuiltInRank(state)) machine.ranks.emplace(state, *rank);
  }
  machine.ranks.emplace("Parked", *rc::gen::inRange(0, 101));
  machine.flow = DefaultFlow(machine.states);
  if (AnyBool()) machine.flow = {{"Active", "Parked"}, {"Error", "SelfCheck"}, {"Parked", "Error"}};
  machine.transport = Any<TransportProfile>({TransportProfile::kLocal, TransportProfile::kLan});
  const int count = *rc::gen::inRange(1, 6);
  for (int i = 0; i < count; ++i) machine.actuators.push_back(AnyActuator(i, machine));
  const int capabilities = *rc::gen::inRange(0, 4);
  for (int i = 0; i < capabilities; ++i) machine.capabilities.push_back(AnyCapability(i, machine));
  return machine;
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
  return quoted + "\"";
}

template <typename Word>
std::string List(const std::vector<Word>& words) {
  std::string text = "[";
  for (const Word& word : words) text += Quoted(word) + ", ";
  return text + "]";
}

void WriteActuator(const ActuatorConfig& actuator, std::int64_t usual_log, std::ostream& out) {
  constexpr const char* kProtocols[] = {"musher", "cyberdog", "ros2_lifecycle"};
  constexpr const char* kPolicies[] = {"no", "on-failure", "always"};
  out << "\n[actuator." << actuator.name << "]\nstates = " << List(actuator.states)
      << "\ntimes = [";
  for (const Duration time : actuator.times) out << ToMilliseconds(time) << ",";
  out << "]\nprotocol = \"" << kProtocols[static_cast<int>(actuator.protocol)]
      << "\"\nstage = " << actuator.stage << "\nafter = " << List(actuator.after)
      << "\nbinds_to = " << List(actuator.binds_to)
      << "\ncritical = " << (actuator.critical ? "true" : "false")
      << "\non_lost = " << Quoted(actuator.on_lost)
      << "\non_controller_lost = " << Quoted(actuator.on_controller_lost);
  if (!actuator.heartbeat_name.empty()) {
    out << "\nheartbeat_name = " << Quoted(actuator.heartbeat_name);
  }
  for (const auto& [state, goal] : actuator.ros2_states) {
    out << "\nros2_states." << state << " = \"" << Ros2StateName(goal) << "\"";
  }
  if (!actuator.command.empty()) out << "\ncommand = " << List(actuator.command);
  if (actuator.log_size_bytes != usual_log) {
    out << "\nlog_size_mb = " << (actuator.log_size_bytes >> 20);
  }
  if (!actuator.cwd.empty()) out << "\ncwd = " << Quoted(actuator.cwd);
  if (actuator.checkpoint) out << "\ncheckpoint_ms = " << ToMilliseconds(*actuator.checkpoint);
  for (const auto& [state, allowance] : actuator.checkpoint_in) {
    out << "\ncheckpoint_ms_in." << state << " = " << ToMilliseconds(allowance);
  }
  if (actuator.controller_lost) {
    out << "\ncontroller_lost_ms = " << ToMilliseconds(*actuator.controller_lost);
  }
  const RestartConfig& restart = actuator.restart;
  out << "\nrestart = \"" << kPolicies[static_cast<int>(restart.policy)]
      << "\"\nrestart_delay_ms = " << ToMilliseconds(restart.delay)
      << "\nrestart_max_ms = " << ToMilliseconds(restart.max_delay)
      << "\nrestart_growth = " << restart.growth << "\nrestart_limit = " << restart.limit
      << "\nrestart_reset_ms = " << ToMilliseconds(restart.reset_after)
      << "\nrestart_prevent_exit_codes = [";
  for (const int code : restart.prevent_exit_codes) out << code << ", ";
  out << "]\n";
  if (actuator.env.empty()) return;
  out << "[actuator." << actuator.name << ".env]\n";
  for (const auto& [name, value] : actuator.env) {
    out << Quoted(name) << " = " << Quoted(value) << "\n";
  }
}

void WriteCapability(const CapabilityConfig& capability, std::ostream& out) {
  out << "\n[capability." << capability.name
      << "]\ndescription = " << Quoted(capability.description)
      << "\nactuators = " << List(capability.actuators) << "\nstates = " << List(capability.states);
  if (capability.min_battery) out << "\nmin_battery = " << *capability.min_battery;
  out << "\n";
}

std::string Write(const MachineConfig& machine) {
  std::ostringstream out;
  std::vector<std::string> names;
  for (const ActuatorConfig& actuator : machine.actuators) names.push_back(actuator.name);
  out << "[controller]\nactuators = " << List(names) << "\nstates = " << List(machine.states)
      << "\ndefault_time = " << ToMilliseconds(machine.default_time)
      << "\ndefault_state = " << Quoted(machine.default_state)
      << "\nname = " << Quoted(machine.name) << "\nnamespace = " << Quoted(machine.name_space)
      << "\nstate_dir = " << Quoted(machine.state_dir)
      << "\nshutdown_budget_ms = " << ToMilliseconds(machine.shutdown_budget)
      << "\njournal_size_mb = " << (machine.journal_size_bytes >> 20)
      << "\nlog_size_mb = " << (machine.log_size_bytes >> 20)
      << "\nlogs_size_mb = " << (machine.logs_size_bytes >> 20);
  if (!machine.log.empty()) out << "\nlog = " << Quoted(machine.log);
  if (!machine.log_group.empty()) out << "\nlog_group = " << Quoted(machine.log_group);
  out << "\n[[state]]\nname = \"Parked\"\nrank = " << machine.ranks.at("Parked")
      << "\n[transport]\nprofile = "
      << (machine.transport == TransportProfile::kLan ? "\"lan\"" : "\"local\"");
  if (machine.flow != DefaultFlow(machine.states)) {
    for (const FlowEdge& edge : machine.flow) {
      out << "\n[[transition]]\nfrom = " << Quoted(edge.from) << "\nto = " << Quoted(edge.to);
    }
  }
  for (const ActuatorConfig& actuator : machine.actuators) {
    WriteActuator(actuator, machine.log_size_bytes, out);
  }
  for (const CapabilityConfig& capability : machine.capabilities) WriteCapability(capability, out);
  return out.str();
}

// Reads `text` and checks what holds for every reading.
void CheckReading(const std::string& text) {
  const ConfigReading reading = ReadConfigText(text, kPath);
  RC_ASSERT(reading.config.has_value() != HasError(reading.diagnostics));
  const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
  int last_line = 0;
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    RC_ASSERT(!diagnostic.message.empty());
    RC_ASSERT(diagnostic.message.find('\n') == std::string::npos);
    RC_ASSERT(diagnostic.line <= lines);
    if (diagnostic.line == 0) continue;  // about the file
    RC_ASSERT(diagnostic.column >= 1);
    RC_ASSERT(diagnostic.line >= last_line);
    last_line = diagnostic.line;
  }
}

RC_GTEST_PROP(ConfigTomlProperty, ReadsBackEveryMachineThatCanBeWritten, ()) {
  const MachineConfig machine = AnyMachine();
  const std::string text = Write(machine);
  ConfigReading reading = ReadConfigText(text, kPath);
  for (const Diagnostic& diagnostic : reading.diagnostics) RC_LOG() << FormatDiagnostic(diagnostic);
  RC_ASSERT(reading.config.has_value());
  reading.config->hash.clear();
  RC_ASSERT(*reading.config == machine);
}

RC_GTEST_PROP(ConfigTomlProperty, SurvivesArbitraryBytes, (const std::string& bytes)) {
  CheckReading(bytes);
}

RC_GTEST_PROP(ConfigTomlProperty, SurvivesPiecesOfToml, ()) {
  static const std::vector<std::string> pieces = {"[controller]",
                                                  "[actuator.a]",
                                                  "[[state]]",
                                                  "[[transition]]",
                                                  "actuators",
                                                  "states",
                                                  "times",
                                                  "=",
                                                  "=",
                                                  "=",
                                                  "[",
                                                  "]",
                                                  "{",
                                                  "}",
                                                  ",",
                                                  ".",
                                                  "\n",
                                                  "\n",
                                                  "\n",
                                                  "\"\"\"",
                                                  "'''",
                                                  "\"",
                                                  "\\",
                                                  "#",
                                                  "\"a\"",
                                                  "\"SetUp\"",
                                                  "1",
                                                  "-1",
                                                  "1.5",
                                                  "nan",
                                                  "true",
                                                  "1979-05-27",
                                                  "name",
                                                  "rank",
                                                  "\xC3\xA9"};
  std::string text;
  for (const auto& piece :
       *rc::gen::container<std::vector<std::string>>(rc::gen::elementOf(pieces))) {
    text += piece;
  }
  CheckReading(text);
}

RC_GTEST_PROP(ConfigTomlProperty, SurvivesDamageToAGoodConfig, ()) {
  std::string text = Write(AnyMachine());
  const int wounds = *rc::gen::inRange(1, 6);
  for (int i = 0; i < wounds; ++i) {
    const std::size_t at = *rc::gen::inRange<std::size_t>(0, text.size());
    switch (*rc::gen::inRange(0, 3)) {
      case 0:
        text[at] = *rc::gen::arbitrary<char>();
        break;
      case 1:
        text.erase(at, *rc::gen::inRange<std::size_t>(1, 40));
        break;
      default:
        text.insert(at, text.substr(*rc::gen::inRange<std::size_t>(0, text.size()), 30));
    }
    if (text.empty()) break;
  }
  CheckReading(text);
}

}  // namespace musher::config_toml_property_test
