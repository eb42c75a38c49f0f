// musher-exec: an actuator that wraps any program without a line of C++. See README.md in this
// folder.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/suggest.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/base/version.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/modules/exec/exec_process.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/network.hpp"
#include "musher/transport/ros_environment.hpp"

namespace {

using musher::program::kUsageError;

constexpr const char* kDescription =
    "An actuator that wraps any program: a command for each state, whose exit code is the result.\n"
    "\n  musher-exec [OPTIONS] FILE\n  musher-exec [OPTIONS] -- PROGRAM [ARGUMENT]...";
constexpr const char* kFooter = R"(
After -- stands a program that runs from SetUp to TearDown, where no FILE is needed.

FILE, for example:
  module = 3000                       # exit code 9 becomes CyberDog's code 3009; default 100
  stop_ms = 2000                      # from SIGTERM to SIGKILL
  cwd = "."                           # where programs run, relative to FILE; default: as musher-exec
  [state.SetUp]
  start = ["./server", "--port", "80"] # runs until TearDown; if it exits before, so does musher-exec
  run = ["./wait-for-port", "80"]     # a command; exit code 0: done
  [state.SelfCheck]
  shell = "test -e /dev/ttyS0"        # the same as run, but a line for /bin/sh
  [emergency_stop]                    # at once at a stop, which is confirmed when this is done
  run = ["./brake"]                   # or shell; time_ms = 2000: its time
  end_program = true                  # then ends the program, until musher-exec is restarted
A state that FILE leaves out does nothing and succeeds.

Exit codes: 0 torn down, or ended by a signal; 1 SetUp failed, the program ended by itself, or a
signal came in TearDown; 2 usage or config.)";

struct Options {
  std::string file;
  std::string actuator;
  std::string state_config;
  std::vector<std::string> program;  // the arguments after --
  bool check = false;
};

// Nothing: the process exits with `exit_code`.
std::optional<Options> ReadOptions(int argc, char** argv, int& exit_code) {
  Options options;
  char** const end = argv + argc;
  char** const dashes = std::find(argv, end, std::string_view("--"));
  if (dashes != end) options.program.assign(dashes + 1, end);

  CLI::App app(kDescription, "musher-exec");
  app.footer(kFooter);
  app.set_version_flag("--version", "musher-exec " + std::string(musher::Version()),
                       "Print the version");
  app.add_option("FILE", options.file, "What to run in each state (TOML)");
  app.add_option("--actuator", options.actuator, "Which actuator of the state config this is")
      ->envname("MUSHER_ACTUATOR")
      ->required();
  app.add_option("--config", options.state_config, "The state config (TOML)")
      ->envname("MUSHER_CONFIG")
      ->required();
  app.add_flag("--check", options.check, "Report every error of the configs, and start nothing");
  try {
    app.parse(static_cast<int>(dashes - argv), argv);
    if (options.file.empty() == options.program.empty()) {
      throw CLI::ValidationError("expected either FILE or -- PROGRAM");
    }
    return options;
  } catch (const CLI::ParseError& error) {
    exit_code = musher::EndOfParse(app, error, kUsageError);
    return std::nullopt;
  }
}

// What the state config says of this process.
struct Role {
  musher::ActuatorConfig actuator;
  musher::TransportProfile profile = musher::TransportProfile::kLocal;
  std::vector<std::string> interfaces;
};

// Nothing: the errors were printed on stderr.
std::optional<Role> ReadRole(const std::string& state_config, const std::string& actuator) {
  const musher::ConfigReading machine = musher::ReadConfigFile(state_config);
  musher::program::PrintErrors(machine.diagnostics);
  if (!machine.config) return std::nullopt;
  const auto index = machine.config->IndexOf(actuator);
  if (!index) {
    std::cerr << state_config << ": " << musher::UnknownActuator(actuator, *machine.config).message
              << std::endl;
    return std::nullopt;
  }
  musher::transport::DdsOptions options;
  options.profile = machine.config->transport;
  const auto profile = musher::transport::Profile(options);  // an error is reported at the start
  return Role{machine.config->actuators[*index], profile ? profile.value() : options.profile,
              machine.config->interfaces};
}

int Run(const Options& options) {
  const auto role = ReadRole(options.state_config, options.actuator);
  if (!role) return kUsageError;
  const musher::ActuatorConfig& actuator = role->actuator;
  std::optional<musher::exec::ExecConfig> config;
  if (options.file.empty()) {
    config = musher::exec::ConfigForProgram(options.program);
  } else {
    musher::Parsed<musher::exec::ExecConfig> reading =
        musher::exec::ReadExecFile(options.file, actuator);
    for (const musher::Diagnostic& found : reading.diagnostics) {
      std::cerr << musher::FormatDiagnostic(found) << std::endl;
    }
    config = std::move(reading.config);
  }
  if (!config) return kUsageError;
  if (options.file.empty()) {
    std::cerr << "musher-exec: warning: " << musher::exec::WhyNothingStops(*config) << std::endl;
  }
  if (options.check) return 0;
  // Its commands may be ROS 2 programs.
  config->env = musher::transport::RosEnvironment(
      role->profile, musher::transport::OwnEnvironment(),
      musher::transport::OuterInterfaces(role->profile, role->interfaces));
  const auto reaper = musher::exec::Reaper::Start();
  if (!reaper) {
    std::cerr << actuator.name << ": " << reaper.error().message << std::endl;
    return 1;
  }
  return musher::exec::ExecProcess(actuator.name, *std::move(config), reaper.value())
      .Run(options.state_config);
}

}  // namespace

int main(int argc, char** argv) {
  int exit_code = 0;
  const std::optional<Options> options = ReadOptions(argc, argv, exit_code);
  return options ? Run(*options) : exit_code;
}
