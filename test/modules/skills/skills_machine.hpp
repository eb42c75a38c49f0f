#pragma once
// A machine of real programs around musher-skills, up as a user starts it. The configs are a copy
// of config/, which a test may change before Up().

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "musher/test/support/domain.hpp"
#include "musher/test/support/musher.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::skills {

class SkillsMachine : public ::testing::Test {
 protected:
  struct Actuator {
    std::string name;
    std::string command;     // as in TOML: ["musher-world", "scenes/rooms.toml"]
    std::string after = {};  // the same
  };

  explicit SkillsMachine(const std::vector<Actuator>& actuators,
                         const std::string& controller = "") {
    testing::AdoptOrphans();
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    setenv("XDG_STATE_HOME", (folder_ / "state").c_str(), 1);
    setenv("PATH", (BinDir() + ":" + getenv("PATH")).c_str(), 1);
    std::filesystem::copy(SourceDir() + "/config", folder_.path(),
                          std::filesystem::copy_options::recursive);
    std::string names;
    for (const Actuator& actuator : actuators) {
      names += (names.empty() ? "\"" : ", \"") + actuator.name + "\"";
    }
    std::ofstream config(Config());
    config << "[controller]\nactuators = [" << names << "]\n"
           << "states = [\"SetUp\", \"TearDown\", \"SelfCheck\", \"Active\"]\n"
           << "default_time = 120000\ndefault_state = \"Uninitialized\"\nname = \"skills\"\n"
           << controller;
    for (const Actuator& actuator : actuators) {
      config << "[actuator." << actuator.name << "]\n"
             << "states = [\"SetUp\", \"TearDown\", \"SelfCheck\", \"Active\"]\n"
             << "times = [120000, 60000, 60000, 60000]\ncwd = \".\"\ncommand = " << actuator.command
             << "\nafter = [" << actuator.after << "]\n";
    }
  }
  // Nothing that the test started outlives it.
  ~SkillsMachine() override {
    static_cast<void>(Musher({"down", "--timeout", "10"}));
    testing::KillChildren();
  }

  std::string Config() const { return folder_ / "machine.toml"; }
  void Up() const {
    const testing::Ended up = Musher({"up", Config(), "--detach"});
    ASSERT_EQ(up.exit, 0) << up.out << up.err;
  }
  static testing::Ended Musher(std::vector<std::string> words) {
    return testing::Musher(std::move(words));
  }
  // `musher skill run` with these words, within a minute.
  static testing::Ended Skill(std::vector<std::string> words) {
    words.insert(words.begin(), {"skill", "run", "--timeout", "60"});
    return Musher(std::move(words));
  }

  const TempFolder folder_;
};

}  // namespace musher::skills
