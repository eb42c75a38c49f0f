#pragma once
// Runs a command to its end, or stops it when it is not waited for any more. What it writes to
// stdout and stderr goes to our stdout; the last line of it is the reason people are told.
//
// Threads: one at a time.

#include <functional>
#include <string>
#include <string_view>

#include "musher/lifecycle/result.hpp"
#include "musher/modules/exec/child.hpp"

namespace musher::exec {

// How much a command is still wanted. Asked about every 20 ms while it runs.
enum class Wanted {
  kYes,
  kNo,       // SIGTERM, and SIGKILL when that has not helped in `stop_time`
  kGetDone,  // SIGKILL at once
};

struct CommandEnd {
  ExitStatus status;
  bool stopped = false;   // it got a signal from us before it ended
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
