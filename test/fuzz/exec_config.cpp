// The config of musher-exec as any text, and the last line of a program's output.

#include "musher/modules/exec/exec_config.hpp"

#include <algorithm>

#include "musher/modules/exec/command.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::exec {
namespace {

using fuzz::Require;

ActuatorConfig Actuator() {
  ActuatorConfig actuator;
  actuator.name = "voice";
  actuator.states = {"SetUp", "TearDown", "SelfCheck", "Active", "LowPower"};
  actuator.times.assign(actuator.states.size(), Milliseconds(100));
  return actuator;
}

void CheckConfig(std::string_view text) {
  const ActuatorConfig actuator = Actuator();
  const Parsed<ExecConfig> reading = ReadExecText(text, "/robots/voice.toml", actuator);
  const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    Require(diagnostic.line >= 0 && diagnostic.line <= lines, "a diagnostic is inside the file");
  }
  Require(reading.config.has_value() != HasError(reading.diagnostics),
          "either a config or an error");
  Require(ReadExecText(text, "/robots/voice.toml", actuator).config == reading.config,
          "the same text gives the same result");
  if (!reading.config) return;
  Require(reading.config->stop_time >= Duration::zero(), "times are not negative");
  if (const auto& stop = reading.config->emergency_stop) {
    Require(!stop->run.empty() || stop->end_program, "an emergency stop does something");
  }
  for (const auto& [state, actions] : reading.config->states) {
    Require(actuator.Lists(state), "only states that the actuator lists");
    Require(actions.start.empty() || state == kSetUp, "a program starts in SetUp only");
  }
}

void CheckLastLine(std::string_view text) {
  LastLine whole;
  whole.Add(text);
  LastLine parts;
  for (const char c : text) parts.Add({&c, 1});
  const std::string line = whole.Get();
  Require(line == parts.Get(), "the result does not depend on the pieces of the output");
  Require(line.size() <= 200, "a reason is short");
  Require(std::none_of(line.begin(), line.end(), [](unsigned char c) { return c < ' '; }),
          "a reason has no control characters");
}

}  // namespace
}  // namespace musher::exec

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  musher::exec::CheckConfig(text);
  musher::exec::CheckLastLine(text);
  return 0;
}
