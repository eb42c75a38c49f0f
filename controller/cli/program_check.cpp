#include "musher/controller/cli/program_check.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string>
#include <string_view>

#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/cli/config_places.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

std::string PathOf(const ActuatorConfig& actuator) {
  const auto own = actuator.env.find("PATH");
  const char* inherited = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe)
  if (own != actuator.env.end()) return own->second;
  std::error_code error;
  const auto self = fs::read_symlink("/proc/self/exe", error);  // as the controller does
  return (error ? "" : self.parent_path().string() + ":") + (inherited != nullptr ? inherited : "");
}

// The path of the program that a command would run; empty: `why` has the error.
std::string ProgramOf(const ActuatorConfig& actuator, std::string& why) {
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
  std::istringstream folders(PathOf(actuator));
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path path = fs::path(folder.empty() ? "." : folder) / program;
    if (is_program(path)) return path.string();
  }
  return "";
}

// Musher's own programs, which all support --check. Another program with a similar name could
// ignore the option and start.
bool SupportsCheck(const std::string& program) {
  constexpr std::array<std::string_view, 9> kPrograms = {
      "musher-exec",           "musher-motion-manager", "musher-audio-manager",
      "musher-device-manager", "musher-sensor-manager", "musher-camera-manager",
      "musher-vision-manager", "musher-wedding",        "musher-world"};
  return std::find(kPrograms.begin(), kPrograms.end(), fs::path(program).filename().string()) !=
         kPrograms.end();
}

struct Ran {
  bool ok = false;
  std::string err;
};

bool ExitsWithin(pid_t pid, Duration timeout) {
  const auto process = OpenPidfd(pid);
  if (!process) return false;
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    pollfd ended{process.value().get(), POLLIN, 0};
    const int ready = poll(&ended, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    if (ready >= 0 || errno != EINTR) return ready == 1;
  }
}

// Runs the program with --check and returns its report.
Ran RunCheck(const std::string& program, const ActuatorConfig& actuator,
             const std::string& config_file, Duration timeout) {
  std::vector<std::string> words = {program,     "--check",    "--config",
                                    config_file, "--actuator", actuator.name};
  words.insert(words.end(), actuator.command.begin() + 1, actuator.command.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const UniqueFd output(memfd_create("check", MFD_CLOEXEC));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, output.get(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output.get(), STDERR_FILENO);
  if (!actuator.cwd.empty()) posix_spawn_file_actions_addchdir_np(&actions, actuator.cwd.c_str());
  pid_t pid = 0;
  const int error = posix_spawn(&pid, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return {false, "can't run " + program + ": " + std::strerror(error)};
  const bool exited = ExitsWithin(pid, timeout);
  if (!exited) kill(pid, SIGKILL);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (!exited) {
    return {false, program + " --check did not exit within " +
                       std::to_string(ToMilliseconds(timeout)) + " ms"};
  }
  std::array<char, 8192> text{};
  const ssize_t size = pread(output.get(), text.data(), text.size(), 0);
  Ran ran{WIFEXITED(status) && WEXITSTATUS(status) == 0,
          std::string(text.data(), static_cast<std::size_t>(size < 0 ? 0 : size))};
  if (!ran.ok && ran.err.empty()) {
    ran.err = program + " --check " +
              (WIFEXITED(status) ? "exited with code " + std::to_string(WEXITSTATUS(status))
                                 : "was killed by signal " + std::to_string(WTERMSIG(status))) +
              " without a message";
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

std::vector<Diagnostic> CheckPrograms(const MachineConfig& config, Duration timeout) {
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
    if (actuator.command.empty()) continue;
    std::error_code error;
    if (!actuator.cwd.empty() && !fs::is_directory(actuator.cwd, error)) {
      add(actuator, "cwd", Severity::kWarning, "folder not found: " + actuator.cwd);
      continue;
    }
    std::string why;
    const std::string program = ProgramOf(actuator, why);
    if (program.empty()) {
      add(actuator, "command", Severity::kWarning, why);
      continue;
    }
    if (!SupportsCheck(program)) continue;
    const Ran ran = RunCheck(program, actuator, file, timeout);
    if (ran.ok) continue;
    std::istringstream lines(ran.err);
    for (std::string line; std::getline(lines, line);) {
      if (line.empty() || line.starts_with("Run with --help") || IsOn(file, line)) continue;
      add(actuator, "command", Severity::kError, line);
    }
  }
  return found;
}

}  // namespace musher::cli
