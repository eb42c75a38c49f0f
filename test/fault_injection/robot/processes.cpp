#include "musher/test/fault_injection/robot/processes.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

namespace musher::fault_injection {
namespace {

namespace fs = std::filesystem;

// Strings that end with a zero byte.
std::vector<std::string> Strings(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<std::string> strings;
  for (std::string text; std::getline(in, text, '\0');) strings.push_back(text);
  return strings;
}

bool Has(const std::vector<std::string>& strings, const std::string& text) {
  return std::find(strings.begin(), strings.end(), text) != strings.end();
}

std::vector<pid_t> AllProcesses() {
  std::vector<pid_t> pids;
  std::error_code ended;
  for (const auto& entry : fs::directory_iterator("/proc", ended)) {
    const std::string name = entry.path().filename();
    if (std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c); })) {
      pids.push_back(std::stoi(name));
    }
  }
  return pids;
}

std::string Proc(pid_t pid, const char* file) {
  return "/proc/" + std::to_string(pid) + "/" + file;
}

}  // namespace

std::vector<std::string> CommandLine(pid_t pid) {
  return Strings(Proc(pid, "cmdline"));
}

std::vector<pid_t> FindByArgument(const std::string& word) {
  std::vector<pid_t> found;
  for (const pid_t pid : AllProcesses()) {
    if (Has(CommandLine(pid), word)) found.push_back(pid);
  }
  return found;
}

std::vector<pid_t> ChildrenOf(pid_t pid) {
  std::vector<pid_t> children;
  std::error_code ended;
  for (const auto& task : fs::directory_iterator(Proc(pid, "task"), ended)) {
    std::ifstream file(task.path() / "children");
    for (pid_t child = 0; file >> child;) children.push_back(child);
  }
  return children;
}

char StateLetterOf(pid_t pid) {
  std::ifstream file(Proc(pid, "stat"));
  std::string text;
  std::getline(file, text);  // fails when the process ends meanwhile
  const auto name_end = text.rfind(')');
  return name_end == std::string::npos || name_end + 2 >= text.size() ? '\0' : text[name_end + 2];
}

bool IsAlive(pid_t pid) {
  const char state = StateLetterOf(pid);
  return state != '\0' && state != 'Z' && state != 'X';
}

void AdoptOrphans() {
  prctl(PR_SET_CHILD_SUBREAPER, 1);
}

void ReapOrphans(const std::vector<pid_t>& but_not) {
  for (const pid_t child : ChildrenOf(getpid())) {
    const bool owned = std::find(but_not.begin(), but_not.end(), child) != but_not.end();
    if (!owned) waitpid(child, nullptr, WNOHANG);
  }
}

void KillMarked(const std::string& variable) {
  // Until a pass finds none: a process that was about to start another has done so by the next
  // pass.
  for (bool found = true; found;) {
    found = false;
    for (const pid_t pid : AllProcesses()) {
      if (pid == getpid() || !IsAlive(pid)) continue;
      if (Has(Strings(Proc(pid, "environ")), variable)) {
        found = true;
        kill(pid, SIGKILL);
      }
    }
  }
}

}  // namespace musher::fault_injection
