#pragma once
// Machines of many actuators for measuring: a config in a folder of its own.

#include <functional>
#include <string>
#include <vector>

#include "musher/lifecycle/machine/switch_result.hpp"

namespace musher::benchmark {

class Fleet {
 public:
  // A machine of `count` actuators "a0", "a1", ...; `started`: the controller starts a process for
  // each. Without it they are started by hand.
  Fleet(int count, bool started);
  // The same with more lines in the table of each actuator, and more tables.
  using Keys = std::function<std::string(const Fleet& fleet, const std::string& name)>;
  Fleet(const Keys& keys, int count, const std::string& tables = "");
  ~Fleet();
  Fleet(const Fleet&) = delete;
  Fleet& operator=(const Fleet&) = delete;

  const std::string& folder() const { return folder_; }
  const std::string& config_file() const { return config_file_; }
  const std::vector<std::string>& names() const { return names_; }
  // Of an actuator that is a benchmark_module: its board (board.hpp), and how it is started; `hz`:
  // of its cycle, 0: it has none.
  std::string BoardFile(const std::string& name) const { return folder_ + "/" + name + ".board"; }
  std::vector<std::string> Module(const std::string& name, int hz) const;

 private:
  std::string folder_;
  std::string config_file_;
  std::vector<std::string> names_;
};

// `command = [...]` for the config.
std::string CommandKey(const std::vector<std::string>& argv);

// Ends the benchmark unless the switch is done.
void MustBeDone(const SwitchResult& result);

}  // namespace musher::benchmark
