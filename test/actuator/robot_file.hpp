#pragma once
// A state config of its own for a test: its own folder, domain and namespace, so that tests run
// side by side.

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "musher/test/support/domain.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::testing {

class RobotFile {
 public:
  // `states` with 20 s each, for every actuator, but for those in `times_ms`. `more`: lines of each
  // actuator's table.
  RobotFile(const std::vector<std::string>& actuators, const std::vector<std::string>& states,
            const std::map<std::string, int>& times_ms = {}, const std::string& more = "") {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    std::ofstream file(path());
    file << "[controller]\nactuators = " << List(actuators) << "\nstates = " << List(states)
         << "\ndefault_time = 1000\ndefault_state = \"Uninitialized\"\nnamespace = \""
         << name_space() << "\"\nstate_dir = \"" << folder_ / "state"
         << "\"\n";
    for (const std::string& actuator : actuators) {
      file << "[actuator." << actuator << "]\nstates = " << List(states) << "\ntimes = [";
      for (const std::string& state : states) {
        const auto own = times_ms.find(state);
        file << (own == times_ms.end() ? 20'000 : own->second) << ", ";
      }
      file << "]\n" << more;
    }
  }

  std::string path() const { return folder_ / "robot.toml"; }
  static std::string name_space() { return "test_" + std::to_string(getpid()); }
  std::string state_dir() const { return folder_ / "state"; }

 private:
  static std::string List(const std::vector<std::string>& words) {
    std::string list;
    for (const std::string& word : words) list += (list.empty() ? "\"" : ", \"") + word + "\"";
    return "[" + list + "]";
  }

  TempFolder folder_;
};

inline const std::vector<std::string> kAllStates = {"SetUp",    "TearDown", "SelfCheck",
                                                    "Active",   "DeActive", "Protected",
                                                    "LowPower", "OTA",      "Error"};

}  // namespace musher::testing
