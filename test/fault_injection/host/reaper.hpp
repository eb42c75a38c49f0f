#pragma once
// A small process that cleans up after the fault-injection suite, however that ends: it kills all
// processes that the suite has started, and removes its folder.

#include <sys/types.h>

#include <filesystem>

#include "musher/base/unique_fd.hpp"

namespace musher::fault_injection {

class Reaper {
 public:
  // Marks the environment of all processes started from now on, and watches this process. To be
  // made before there is a second thread.
  Reaper();
  // Waits for the end of the clean-up.
  ~Reaper();
  Reaper(const Reaper&) = delete;
  Reaper& operator=(const Reaper&) = delete;

  // For the robots' files.
  const std::filesystem::path& folder() const { return folder_; }
  pid_t pid() const { return pid_; }

 private:
  std::filesystem::path folder_;
  UniqueFd alive_;
  pid_t pid_ = 0;
};

}  // namespace musher::fault_injection
