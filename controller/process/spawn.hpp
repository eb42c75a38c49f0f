#pragma once
// Starting a program from a process with many threads (see process_supervisor.hpp for what the
// child gets). The caller watches and reaps the child.

#include <sys/types.h>

#include <optional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/process/process_runner.hpp"

namespace musher {

// A forked child. Its exec may still be pending: the disk with the program may be slow.
class Spawned {
 public:
  Spawned() = default;
  Spawned(const ProcessSpec& spec, pid_t pid, UniqueFd report);

  pid_t pid() const { return pid_; }
  // Waits at most `timeout` until its program runs or fails to start; returns the error. None also
  // means: not known yet.
  std::optional<Error> Failure(Duration timeout) const;

 private:
  pid_t pid_ = 0;
  std::string program_;
  std::string cwd_;
  UniqueFd report_;
};

// Forks. Does not wait for a disk. Threads: any.
Result<Spawned> Spawn(const ProcessSpec& spec);

}  // namespace musher
