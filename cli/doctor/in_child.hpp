#pragma once
// Runs a function in a forked child with a time limit, so that neither a disk nor a library that
// blocks can hold the command. To be used before this process has threads.

#include <sys/types.h>

#include <functional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher::cli {

class InChild {
 public:
  // Forks; the child writes what the function returns to a pipe and exits.
  static Result<InChild> Start(const std::function<std::string()>& function);

  InChild(InChild&& other) noexcept;
  InChild& operator=(InChild&&) = delete;
  ~InChild();  // kills it

  // Waits until `deadline` for what the function returned.
  Result<std::string> Await(Time deadline);

 private:
  InChild(pid_t pid, UniqueFd output) : pid_(pid), output_(std::move(output)) {}

  pid_t pid_ = 0;
  UniqueFd output_;
};

}  // namespace musher::cli
