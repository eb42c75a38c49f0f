#pragma once
// A machine of three musher-exec actuators in a domain and a namespace of its own, led through the
// real `musher` program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "musher/test/integration/cli/arrival.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::testing {

class MachineByCli : public ::testing::Test {
 protected:
  MachineByCli() {
    AdoptOrphans();
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    setenv("MUSHER_NAMESPACE", name_space_.c_str(), 1);
    Write();
  }
  // Nothing that a test started outlives it.
  ~MachineByCli() override { KillChildren(); }

  // What an actuator does in its states, as musher-exec reads it: "[state.Active]\nrun = [...]".
  void Does(const std::string& actuator, const std::string& toml) const {
    std::ofstream(folder_ / (actuator + ".toml")) << toml;
  }
  // In that state the actuator comes back only once it is released.
  void Blocks(const std::string& actuator, const std::string& state) const {
    Does(actuator, "[state." + state + "]\nshell = \"until [ -e " + (folder_ / "released") +
                       " ]; do sleep 0.02; done\"\n");
  }
  void Release() const { std::ofstream(folder_ / "released") << "go"; }

  static std::vector<std::string> Command(std::vector<std::string> words) {
    words.insert(words.begin(), BinDir() + "/musher");
    return words;
  }
  // The same on a terminal, whose screen is the program's output.
  static std::vector<std::string> OnATerminal(std::vector<std::string> words) {
    std::string line = "exec";
    for (const std::string& word : Command(std::move(words))) line += " '" + word + "'";
    return {"script", "-qefc", line, "/dev/null"};
  }
  static Ended Musher(std::vector<std::string> words) {
    return RunToEnd(Command(std::move(words)));
  }
  // Up, and stage 2, too, has come as far as the machine is: a switch up is refused while an
  // actuator is still on its way.
  Ended UpDetached() const {
    Ended up = Musher({"up", config_, "--detach"});
    if (up.exit == 0) AwaitStatus(AllHaveArrived);
    return up;
  }

  static nlohmann::json Json(const std::string& text) {
    auto json = nlohmann::json::parse(text, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << text;
    return json;
  }
  // The machine's status; null when there is no controller.
  static nlohmann::json Status() {
    const Ended status = Musher({"status", "--json"});
    return status.exit == 0 ? Json(status.out) : nlohmann::json();
  }
  // The first status that is so, or the last one when none has been for 20 s.
  static nlohmann::json AwaitStatus(const std::function<bool(const nlohmann::json&)>& is_so) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    for (;;) {
      auto status = Status();
      if (status.is_object() && is_so(status)) return status;
      if (std::chrono::steady_clock::now() > deadline) {
        ADD_FAILURE() << "waited in vain for a status; the last one is " << status;
        return status;
      }
    }
  }

  // robot.toml of another machine with the same actuators, in a folder of its own. Its name is
  // `name`, else that of its file; without `state_dir` it has the default one.
  std::string OtherRobot(const std::string& name, const std::string& name_space,
                         const std::string& state_dir) const {
    std::ifstream file(config_);
    std::string toml{std::istreambuf_iterator<char>(file), {}};
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
    std::string toml;
    {
      std::ifstream file(config_);
      toml.assign(std::istreambuf_iterator<char>(file), {});
    }
    toml.replace(toml.find(words), words.size(), by);
    std::ofstream(config_) << toml;
  }

  const TempFolder folder_;
  const std::string name_space_ = "test_" + std::to_string(getpid());
  const std::string config_ = folder_ / "robot.toml";

 private:
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
