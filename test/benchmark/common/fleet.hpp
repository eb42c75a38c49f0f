#pragma once
// Machines of many actuators for measuring: a config in a folder of its own.

#include <string>
#include <vector>

#include "musher/lifecycle/switch_result.hpp"

namespace musher::benchmark {

class Fleet {
 public:
  // A machine of `count` actuators "a0", "a1", ...; `started`: the controller starts a process for
  // each. Without it they are started by hand.
  Fleet(int count, bool started);
  ~Fleet();
  Fleet(const Fleet&) = delete;
  Fleet& operator=(const Fleet&) = delete;

  const std::string& config_file() const { return config_file_; }
  const std::vector<std::string>& names() const { return names_; }

 private:
  std::string folder_;
  std::string config_file_;
  std::vector<std::string> names_;
};

// Ends the benchmark unless the switch is done.
void MustBeDone(const SwitchResult& result);

}  // namespace musher::benchmark
