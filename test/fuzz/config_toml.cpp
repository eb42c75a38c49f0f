// The state config as any text: the check does not crash, each diagnostic has a position in the
// text, and an accepted config is usable.

#include "musher/lifecycle/config/config_toml.hpp"

#include <algorithm>

#include "musher/cyberdog/voice_policy.hpp"  // reads [policy.voice]
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher {
namespace {

using fuzz::Require;

void RequireLocated(const Diagnostic& diagnostic, std::string_view text) {
  const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
  Require(diagnostic.line >= 0 && diagnostic.line <= lines, "a diagnostic is inside the file");
  Require((diagnostic.line == 0) == (diagnostic.column == 0), "a position has a line and a column");
  Require(!diagnostic.message.empty(), "a diagnostic has a message");
}

void RequireConsistent(const MachineConfig& config) {
  Require(!config.actuators.empty(), "a machine has actuators");
  for (const ActuatorIndex i : config.actuators.Indices()) {
    const ActuatorConfig& actuator = config.actuators[i];
    Require(config.IndexOf(actuator.name) == i, "names of actuators are unique");
    Require(actuator.states.size() == actuator.times.size(), "each state has its time");
    for (const State& state : actuator.states) {
      Require(config.HasState(state), "an actuator's states are the machine's");
      Require(config.TimeFor(i, state) > Duration::zero(), "times are positive");
    }
    for (const std::string& other : actuator.after) {
      Require(config.IndexOf(other).has_value(), "`after` names an actuator");
    }
    for (const std::string& other : actuator.binds_to) {
      Require(config.IndexOf(other).has_value(), "`binds_to` names an actuator");
    }
  }
}

// Plans every switch, and begins a start.
void RequireUsable(const MachineConfig& config) {
  Machine machine = MakeMachine(config);
  for (const State& state : config.states) {
    const Plan plan = MakePlan(config, machine, state);
    Require(plan.refusal || !plan.steps.empty() || config.actuators.empty(), "a plan has steps");
  }
  const Time now(std::chrono::hours(1));
  Step(config, machine, event::Begin{false, 0, PerActuator<bool>(config.actuators.size()), "here"},
       now);
  const auto deadline = NextDeadline(config, machine);
  Require(!deadline || *deadline > now, "no deadline is in the past");
}

}  // namespace
}  // namespace musher

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace musher;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const ConfigReading reading = ReadConfigText(text, "/robots/sled.toml");
  for (const Diagnostic& diagnostic : reading.diagnostics) RequireLocated(diagnostic, text);
  fuzz::Require(reading.config.has_value() != HasError(reading.diagnostics),
                "either a config or an error");
  const ConfigReading again = ReadConfigText(text, "/robots/sled.toml");
  fuzz::Require(again.config == reading.config && again.diagnostics == reading.diagnostics,
                "the same text gives the same result");
  if (!reading.config) return 0;
  RequireConsistent(*reading.config);
  RequireUsable(*reading.config);
  return 0;
}
