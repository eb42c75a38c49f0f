#include "musher/cli/config/program_check.hpp"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>

#include "musher/base/program.hpp"
#include "musher/base/program_path.hpp"
#include "musher/cli/config/config_places.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

std::string SearchPathOf(const ActuatorConfig& actuator) {
  const auto own = actuator.env.find("PATH");
  if (own != actuator.env.end()) return own->second;
  const std::string folder = OwnProgram().parent_path().string();  // as the controller does
  return folder.empty() ? SearchPath() : folder + ":" + SearchPath();
}

// The path of the program that a command would run; empty: `why` has the error.
std::string ProgramOf(const ActuatorConfig& actuator, const fs::path& config_folder,
                      std::string& why) {
  const std::string& program = actuator.command.front();
  const auto is_program = [&](const fs::path& path) {
    std::error_code error;
    if (!fs::exists(path, error)) return false;
    why = fs::is_directory(path, error)     ? path.string() + " is a folder"
          : access(path.c_str(), X_OK) != 0 ? path.string() + " is not executable"
                                            : "";
    return why.empty();
  };
  if (program.find('/') != std::string::npos) {
    const fs::path path =
        actuator.cwd.empty() ? fs::path(program) : actuator.cwd / fs::path(program);
    why = "program not found: " + path.string();
    return is_program(path) ? path.string() : "";
  }
  why = "program '" + program + "' not found in PATH" + transport::MissingProgramHint(program);
  const std::string in_path = why;
  for (const std::string& path : CandidatesInPath(program, SearchPathOf(actuator))) {
    if (is_program(path)) return path;
  }
  std::error_code error;
  const fs::path folder = actuator.cwd.empty() ? config_folder : fs::path(actuator.cwd);
  if (why == in_path && fs::exists(folder / program, error)) {
    why += "; did you mean './" + program + "', the file in " + folder.string() + "?" +
           (actuator.cwd.empty() ? " With cwd = \".\" it is found from everywhere" : "");
  }
  return "";
}

// Musher's own programs, which all support --check. Another program with a similar name could
// ignore the option and start.
bool SupportsCheck(const std::string& program) {
  static const std::set<std::string> programs = {
      "musher-exec",           "musher-motion-manager",  "musher-audio-manager",
      "musher-device-manager", "musher-sensor-manager",  "musher-camera-manager",
      "musher-vision-manager", "musher-wedding",         "musher-world",
      "musher-skills",         "musher-plan-dispatcher", "musher-meilin-planner",
      "musher-planner",        "musher-controller",      "musher-route",
      "musher-race",           "musher-meilin",          "musher-line-walker",
      "musher-meilin-server",  "musher-vp-engine"};
  return programs.contains(fs::path(program).filename().string());
}

struct Ran {
  bool ok = false;
  std::string err;
};

// Runs the program with --check and returns its report.
Ran RunCheck(const std::string& program, const ActuatorConfig& actuator,
             const std::string& config_file, Duration timeout) {
  ProgramSpec spec;
  spec.argv = {program, "--check", "--config", config_file, "--actuator", actuator.name};
  spec.argv.insert(spec.argv.end(), actuator.command.begin() + 1, actuator.command.end());
  spec.cwd = actuator.cwd;
  const auto run = RunProgram(spec, "", timeout);
  if (!run) return {false, run.error().message};
  const ProgramEnd& end = run.value();
  if (end.failure) return {false, end.failure->error.message};
  if (end.timed_out) {
    return {false, program + " --check did not exit within " +
                       std::to_string(ToMilliseconds(timeout)) + " ms"};
  }
  constexpr std::size_t kLongest = 8192;
  Ran ran{end.status.ok(), (end.errors + end.output).substr(0, kLongest)};
  if (!ran.ok && ran.err.empty()) {
    ran.err = program + " --check: " + end.status.Text() + ", without a message";
  }
  return ran;
}

// Whether the line is about the state config itself, which is already reported.
bool IsOn(const std::string& file, const std::string& line) {
  const std::size_t at = line.find(file + ":");
  const std::size_t number = at + file.size() + 1;
  return at != std::string::npos && number < line.size() && line[number] >= '0' &&
         line[number] <= '9';
}

}  // namespace

std::vector<Diagnostic> CheckPrograms(const MachineConfig& config, Duration timeout,
                                      Severity missing) {
  const ConfigPlaces places(config.file);
  std::error_code no_folder;  // then the path stays relative
  const std::string file = fs::absolute(config.file, no_folder).string();
  std::vector<Diagnostic> found;
  const auto add = [&](const ActuatorConfig& actuator, const std::string& key, Severity severity,
                       const std::string& message) {
    const int line = places.LineOf("actuator." + actuator.name, key);
    found.push_back({config.file, line, line == 0 ? 0 : 1, severity,
                     "in 'actuator." + actuator.name + "': '" + key + "': " + message});
  };
  for (const ActuatorConfig& actuator : config.actuators) {
    // An empty program is an error of the config, which is already reported. A program of another
    // host is there.
    if (actuator.command.empty() || actuator.command.front().empty()) continue;
    if (!actuator.host.empty()) continue;
    std::error_code error;
    if (!actuator.cwd.empty() && !fs::is_directory(actuator.cwd, error)) {
      add(actuator, "cwd", missing, "folder not found: " + actuator.cwd);
      continue;
    }
    std::string why;
    const std::string program = ProgramOf(actuator, fs::path(file).parent_path(), why);
    if (program.empty()) {
      add(actuator, "command", missing, why);
      continue;
    }
    if (!SupportsCheck(program)) continue;
    const Ran ran = RunCheck(program, actuator, file, timeout);
    std::istringstream lines(ran.err);
    for (std::string line; std::getline(lines, line);) {
      if (line.empty() || line.starts_with("Run with --help") || IsOn(file, line)) continue;
      const bool warning = line.find(": warning: ") != std::string::npos;
      if (ran.ok && !warning) continue;
      add(actuator, "command", warning ? Severity::kWarning : Severity::kError, line);
    }
  }
  return found;
}

}  // namespace musher::cli
