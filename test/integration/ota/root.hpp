#pragma once
// A machine of two musher-exec actuators that is started from a root, and bundles for it.

#include <signal.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "musher/test/support/machine_fixture.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::testing {

class RobotWithUpgrades : public MachineFixture {
 protected:
  RobotWithUpgrades() {
    setenv("MUSHER_OTA_ROOT", root_.c_str(), 1);
    EXPECT_EQ(Musher({"ota", "keygen", folder_ / "key"}).exit, 0);
    Make("1.0.0", {});
    const Ended init =
        Musher({"ota", "init", root_, "--from", Bundle("1.0.0"), "--key", folder_ / "key.pub"});
    EXPECT_EQ(init.exit, 0) << init.err;
  }

  // What differs from a version that is all right.
  struct Version {
    std::string check = "exit 0";        // the program of the self-check, from the slot's bin
    std::string set_up = "exit 0";       // … and that of SetUp
    std::string tear_down = "exit 0";    // … and that of TearDown
    std::string name_space{};            // another one
    std::string controller{};            // more keys of [controller]
    std::string policy{};                // more of the config
    std::size_t large_bytes = 0;         // of a file that takes its time
    std::vector<std::string> options{};  // of `musher ota bundle`
    std::string program{};               // a script instead of musher-exec
    std::string restart = "on-failure";
  };

  void Make(const std::string& version, const Version& content) const {
    const std::string built = folder_ / ("built-" + version);
    std::filesystem::create_directories(built + "/bin");
    WriteConfig(built + "/robot.toml",
                content.name_space.empty() ? name_space_ : content.name_space, content);
    std::ofstream(built + "/legs.toml")
        << "[state.SetUp]\nrun = [\"set-up\"]\n[state.SelfCheck]\nrun = [\"self-check\"]\n"
           "[state.OTA]\nrun = [\"true\"]\n[state.TearDown]\nrun = [\"tear-down\"]\n";
    if (content.large_bytes > 0) {
      std::ofstream(built + "/large") << std::string(content.large_bytes, 'x');
    }
    Script(built + "/bin/self-check", content.check);
    Script(built + "/bin/set-up", content.set_up);
    Script(built + "/bin/tear-down", content.tear_down);
    if (!content.program.empty()) Program(built + "/bin/stand-in", content.program);
    std::vector<std::string> words = {
        "ota",   "bundle",       built, "--version", version, "--key", folder_ / "key.key",
        "--out", Bundle(version)};
    words.insert(words.end(), content.options.begin(), content.options.end());
    const Ended made = Musher(words);
    EXPECT_EQ(made.exit, 0) << made.err;
  }

  std::string Bundle(const std::string& version) const { return folder_ / version; }

  Ended Install(const std::string& version) const {
    return Musher({"ota", "install", Bundle(version)});
  }
  // See testing::UpDetached().
  Ended UpDetached() const { return testing::UpDetached(root_); }
  static nlohmann::json Versions() { return Json(Musher({"ota", "status", "--json"}).out); }
  static std::string History() { return Musher({"history"}).out; }

  // "Active from b": where the machine is, and which slot it runs from.
  static std::string Where() {
    const auto status = Status();
    if (status.is_null()) return "nowhere";
    const std::string file = status["config"];
    const std::size_t slot = file.find("/slots/");
    return std::string(status["state"]) + " from " + file.substr(slot + 7, 1);
  }

  const std::string root_ = folder_ / "robot";

 private:
  static void Script(const std::string& file, const std::string& line) {
    Program(file, "#!/bin/sh\n" + line + "\n");
  }
  static void Program(const std::string& file, const std::string& text) {
    std::ofstream(file) << text;
    std::filesystem::permissions(file, std::filesystem::perms(0755));
  }

  static void WriteConfig(const std::string& path, const std::string& name_space,
                          const Version& content) {
    const std::string states = R"(["SetUp", "TearDown", "SelfCheck", "Active", "LowPower", "OTA"])";
    std::ofstream file(path);
    file << "[controller]\nname = \"dog\"\nactuators = [\"legs\", \"voice\"]\nstates = " << states
         << "\ndefault_time = 2000\ndefault_state = \"Uninitialized\"\nnamespace = \"" << name_space
         << "\"\nstate_dir = \"state\"\n"
         << content.controller;
    for (const char* actuator : {"legs", "voice"}) {
      file << "[actuator." << actuator << "]\nstates = " << states
           << "\ntimes = [30000, 20000, 20000, 20000, 20000, 20000]\ncommand = [\""
           << (content.program.empty() ? "musher-exec" : "stand-in")
           << "\", \"legs.toml\"]\ncwd = \".\"\nrestart = \"" << content.restart
           << "\"\nrestart_delay_ms = 10\nrestart_limit = 1\n";
      if (actuator == std::string("legs")) file << "critical = true\n";
      if (actuator == std::string("voice")) file << "stage = 2\n";
    }
    file << content.policy;
  }
};

}  // namespace musher::testing
