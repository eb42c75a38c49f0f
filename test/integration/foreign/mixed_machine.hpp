#pragma once
// A machine of a ROS 2 managed node ("planner") and a CyberDog module ("arm"), both without Musher,
// controlled through the real `musher` program.

#include <signal.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing {

class MixedMachine : public MachineByCli {
 protected:
  MixedMachine() { WriteMixed(); }

  // An option of the protocol_peer: "takes=LowPower:3000".
  void Peer(const std::string& actuator, const std::string& option) {
    options_[actuator].push_back(option);
    WriteMixed();
  }
  // A shell runs each command and waits for it.
  void WrapInShell() {
    wrapped_ = true;
    WriteMixed();
  }
  // Further lines of the actuator's table.
  void Config(const std::string& actuator, const std::string& lines) {
    more_[actuator] += lines;
    WriteMixed();
  }

  // The events of the peer so far: "start 4711", "configure".
  std::vector<std::string> Events(const std::string& actuator) const {
    std::ifstream file(folder_ / (actuator + ".events"));
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }
  // The processes of the peer that were started, the newest last.
  std::vector<pid_t> Started(const std::string& actuator) const {
    std::vector<pid_t> pids;
    for (const std::string& event : Events(actuator)) {
      if (event.starts_with("start ")) pids.push_back(std::stoi(event.substr(6)));
    }
    return pids;
  }
  bool AwaitEvent(const std::string& actuator, const std::string& event) const {
    return AwaitChange(folder_.path(), [&] {
      const auto events = Events(actuator);
      return std::find(events.begin(), events.end(), event) != events.end();
    });
  }
  static bool Runs(pid_t pid) {
    const std::string text = ReadFile("/proc/" + std::to_string(pid) + "/stat");
    const std::size_t bracket = text.rfind(')');
    return bracket != std::string::npos && text.substr(bracket).find(") Z") != 0;
  }

  void KillController() {
    const pid_t controller = Status()["pid"];
    kill(controller, SIGKILL);
    EXPECT_TRUE(AwaitEnd(controller));
  }
  static nlohmann::json Actuator(const std::string& name) { return Status()["actuators"][name]; }

 private:
  void WriteMixed() const {
    const std::string states =
        R"(["SetUp", "TearDown", "SelfCheck", "Active", "DeActive", "LowPower"])";
    std::ofstream file(config_);
    file << "[controller]\nname = \"robot\"\nactuators = [\"planner\", \"arm\"]\nstates = "
         << states << "\ndefault_time = 2000\ndefault_state = \"Uninitialized\"\nnamespace = \""
         << name_space_ << "\"\nstate_dir = \"state\"\n";
    for (const char* actuator : {"planner", "arm"}) {
      const bool ros2 = actuator == std::string("planner");
      file << "[actuator." << actuator << "]\nstates = " << states
           << "\ntimes = [20000, 20000, 20000, 20000, 20000, 20000]\nprotocol = \""
           << (ros2 ? "ros2_lifecycle" : "cyberdog")
           << "\"\ncommand = " << CommandOf(actuator, ros2 ? "ros2" : "cyberdog") << "\n";
      const auto more = more_.find(actuator);
      if (more != more_.end()) file << more->second;
    }
  }
  std::string CommandOf(const std::string& actuator, const std::string& kind) const {
    std::vector<std::string> words = {BinDir() + "/protocol_peer",
                                      kind,
                                      name_space_,
                                      actuator,
                                      lease_ms_,
                                      "events=" + (folder_ / (actuator + ".events"))};
    const auto options = options_.find(actuator);
    if (options != options_.end()) {
      words.insert(words.end(), options->second.begin(), options->second.end());
    }
    std::ostringstream command;
    command << (wrapped_ ? "[\"sh\", \"-c\", \"" : "[");
    for (const std::string& word : words) {
      if (wrapped_) {
        command << word << " ";
      } else {
        command << (&word == &words.front() ? "" : ", ") << "\"" << word << "\"";
      }
    }
    command << (wrapped_ ? "; exit $?\"]" : "]");
    return command.str();
  }

  const std::string lease_ms_ = "10000";  // ROS 2's default
  bool wrapped_ = false;
  std::map<std::string, std::vector<std::string>> options_;
  std::map<std::string, std::string> more_;
};

}  // namespace musher::testing
