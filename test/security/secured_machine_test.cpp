// A machine with [security] has all functions of a machine without, for permitted callers.

#include "musher/test/security/secured_machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::secured_machine_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(SecuredMachine, ComesUpSwitchesStopsAndGoesDown) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ExpectTheMachineIsSound();
  const Ended estop = Musher({"estop", "smoke", "--json"});
  EXPECT_EQ(estop.exit, 0) << estop.err;
  EXPECT_EQ(Json(estop.out)["complete"], true) << estop.out;
  EXPECT_EQ(Musher({"estop", "--release"}).exit, 0);
  EXPECT_EQ(Musher({"restart", "voice"}).exit, 0);
  EXPECT_EQ(Musher({"plan", "Active"}).exit, 0);
  EXPECT_EQ(Musher({"history"}).exit, 0);
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(SecuredMachine, DrivesAnActuatorThatWasKilledAgain) {
  ASSERT_NO_FATAL_FAILURE(Start());
  kill(Status()["actuators"]["voice"]["pid"].get<pid_t>(), SIGKILL);
  AwaitStatus([](const nlohmann::json& status) {
    const auto& voice = status["actuators"]["voice"];
    return voice["restarts"] == 1 && voice["state"] == "LowPower";
  });
}

TEST_F(SecuredMachine, LetsAnObserverLookAndNothingElse) {
  ASSERT_NO_FATAL_FAILURE(Start());
  Identity("visitor", "observer");
  for (const char* query : {"status", "history"}) {
    const Ended look = As("visitor", {query});
    EXPECT_EQ(look.exit, 0) << look.err;
  }
  EXPECT_EQ(As("visitor", {"plan", "Active"}).exit, 0);
  for (const std::vector<std::string>& command : {std::vector<std::string>{"set", "Active"},
                                                  {"estop"},
                                                  {"estop", "--release"},
                                                  {"down"},
                                                  {"restart", "voice"}}) {
    const Ended refused = As("visitor", command);
    EXPECT_EQ(refused.exit, 2) << command[0] << refused.out;
    EXPECT_THAT(refused.err, HasSubstr("visitor may not do that: " + keys_));
  }
  EXPECT_EQ(Status()["state"], "LowPower");
  EXPECT_EQ(Status()["emergency_stop"]["engaged"], false);
}

TEST_F(SecuredMachine, IsTakenOverByTheNextController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto before = Status();
  kill(before["pid"].get<pid_t>(), SIGKILL);
  const Ended up = UpDetached();
  ASSERT_EQ(up.exit, 0) << up.err;
  const auto after = Status();
  EXPECT_EQ(after["epoch"], 2);
  EXPECT_EQ(after["state"], "LowPower");
  EXPECT_EQ(after["actuators"]["legs"]["pid"], before["actuators"]["legs"]["pid"]);
}

TEST_F(SecuredMachine, ReportsAnActuatorThatRunsWithoutCredentials) {
  const std::string open = folder_ / "open.toml";
  const std::string text = ReadFile(config_);
  std::ofstream(open) << text.substr(0, text.find("[security]"));
  const Process voice(
      {BinDir() + "/musher-exec", folder_ / "voice.toml", "--actuator", "voice", "--config", open});
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("controller started: epoch 1"), "");
  EXPECT_THAT(
      Musher({"status"}).out,
      HasSubstr("process " + std::to_string(voice.pid()) +
                " runs but publishes no status: check that it has the keys of this machine"));
}

// Certificates and documents are public; of the keys nothing may turn up anywhere.
TEST_F(SecuredMachine, NeverWritesKeysDown) {
  ASSERT_NO_FATAL_FAILURE(Start());
  EXPECT_EQ(Musher({"down"}).exit, 0);
  std::string secret = ReadFile(keys_ + "/voice.key");
  secret = secret.substr(secret.find('\n') + 1, 40);
  ASSERT_EQ(secret.size(), 40U);
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "state")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    EXPECT_THAT(ReadFile(entry.path()), Not(HasSubstr("PRIVATE KEY"))) << entry.path();
    EXPECT_THAT(ReadFile(entry.path()), Not(HasSubstr(secret))) << entry.path();
  }
  EXPECT_GT(files, 3);
  const Ended list = Musher({"keys", "list"});
  EXPECT_THAT(list.out, Not(HasSubstr(secret)));
}

}  // namespace musher::testing::secured_machine_test
