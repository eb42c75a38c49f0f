#include "musher/controller/process/child_processes.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <thread>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/time.hpp"
#include "musher/controller/process/network_namespace.hpp"

namespace musher {
namespace {

// Whether the process has the pids and the network of this process: a container may run the same
// machine, whose processes have the same marks.
bool IsInOurNamespaces(pid_t pid) {
  for (const char* kind : {"pid", "net"}) {
    struct stat ours {};
    struct stat theirs {};
    const std::string process = "/proc/" + std::to_string(pid);
    if (stat((std::string("/proc/self/ns/") + kind).c_str(), &ours) != 0) continue;
    if (stat((process + "/ns/" + kind).c_str(), &theirs) != 0) return false;
    if (ours.st_ino != theirs.st_ino || ours.st_dev != theirs.st_dev) return false;
  }
  return true;
}

// A file of a process; empty if the process has exited or hides it.
std::string ProcFile(pid_t pid, const char* name) {
  return ReadFile("/proc/" + std::to_string(pid) + "/" + name);
}

// Field `number` of /proc/<pid>/stat, from 3 on; empty if the process has exited.
// "4711 (sh) S 1 4711 4711 0 …": the name may contain spaces and brackets.
std::string StatField(pid_t pid, int number) {
  const std::string text = ProcFile(pid, "stat");
  const std::size_t bracket = text.rfind(')');
  if (bracket == std::string::npos) return {};
  std::istringstream fields(text.substr(bracket + 1));
  std::string field;
  for (int i = 3; i <= number; ++i) fields >> field;
  return fields ? field : std::string();
}

// The environment that the process was started with; empty: it has none, has exited or hides it.
// In the middle of an exec a process has a program, but for some microseconds no environment and no
// place for one: waits for the end of the exec, at most until `until`.
std::string EnvironmentOf(pid_t pid, Time until) {
  constexpr int kBegin = 50, kEnd = 51;  // of the environment, in /proc/<pid>/stat
  const std::string program = "/proc/" + std::to_string(pid) + "/exe";
  do {
    std::string environment = ProcFile(pid, "environ");
    if (!environment.empty()) return environment;
    const std::string begin = StatField(pid, kBegin);
    if (begin != "0" && begin == StatField(pid, kEnd)) return {};
    std::array<char, 1> any{};
    if (readlink(program.c_str(), any.data(), any.size()) < 0) return {};
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  } while (std::chrono::steady_clock::now() < until);
  return {};
}

// This process and its ancestors: a controller that was started in the shell of an actuator has the
// actuator's mark.
std::set<pid_t> OwnLineage() {
  std::set<pid_t> lineage;
  for (pid_t pid = getpid(); pid > 1 && lineage.insert(pid).second;) {
    pid = std::atoi(StatField(pid, 4).c_str());
  }
  return lineage;
}

// Kills the process that was found, never a later one with the same pid.
void Kill(const MarkedProcess& process) {
  const auto pidfd = OpenPidfd(process.pid);
  if (!pidfd || StartTimeOf(process.pid) != process.start_time) return;
  SendSignal(pidfd.value().get(), SIGKILL);
}

// How long the end of an exec is waited for: some microseconds, longer on a host that lacks CPU.
constexpr auto kExecTime = std::chrono::seconds(1);

// A variable of an environment.
std::string VariableIn(const std::string& text, const std::string& name) {
  std::istringstream environment(text);
  const std::string begin = name + "=";
  for (std::string variable; std::getline(environment, variable, '\0');) {
    if (variable.starts_with(begin)) return variable.substr(begin.size());
  }
  return {};
}

// The processes of our own user, pids and network that have a variable, with its value.
std::vector<std::pair<pid_t, std::string>> OurProcessesWith(const std::string& variable) {
  std::vector<std::pair<pid_t, std::string>> found;
  const Time until = std::chrono::steady_clock::now() + kExecTime;
  for (const auto& process : EntriesOf("/proc")) {
    const pid_t pid = std::atoi(process.filename().c_str());
    struct stat owner {};
    if (pid == 0 || stat(process.c_str(), &owner) != 0 || owner.st_uid != geteuid()) continue;
    std::string value = VariableIn(EnvironmentOf(pid, until), variable);
    if (!value.empty() && IsInOurNamespaces(pid)) found.emplace_back(pid, std::move(value));
  }
  return found;
}

}  // namespace

std::string VariableOf(pid_t pid, const std::string& name) {
  return VariableIn(EnvironmentOf(pid, std::chrono::steady_clock::now() + kExecTime), name);
}

std::optional<std::uint64_t> StartTimeOf(pid_t pid) {
  const std::string state = StatField(pid, 3);
  if (state.empty() || state == "Z" || state == "X") return std::nullopt;
  const std::string start_time = StatField(pid, 22);
  if (start_time.empty()) return std::nullopt;
  return std::strtoull(start_time.c_str(), nullptr, 10);
}

bool IsRunning(const ChildProcess& child) {
  return child.pid > 0 && StartTimeOf(child.pid) == child.start_time;
}

std::string ToText(const std::vector<ChildProcess>& children, const std::string& host) {
  std::ostringstream text;
  text << "host " << host << "\n";
  for (const ChildProcess& child : children) {
    text << "process " << child.pid << " " << child.start_time << " " << child.actuator << "\n";
  }
  text << "network " << OwnNetwork() << "\n";
  return text.str();
}

std::vector<ChildProcess> ChildrenFrom(const std::string& text, const std::string& host) {
  std::istringstream lines(text);
  std::string line;
  if (host.empty() || !std::getline(lines, line) || line != "host " + host) return {};
  std::vector<ChildProcess> children;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string kind;
    ChildProcess child;
    const bool whole = words >> kind >> child.pid >> child.start_time >> child.actuator &&
                       kind == "process" && child.pid > 1;
    if (whole) children.push_back(child);
  }
  return children;
}

std::vector<ChildProcess> ChildrenInOtherNetwork(const std::string& text, const std::string& host) {
  std::istringstream words(text);
  ino_t network = 0;
  for (std::string word; words >> word;) {
    if (word == "network") words >> network;
  }
  const ino_t ours = OwnNetwork();
  if (network == 0 || ours == 0 || network == ours) return {};
  std::vector<ChildProcess> children = ChildrenFrom(text, host);
  std::erase_if(children, [network](const ChildProcess& child) {
    return !IsRunning(child) || NetworkOf(child.pid) != network;
  });
  return children;
}

std::string NamesOf(const std::vector<ChildProcess>& children) {
  std::string names;
  for (const ChildProcess& child : children) {
    names += (names.empty() ? "" : ", ") + child.actuator;
    names += " (pid " + std::to_string(child.pid) + ")";
  }
  return names;
}

std::vector<MarkedProcess> FindMarked() {
  std::vector<MarkedProcess> found;
  for (const auto& [pid, value] : OurProcessesWith(kChildMark)) {
    if (value.size() <= kMarkDigits || value[kMarkDigits] != '/') continue;
    const auto start_time = StartTimeOf(pid);
    if (!start_time) continue;
    const pid_t started = std::atoi(value.c_str());
    found.push_back(
        {value.substr(kMarkDigits + 1), started != 0 ? started : getsid(pid), pid, *start_time});
  }
  return found;
}

std::vector<MarkedProcess> FindMarkedWith(const std::string& name, const std::string& begin) {
  std::vector<MarkedProcess> found = FindMarked();
  const std::set<pid_t> lineage = OwnLineage();
  std::erase_if(found, [&](const MarkedProcess& one) {
    return lineage.contains(one.pid) || !VariableOf(one.pid, name).starts_with(begin);
  });
  return found;
}

std::vector<ChildProcess> FindChildren(const std::vector<MarkedActuator>& actuators,
                                       const std::vector<ChildProcess>& stored) {
  std::vector<ChildProcess> children;
  const std::vector<MarkedProcess> marked = FindMarked();
  const std::set<pid_t> lineage = OwnLineage();
  for (const MarkedActuator& actuator : actuators) {
    std::optional<ChildProcess> child;
    for (const ChildProcess& one : stored) {
      if (one.actuator == actuator.name && IsRunning(one)) child = one;
    }
    const bool is_stored = child.has_value();
    for (const MarkedProcess& one : marked) {
      const bool matches = one.mark == actuator.mark && one.pid == one.started;
      // What a unit has started may have made a session of its own.
      const bool first = !child || (!is_stored && one.start_time < child->start_time);
      if (matches && first) child = {actuator.name, one.pid, one.start_time};
    }
    if (child) {
      children.push_back(*child);
      continue;
    }
    for (const MarkedProcess& one : marked) {
      const bool left = one.mark == actuator.mark && !actuator.runs;
      if (left && !lineage.contains(one.pid)) Kill(one);
    }
  }
  return children;
}

std::string ChildMarkOf(pid_t pid) {
  const std::string value = VariableOf(pid, kChildMark);
  return value.size() > kMarkDigits ? value.substr(kMarkDigits + 1) : std::string();
}

void KillMarked(const std::string& mark, pid_t started) {
  if (mark.empty()) return;
  const std::set<pid_t> lineage = OwnLineage();
  for (const MarkedProcess& one : FindMarked()) {
    if (one.mark == mark && one.started == started && !lineage.contains(one.pid)) Kill(one);
  }
}

}  // namespace musher
