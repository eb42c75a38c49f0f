#include "musher/controller/process/spawn.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cstring>
#include <optional>
#include <string>

#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher {
namespace {

// In the child: its own pid, where "MUSHER_STARTED_AS=" is followed by zeros.
void WriteMark(char* const* environment) {
  const std::size_t name = std::strlen(kChildMark);
  for (; *environment != nullptr; ++environment) {
    if (std::strncmp(*environment, kChildMark, name) != 0 || (*environment)[name] != '=') continue;
    char* digits = *environment + name + 1;
    pid_t number = getpid();
    for (std::size_t i = kMarkDigits; i > 0; --i, number /= 10) {
      digits[i - 1] = static_cast<char>('0' + number % 10);
    }
  }
}

// Runs in the child, which has a session of its own. A kernel with autogroups weighs sessions, and
// the niceness only counts inside a session. A kernel without autogroups has no such file.
void WriteAutogroup(int nice) {
  const int file = open("/proc/self/autogroup", O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  std::array<char, 8> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), nice).ptr;
  [[maybe_unused]] const ssize_t count =
      write(file, text.data(), static_cast<std::size_t>(end - text.data()));
  close(file);
}

// In the child.
const char* KeepLimits(std::optional<int> nice, std::optional<int> realtime_priority) {
  if (nice && setpriority(PRIO_PROCESS, 0, *nice) != 0) {
    return "set its `nice`, which takes root, or LimitNICE= in the unit of the controller";
  }
  if (nice) WriteAutogroup(*nice);
  if (!realtime_priority) return nullptr;
  sched_param priority{};
  priority.sched_priority = *realtime_priority;
  if (sched_setscheduler(0, SCHED_FIFO, &priority) == 0) return nullptr;
  return "set its `realtime_priority`, which takes root, or LimitRTPRIO= in the unit of the "
         "controller";
}

}  // namespace

Result<ForkedProgram> Spawn(const ProcessSpec& spec) {
  ProgramSpec program;
  program.argv = spec.argv;
  program.cwd = spec.cwd;
  program.env = spec.env;
  // What systemd gave to this process alone. An actuator that inherits it would notify systemd in
  // the name of the whole robot; a program with systemd support does so on its own.
  program.without = {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"};
  // The output of this process is not inherited: it may be a pipe of the program that started it.
  UniqueFd nowhere;
  if (spec.output < 0) {
    nowhere = UniqueFd(open("/dev/null", O_WRONLY | O_CLOEXEC));
    if (!nowhere.valid()) return SystemError("can't open /dev/null");
  }
  program.output = spec.output >= 0 ? spec.output : nowhere.get();
  program.env.emplace("MUSHER_LOG_TIME", "1");  // `musher logs` merges the lines by their times
  const bool marked = !spec.mark.empty();
  if (marked) program.env[kChildMark] = std::string(kMarkDigits, '0') + "/" + spec.mark;
  program.after_fork = [marked](char* const* environment) {
    setsid();
    if (marked) WriteMark(environment);
  };
  program.set_up = [nice = spec.limits.nice, priority = spec.limits.realtime_priority] {
    return KeepLimits(nice, priority);
  };
  // The next controller finds this process only after execve, by the mark in its environment; if
  // this controller has exited meanwhile, the process exits.
  program.before_exec = [parent = getpid()] { return getppid() == parent; };
  return ForkProgram(program);
}

Error ErrorOf(const ProgramFailure& failure, const ForkedProgram& program) {
  Error error = failure.error;
  if (failure.missing) error.message += transport::MissingProgramHint(program.program());
  return error;
}

}  // namespace musher
