// A robot is upgraded while it runs, as a person sees it.

#include "musher/test/integration/ota/root.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::install_test {

using ::testing::HasSubstr;
using ::testing::Not;

class Upgrade : public RobotWithUpgrades {};

TEST_F(Upgrade, OfAGoodVersionIsTriedFromTheOtherSlotAndKept) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Where(), "Active from a");
  const Ended installed = Install("1.1.0");
  EXPECT_EQ(installed.exit, 0) << installed.err;
  EXPECT_THAT(installed.out, HasSubstr("version 1.1.0 runs and is kept"));
  EXPECT_EQ(Where(), "Active from b");
  const auto versions = Versions();
  EXPECT_EQ(versions["slots"]["b"]["role"], "confirmed");
  EXPECT_EQ(versions["slots"]["a"]["role"], "the one before");
  EXPECT_EQ(std::filesystem::read_symlink(root_ + "/current"), "slots/b");
  const std::string history = History();
  EXPECT_THAT(history, HasSubstr("Active → OTA"));
  EXPECT_THAT(history, HasSubstr("trial boot of slot b, version 1.1.0"));
  EXPECT_THAT(history, HasSubstr("version 1.1.0 in slot b is kept"));
}

TEST_F(Upgrade, KeepsItsControllersProcessAndItsLauncher) {
  Make("1.1.0", {});
  Process up(Command({"up", root_}));
  ASSERT_NE(up.LineWith("voice: Active done"), "");
  const int controller = Status()["pid"];
  EXPECT_EQ(Install("1.1.0").exit, 0);
  EXPECT_EQ(Status()["pid"], controller);
  EXPECT_NE(up.LineWith("version 1.1.0 in slot b is kept"), "");
  up.Signal(SIGINT);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_EQ(ended.err, "musher: taking dog down\n");
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(Upgrade, WithAFailedSelfCheckOfACriticalModuleRollsBackAndReportsWhy) {
  Make("1.1.0", {.check = "exit 9"});
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended installed = Install("1.1.0");
  EXPECT_EQ(installed.exit, 1);
  EXPECT_THAT(installed.err, HasSubstr("version 1.1.0 failed, the robot has rolled back"));
  EXPECT_THAT(installed.err, HasSubstr("critical legs: 109 (Robot: SelfCheckFailed)"));
  EXPECT_EQ(Where(), "Active from a");
  EXPECT_THAT(History(), HasSubstr("version 1.1.0 in slot b is rolled back"));
  EXPECT_EQ(Versions()["last"]["kept"], false);
}

TEST_F(Upgrade, ThatIsRolledBackDoesNotEndTheLauncher) {
  Make("1.1.0", {.check = "exit 9"});
  Process up(Command({"up", root_}));
  ASSERT_NE(up.LineWith("voice: Active done"), "");
  EXPECT_EQ(Install("1.1.0").exit, 1);
  EXPECT_NE(up.LineWith("version 1.1.0 in slot b is rolled back"), "");
  EXPECT_NE(up.LineWith("the machine is Active"), "");
  up.Signal(SIGINT);
  EXPECT_EQ(up.Wait().exit, 0);
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(Upgrade, WhoseCriticalModuleCrashesAtItsStartRollsBack) {
  Make("1.1.0", {.set_up = "kill -9 $PPID"});
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended installed = Install("1.1.0");
  EXPECT_EQ(installed.exit, 1);
  EXPECT_THAT(installed.err, HasSubstr("killed by SIGKILL"));
  EXPECT_EQ(Where(), "Active from a");
}

// A start that is refused ends `musher up`, and systemd would not try again.
TEST_F(Upgrade, WhoseControllerCannotEvenBeginRollsBack) {
  ASSERT_EQ(UpDetached().exit, 0);
  Make("1.1.0", {.policy = "[security]\nkeys = \"nowhere\"\n"});
  const Ended keyless = Install("1.1.0");
  EXPECT_EQ(keyless.exit, 1);
  EXPECT_THAT(keyless.err, HasSubstr("nowhere"));
  EXPECT_EQ(Where(), "Active from a");

  const std::string taken = "elsewhere_" + std::to_string(getpid());
  const auto leads =
      NameLock::Acquire(NameLock::NameOf(transport::TestDomain(), taken, "musher/controller"));
  ASSERT_TRUE(leads);
  Make("1.2.0", {.name_space = taken});
  const Ended second = Install("1.2.0");
  EXPECT_EQ(second.exit, 1);
  EXPECT_THAT(second.err, HasSubstr("belongs to another machine"));
  EXPECT_EQ(Where(), "Active from a");
}

TEST_F(Upgrade, ThatIsUnknownAfterItsTimeGoesBack) {
  std::ofstream(root_ + "/ota.toml") << "robot = \"dog\"\ntrial_s = 1\n";
  Make("1.1.0", {.set_up = "exec sleep 8"});
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended installed = Install("1.1.0");
  EXPECT_EQ(installed.exit, 1);
  EXPECT_THAT(installed.err, HasSubstr("it was not up within 1 s"));
  EXPECT_EQ(Where(), "Active from a");
}

// No world publishes /clock: what waits for it waits for ever.
TEST_F(Upgrade, OfARobotThatUsesTheClockTopicIsTriedAndKeptOrTakenBackWithoutAClock) {
  const std::string topic = "clock = \"topic\"\n";
  const std::string rules = "[policy.low_power]\nmotion_ids = [0]\n";
  std::ofstream(root_ + "/ota.toml") << "robot = \"dog\"\ntrial_s = 20\n";
  Make("1.1.0", {.controller = topic, .policy = rules});
  Make("1.2.0", {.set_up = "exec sleep 30", .controller = topic, .policy = rules});
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended kept = Install("1.1.0");
  EXPECT_EQ(kept.exit, 0) << kept.err;
  EXPECT_EQ(Where(), "Active from b");
  const Ended back = Install("1.2.0");
  EXPECT_EQ(back.exit, 1);
  EXPECT_THAT(back.err, HasSubstr("it was not up within 20 s"));
  EXPECT_EQ(Where(), "Active from b");
}

TEST_F(Upgrade, ThatIsRefusedLeavesTheMachineAsItWas) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  std::ofstream(Bundle("1.1.0") + "/payload/legs.toml", std::ios::app) << "# altered\n";
  const Ended installed = Install("1.1.0");
  EXPECT_EQ(installed.exit, 1);
  EXPECT_THAT(installed.err, HasSubstr("legs.toml has"));
  EXPECT_EQ(Where(), "LowPower from a");
  EXPECT_THAT(History(), Not(HasSubstr("to OTA")));
}

TEST_F(Upgrade, ThatTheDiskHasNoRoomForTakesTheMachineBackToWhereItWas) {
  Make("1.1.0", {.large_bytes = 1 << 20});
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  // To a process, files that may not grow are a full disk.
  const Ended installed = RunToEnd(
      {"sh", "-c", "ulimit -f 100; exec " + BinDir() + "/musher ota install " + Bundle("1.1.0")});
  EXPECT_EQ(installed.exit, 1);
  EXPECT_THAT(installed.err, HasSubstr("File too large"));
  EXPECT_THAT(History(), HasSubstr("LowPower → OTA"));
  EXPECT_EQ(Where(), "LowPower from a");
  EXPECT_EQ(Install("1.1.0").exit, 0);
}

// A good version was rolled back: the start-up is refused as long as the stop is engaged.
TEST_F(Upgrade, UnderAnEmergencyStopIsKeptOnceTheStopIsReleasedAndTheMachineIsUp) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"estop", "smoke"}).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  ASSERT_EQ(Install("1.1.0").exit, 0);
  EXPECT_EQ(UpDetached().exit, 1) << "it waits in SetUp";
  EXPECT_EQ(Where(), "SetUp from b");
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  ASSERT_EQ(Musher({"set", "SelfCheck"}).exit, 0);
  ASSERT_EQ(Musher({"set", "Active"}).exit, 0);
  EXPECT_TRUE(Until([] { return Versions()["last"]["kept"] == true; }));
  EXPECT_EQ(Where(), "Active from b");
}

// A good version was rolled back: the start that waits for a request counted as failed.
TEST_F(Upgrade, AfterAReleasedStopIsKeptOnceTheMachineIsUpByRequest) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"estop", "smoke"}).exit, 0);
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  Process install(Command({"ota", "install", Bundle("1.1.0")}));
  ASSERT_TRUE(Until([this] { return Where() == "SetUp from b"; }));
  AwaitStatus([](const nlohmann::json& now) { return now["phase"] == "failed"; });
  ASSERT_EQ(Musher({"set", "SelfCheck"}).exit, 0);
  ASSERT_EQ(Musher({"set", "Active"}).exit, 0);
  EXPECT_TRUE(Until([] { return Versions()["last"]["kept"] == true; }));
  EXPECT_EQ(Where(), "Active from b");
  EXPECT_EQ(install.Wait().exit, 0);
}

TEST_F(Upgrade, WithoutARunningMachineIsTriedAtTheNextStart) {
  Make("1.1.0", {});
  const Ended installed = Install("1.1.0");
  EXPECT_EQ(installed.exit, 0) << installed.err;
  EXPECT_THAT(installed.out, HasSubstr("is trial-booted at the next start: musher up " + root_));
  EXPECT_EQ(Versions()["slots"]["b"]["role"], "tried at the next start");
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Where(), "Active from b");
  EXPECT_EQ(Versions()["slots"]["b"]["role"], "confirmed");
}

TEST_F(Upgrade, HelpsARobotThatDidNotComeUp) {
  Make("1.1.0", {.check = "exit 9"});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  Make("1.2.0", {});
  std::filesystem::permissions(root_ + "/slots/a/bin/self-check", std::filesystem::perms(0644));
  EXPECT_EQ(UpDetached().exit, 1);  // 1.1.0 is tried and left, 1.0.0 cannot run its check
  EXPECT_EQ(Status()["phase"], "failed");
  const Ended installed = Install("1.2.0");
  EXPECT_EQ(installed.exit, 0) << installed.err;
  EXPECT_EQ(Where(), "Active from b");
}

TEST_F(Upgrade, CanBeTakenBackByHand) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended nothing = Musher({"ota", "rollback"});
  EXPECT_EQ(nothing.exit, 1);
  EXPECT_THAT(nothing.err, HasSubstr("no version to roll back to"));
  EXPECT_THAT(History(), Not(HasSubstr("to OTA"))) << "the robot does not lie down for that";
  EXPECT_EQ(Where(), "Active from a");
  ASSERT_EQ(Install("1.1.0").exit, 0);
  const Ended back = Musher({"ota", "rollback"});
  EXPECT_EQ(back.exit, 0) << back.err;
  EXPECT_THAT(back.out, HasSubstr("version 1.0.0 runs and is kept"));
  EXPECT_EQ(Where(), "Active from a");
}

TEST_F(Upgrade, RequestsOtaFromThePolicy) {
  Make("1.1.0", {.policy = "[policy]\n"});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  Make("1.2.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"keep", "Active", "--for", "600"}).exit, 0);
  const Ended refused = Install("1.2.0");
  EXPECT_EQ(refused.exit, 1);
  EXPECT_THAT(refused.err, HasSubstr("switch to OTA failed"));
  EXPECT_THAT(refused.err, HasSubstr("kept in Active"));
  EXPECT_EQ(Where(), "Active from b");
  ASSERT_EQ(Musher({"keep", "--end"}).exit, 0);
  const Ended installed = Install("1.2.0");
  EXPECT_EQ(installed.exit, 0) << installed.err;
  EXPECT_EQ(Where(), "Active from a");
}

// Active was requested again: the actuator that was held went up with the others.
TEST_F(Upgrade, ThatThePolicyRefusesEndsNoHold) {
  Make("1.1.0", {.policy = "[policy]\n"});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  Make("1.2.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"keep", "Active", "--for", "600"}).exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower", "voice"}).exit, 0);
  ASSERT_EQ(Status()["actuators"]["voice"]["state"], "LowPower");
  const Ended refused = Install("1.2.0");
  EXPECT_EQ(refused.exit, 1);
  EXPECT_THAT(refused.err, HasSubstr("kept in Active"));
  EXPECT_EQ(Status()["actuators"]["voice"]["state"], "LowPower");
}

TEST_F(Upgrade, IsPrintedAsJson) {
  Make("1.1.0", {});
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended installed = Musher({"ota", "install", Bundle("1.1.0"), "--json"});
  std::istringstream lines(installed.out);
  std::vector<nlohmann::json> documents;
  for (std::string line; std::getline(lines, line);) documents.push_back(Json(line));
  ASSERT_GT(documents.size(), 5U);
  EXPECT_EQ(documents.front()["step"], "check");
  EXPECT_EQ(documents.back()["outcome"], "kept");
  EXPECT_EQ(documents.back()["version"], "1.1.0");
}

}  // namespace musher::testing::install_test
