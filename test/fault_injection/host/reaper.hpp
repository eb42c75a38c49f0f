#pragma once
// A small process that cleans up behind the fault-injection suite, whatever that dies of: kills all
// that it has started, and removes its folder.

#include <sys/types.h>

#include <filesystem>

#include "musher/transport/unique_fd.hpp"

namespace musher::fault_injection {

class Reaper {
 public:
  // Marks the environment of all that is started from now on, and begins to watch. To be made
  // before there is a second thread.
  Reaper();
  // Waits until all is cleaned up.
  ~Reaper();
  Reaper(const Reaper&) = delete;
  Reaper& operator=(const Reaper&) = delete;

  // For the robots' files.
  const std::filesystem::path& folder() const { return folder_; }
  pid_t pid() const { return pid_; }

 private:
  std::filesystem::path folder_;
  transport::UniqueFd alive_;
  pid_t pid_ = 0;
};

}  // namespace musher::fault_injection
