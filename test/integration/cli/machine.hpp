#pragma once
// A machine of three musher-exec actuators.

#include <signal.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/test/support/machine_fixture.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::testing {

class MachineByCli : public MachineFixture {
 protected:
  MachineByCli() { Write(); }

  // What an actuator does in its states, as musher-exec reads it: "[state.Active]\nrun = [...]".
  void Does(const std::string& actuator, const std::string& toml) const {
    std::ofstream(folder_ / (actuator + ".toml")) << toml;
  }
  // In that state the actuator comes back only once it is released. It has a minute for that: on a
  // busy computer each command of a test takes seconds.
  void Blocks(const std::string& actuator, const std::string& state) const {
    Does(actuator, "[state." + state + "]\nshell = \"until [ -e " + (folder_ / "released") +
                       " ]; do sleep 0.02; done\"\n");
    GiveAMinute(actuator, state);
  }
  void Release() const { std::ofstream(folder_ / "released") << "go"; }

  // A command on a terminal, whose screen is the program's output.
  static std::vector<std::string> OnATerminal(std::vector<std::string> words) {
    std::string line = "exec";
    for (const std::string& word : Command(std::move(words))) line += " '" + word + "'";
    return {"script", "-qefc", line, "/dev/null"};
  }
  // The process that goes on to publish a stop, by what its command prints.
  static pid_t PublisherOf(const Ended& estop) {
    const std::string kept = "the stop stays published for a minute (pid ";
    const std::size_t at = estop.err.find(kept);
    EXPECT_NE(at, std::string::npos) << estop.err;
    return at == std::string::npos ? 0 : std::stoi(estop.err.substr(at + kept.size()));
  }
  static void End(pid_t publisher) {
    kill(publisher, SIGKILL);
    waitpid(publisher, nullptr, 0);
  }
  // See testing::UpDetached().
  Ended UpDetached() const { return testing::UpDetached(config_); }

  // robot.toml of another machine with the same actuators, in a folder of its own. Its name is
  // `name`, else that of its file; without `state_dir` it has the default one.
  std::string OtherRobot(const std::string& name, const std::string& name_space,
                         const std::string& state_dir) const {
    std::string toml = ReadFile(config_);
    const auto replace = [&toml](const std::string& key, const std::string& value) {
      const std::size_t at = toml.find(key + " = ");
      if (at != std::string::npos) toml.erase(at, toml.find('\n', at) + 1 - at);
      const std::string line = value.empty() ? "" : key + " = \"" + value + "\"\n";
      toml.insert(toml.find('\n') + 1, line);
    };
    replace("name", name);
    replace("namespace", name_space);
    replace("state_dir", state_dir);
    std::filesystem::create_directory(folder_ / "other");
    std::ofstream(folder_ / "other/robot.toml") << toml;
    return folder_ / "other/robot.toml";
  }
  // Without these words from now on.
  void Drop(const std::string& words) const { Replace(words, ""); }
  void Replace(const std::string& words, const std::string& by) const {
    std::string toml = ReadFile(config_);
    toml.replace(toml.find(words), words.size(), by);
    std::ofstream(config_) << toml;
  }

  const std::string config_ = folder_ / "robot.toml";

 private:
  // Where the test has given it no time of its own.
  void GiveAMinute(const std::string& actuator, const std::string& state) const {
    const std::string usual = "times = [10000, 5000, 5000, 5000, 5000, 5000]";
    std::string toml = ReadFile(config_);
    const std::size_t at = toml.find("times = ", toml.find("[actuator." + actuator + "]"));
    if (at == std::string::npos || toml.compare(at, usual.size(), usual) != 0) return;
    std::string times = "times = [";
    for (const char* one : {"SetUp", "TearDown", "SelfCheck", "Active", "LowPower", "OTA"}) {
      times += state == one ? "60000, " : one == std::string("SetUp") ? "10000, " : "5000, ";
    }
    toml.replace(at, usual.size(), times + "]");
    if (state == "TearDown" && toml.find("shutdown_budget_ms") == std::string::npos) {
      toml.insert(toml.find('\n') + 1, "shutdown_budget_ms = 60000\n");
    }
    std::ofstream(config_) << toml;
  }
  void Write() const {
    const std::string states = R"(["SetUp", "TearDown", "SelfCheck", "Active", "LowPower", "OTA"])";
    std::ofstream file(config_);
    file << "[controller]\nname = \"robot\"\nactuators = [\"legs\", \"voice\", \"eyes\"]\nstates = "
         << states << "\ndefault_time = 2000\ndefault_state = \"Uninitialized\"\nnamespace = \""
         << name_space_ << "\"\nstate_dir = \"state\"\n";
    for (const char* actuator : {"legs", "voice", "eyes"}) {
      file << "[actuator." << actuator << "]\nstates = " << states
           << "\ntimes = [10000, 5000, 5000, 5000, 5000, 5000]\ncommand = [\"musher-exec\", \""
           << (folder_ / actuator) << ".toml\"]\n";
      Does(actuator, "[state.OTA]\nrun = [\"true\"]\n");
      if (actuator == std::string("legs")) file << "critical = true\n";
      if (actuator == std::string("eyes")) file << "stage = 2\nafter = [\"legs\"]\n";
    }
    file << "[capability.guide]\ndescription = \"shows the way\"\nactuators = [\"legs\", "
            "\"eyes\"]\n[capability.talk]\nactuators = [\"voice\"]\nstates = [\"Active\", "
            "\"LowPower\"]\n[capability.jump]\nactuators = [\"legs\"]\nmin_battery = 50\n";
  }
};

}  // namespace musher::testing
