#pragma once
// Starting a program from a process with many threads (see process_supervisor.hpp for what the
// child gets). The caller watches and reaps the child.

#include <sys/types.h>

#include <optional>
#include <string>

#include "musher/controller/process_runner.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher {

// A forked child. Its exec may still be pending: the disk with the program may be slow.
class Spawned {
 public:
  Spawned() = default;
  Spawned(const ProcessSpec& spec, pid_t pid, transport::UniqueFd report);

  pid_t pid() const { return pid_; }
  // Waits at most `timeout` until its program runs or fails to start; returns the error. None also
  // means: not known yet.
  std::optional<Error> Failure(Duration timeout) const;

 private:
  pid_t pid_ = 0;
  std::string program_;
  std::string cwd_;
  transport::UniqueFd report_;
};

// Forks. Does not wait for a disk. Threads: any.
Result<Spawned> Spawn(const ProcessSpec& spec);

}  // namespace musher
