#pragma once
// What musher-exec runs in each state, read from a TOML file (README.md shows one):
//
//   module = 3000     # exit code n of a command (1 to 99) becomes CyberDog's code 3000 + n
//   stop_ms = 2000    # from SIGTERM to SIGKILL, in milliseconds
//   cwd = "."         # where the programs run, relative to this file
//
//   [state.SetUp]
//   start = ["server", "--port", "80"]   # runs until TearDown, and is watched
//   run = ["wait-for-port", "80"]        # a command; its exit code is the answer
//
//   [state.LowPower]
//   shell = "echo 1 > /sys/power/save"   # the same as run, but a line for /bin/sh
//
//   [emergency_stop]
//   run = ["./brake"]                    # at once at an emergency stop; exit code 0 confirms it
//
// A state that the file leaves out does nothing and succeeds.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::exec {

// What is run for one state: argv each; a program without '/' is looked up in PATH.
struct StateActions {
  std::vector<std::string> start;  // SetUp only; empty: no program that keeps running
  std::vector<std::string> run;    // empty: nothing to do

  friend bool operator==(const StateActions&, const StateActions&) = default;
};

// What is done at an emergency stop: the command first, then the program is ended.
struct EmergencyStopAction {
  std::vector<std::string> run;        // empty: no command
  Duration time = Milliseconds(2000);  // of the command; after that it gets SIGTERM
  bool end_program = false;            // by SIGTERM, and SIGKILL after the config's stop_time

  friend bool operator==(const EmergencyStopAction&, const EmergencyStopAction&) = default;
};

struct ExecConfig {
  std::string file;  // its name without the folder; empty: without a file
  std::int32_t module = static_cast<std::int32_t>(ModuleCode::kRobot);
  Duration stop_time = Milliseconds(2000);  // from SIGTERM to SIGKILL
  std::string cwd;                          // absolute; empty: that of this process
  std::map<std::string, std::string> env;   // added to that of this process
  std::map<State, StateActions> states;
  std::optional<EmergencyStopAction> emergency_stop;

  friend bool operator==(const ExecConfig&, const ExecConfig&) = default;
};

// Reads and checks the file at `path` for `actuator`, which must list every state of the file.
// Never throws; an unreadable file is a diagnostic.
Parsed<ExecConfig> ReadExecFile(const std::string& path, const ActuatorConfig& actuator);

// The same for a text; `path` is what diagnostics and relative paths refer to.
Parsed<ExecConfig> ReadExecText(std::string_view text, const std::string& path,
                                const ActuatorConfig& actuator);

// Why an emergency stop is not confirmed: there is no action for it, although a program runs, or
// commands of Active or Protected may have switched on what moves. Empty: it is confirmed.
std::string WhyNothingStops(const ExecConfig& config);

// The config without a file: `program` runs from SetUp to TearDown; other states run nothing.
ExecConfig ConfigForProgram(std::vector<std::string> program);

}  // namespace musher::exec
