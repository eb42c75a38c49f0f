#pragma once
// Starts a program from a process with many threads. Between fork and exec another thread may have
// left any lock taken, so all that the child needs is prepared before, and the child only makes
// async-signal-safe calls. The child has default signal handling and no descriptor of this process
// but 0, 1 and 2.
//
// Threads: any. Nothing here waits for a disk, except where it says so.

#include <sys/types.h>

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/base/exit_status.hpp"
#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {

struct ProgramSpec {
  std::vector<std::string> argv;           // not empty; without '/': looked up in PATH
  std::string cwd;                         // empty: the folder of this process
  std::map<std::string, std::string> env;  // added to the environment of this process …
  std::set<std::string> without = {};      // … which is passed on without these
  int input = -1;                          // its stdin; -1: /dev/null
  int output = -1;                         // its stdout; -1: the stdout of this process
  int errors = -1;  // its stderr; -1: where its stdout goes, if that is given
  // Run in the child: right after the fork, and just before the program is executed, which is not
  // done if that returns false. Async-signal-safe calls only. `environment` is the program's: an
  // entry may be changed in its place.
  std::function<void(char* const* environment)> after_fork = {};
  // The same, before `before_exec`: null, or what it could not do, with the reason in errno. That
  // text must live as long as the process.
  std::function<const char*()> set_up = {};
  std::function<bool()> before_exec = {};
};

// Why a program could not be executed.
struct ProgramFailure {
  Error error;
  bool missing = false;  // there is no such program
};

// A forked child. Its program may not run yet: the disk with it may be slow.
class ForkedProgram {
 public:
  ForkedProgram() = default;
  ForkedProgram(const ProgramSpec& spec, pid_t pid, UniqueFd report);

  pid_t pid() const { return pid_; }
  const std::string& program() const { return program_; }  // argv.front()

  // Waits, at most `timeout`, until the program runs or could not be executed; returns the reason.
  // nullopt: it runs, or that is not known yet.
  std::optional<ProgramFailure> Failure(std::optional<Duration> timeout = std::nullopt) const;

 private:
  pid_t pid_ = 0;
  std::string program_;
  std::string cwd_;
  UniqueFd report_;
};

// Forks. The caller watches and reaps the child.
Result<ForkedProgram> ForkProgram(const ProgramSpec& spec);

struct ProgramEnd {
  ExitStatus status;
  bool timed_out = false;                 // it was killed, since it did not exit in time
  std::string output;                     // its stdout
  std::string errors;                     // its stderr
  std::optional<ProgramFailure> failure;  // it was not executed
};

// Runs a program to its end with `input` as its stdin. Blocks; kills it after `timeout`.
Result<ProgramEnd> RunProgram(const ProgramSpec& spec, const std::string& input,
                              std::optional<Duration> timeout = std::nullopt);

}  // namespace musher
