#pragma once
// The machine of MachineByCli with [security] and its keys, and processes that try what they can.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing {

class SecuredMachine : public MachineByCli {
 protected:
  SecuredMachine() {
    std::ofstream(config_, std::ios::app) << "[security]\nkeys = \"keys\"\n";
    unsetenv("MUSHER_IDENTITY");
    setenv("MUSHER_KEYS", keys_.c_str(), 1);
    EXPECT_EQ(Musher({"keys", "init", config_}).exit, 0);
  }
  ~SecuredMachine() override {
    KillChildren();
    unsetenv("MUSHER_KEYS");
  }

  void Start() {
    const Ended up = Musher({"up", config_, "--detach"});
    ASSERT_EQ(up.exit, 0) << up.out << up.err;
    StatusStream statuses;
    statuses.Await(AllHaveArrived);
    ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
    statuses.Await(AllHaveArrivedIn("LowPower"));
  }

  static Ended As(const std::string& identity, std::vector<std::string> words) {
    words.insert(words.end(), {"--identity", identity});
    return Musher(std::move(words));
  }
  // A process that does `actions` (see peer_program.cpp), ready; `keys` "-": without any.
  static std::unique_ptr<Process> Peer(const std::string& keys, const std::string& identity,
                                       const std::vector<std::string>& actions) {
    std::vector<std::string> argv = {BinDir() + "/security_peer",
                                     std::to_string(transport::TestDomain()), keys, identity};
    argv.insert(argv.end(), actions.begin(), actions.end());
    return std::make_unique<Process>(argv);
  }

  // A process that ignores its permissions, and receives what it can.
  static std::unique_ptr<Process> Liar(const std::string& keys, const std::string& identity,
                                       std::vector<std::string> actions) {
    actions.insert(actions.end(), {"watch", "heartbeats"});
    setenv("LD_LIBRARY_PATH", (BuildDir() + "/test/security/lying").c_str(), 1);
    auto liar = Peer(keys, identity, actions);
    unsetenv("LD_LIBRARY_PATH");
    EXPECT_EQ(liar->LineWith("ready"), "ready");
    return liar;
  }

  std::string Identity(const std::string& name, const std::string& role) const {
    EXPECT_EQ(Musher({"keys", "add", name, "--role", role}).exit, 0);
    return name;
  }

  // The machine executes commands, and its status shows their results.
  static void ExpectTheMachineIsSound() {
    StatusStream statuses;
    const auto before = statuses.Await(AllHaveArrivedIn("LowPower"));
    ASSERT_FALSE(before.is_null());
    for (const char* state : {"Active", "LowPower"}) {
      const Ended set = Musher({"set", state});
      EXPECT_EQ(set.exit, 0) << set.err;
      const auto status = statuses.Await(AllHaveArrivedIn(state));
      EXPECT_EQ(status["state"], state);
      EXPECT_EQ(status["epoch"], before["epoch"]);
      EXPECT_EQ(status["pid"], before["pid"]);
      for (const char* actuator : {"legs", "voice", "eyes"}) {
        const auto& one = status["actuators"][actuator];
        EXPECT_EQ(one["state"], state) << actuator;
        EXPECT_EQ(one["health"], "well") << actuator;
        EXPECT_EQ(one["restarts"], 0) << actuator;
      }
    }
  }

  const std::string keys_ = folder_ / "keys";
};

}  // namespace musher::testing
