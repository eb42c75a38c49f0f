#pragma once
// Runs a command to its end, or stops it when its result is no longer needed. Its stdout and
// stderr go to this process's stdout; the last line becomes the reason in a failure message.
//
// Threads: one at a time.

#include <functional>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/modules/exec/child.hpp"

namespace musher::exec {

// Whether a command is still wanted. Polled about every 20 ms while it runs.
enum class Wanted {
  kYes,
  kNo,       // SIGTERM, and SIGKILL after `stop_time`
  kGetDone,  // SIGKILL at once
};

struct CommandEnd {
  ExitStatus status;
  bool stopped = false;   // this process signalled it before it exited
  std::string last_line;  // of its output, see LastLine
};

// Fails when the command cannot be run.
Result<CommandEnd> RunCommand(const ChildSpec& spec, const Reaper& reaper, Duration stop_time,
                              const std::function<Wanted()>& wanted);

// Keeps the last line of a stream that is not blank: in valid UTF-8, without control characters, at
// most 200 bytes long.
class LastLine {
 public:
  void Add(std::string_view text);
  std::string Get() const;

 private:
  std::string current_;
  std::string last_;
};

}  // namespace musher::exec
