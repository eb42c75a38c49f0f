#include "musher/controller/child_processes.hpp"

#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "musher/transport/host.hpp"

namespace musher {
namespace {

std::string VariableOf(pid_t pid, const std::string& name) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/environ", std::ios::binary);
  const std::string begin = name + "=";
  for (std::string variable; std::getline(file, variable, '\0');) {
    if (variable.starts_with(begin)) return variable.substr(begin.size());
  }
  return {};
}

// Kills the process that was found, never a later one with the same pid.
void Kill(const MarkedProcess& process) {
  const auto pidfd = transport::OpenPidfd(process.pid);
  if (!pidfd || StartTimeOf(process.pid) != process.start_time) return;
  syscall(SYS_pidfd_send_signal, pidfd.value().get(), SIGKILL, nullptr, 0);
}

}  // namespace

// "4711 (sh) S 1 4711 4711 0 …": the name may contain spaces and brackets.
std::optional<std::uint64_t> StartTimeOf(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::size_t bracket = text.rfind(')');
  if (bracket == std::string::npos) return std::nullopt;
  std::istringstream fields(text.substr(bracket + 1));
  std::string state;
  std::string skipped;
  std::uint64_t start_time = 0;
  fields >> state;  // field 3
  for (int field = 4; field < 22; ++field) fields >> skipped;
  if (!(fields >> start_time) || state == "Z" || state == "X") return std::nullopt;
  return start_time;
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
                       kind == "process" && child.pid > 0;
    if (whole) children.push_back(child);
  }
  return children;
}

std::vector<MarkedProcess> FindMarked() {
  std::vector<MarkedProcess> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
    const pid_t pid = std::atoi(entry.path().filename().c_str());
    struct stat owner {};
    if (pid == 0 || stat(entry.path().c_str(), &owner) != 0 || owner.st_uid != geteuid()) continue;
    const std::string value = VariableOf(pid, kChildMark);
    if (value.size() <= kMarkDigits || value[kMarkDigits] != '/') continue;
    const auto start_time = StartTimeOf(pid);
    if (!start_time) continue;
    found.push_back({value.substr(kMarkDigits + 1), std::atoi(value.c_str()), pid, *start_time});
  }
  return found;
}

std::vector<ChildProcess> FindChildren(const std::vector<MarkedActuator>& actuators,
                                       const std::vector<ChildProcess>& stored) {
  std::vector<ChildProcess> children;
  const std::vector<MarkedProcess> marked = FindMarked();
  for (const MarkedActuator& actuator : actuators) {
    std::optional<ChildProcess> child;
    for (const ChildProcess& one : stored) {
      if (one.actuator == actuator.name && IsRunning(one)) child = one;
    }
    for (const MarkedProcess& one : marked) {
      const bool matches = one.mark == actuator.mark && one.pid == one.started;
      if (matches && !child) child = {actuator.name, one.pid, one.start_time};
    }
    if (child) {
      children.push_back(*child);
      continue;
    }
    for (const MarkedProcess& one : marked) {
      if (one.mark == actuator.mark && !actuator.runs) Kill(one);
    }
  }
  return children;
}

}  // namespace musher
