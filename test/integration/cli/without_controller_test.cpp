// A controller is killed, and its actuators run on: they are seen, and can be ended.

#include <signal.h>

#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::testing::without_controller_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class WithoutController : public MachineByCli {
 protected:
  void StartAndKillTheController() {
    ASSERT_EQ(UpDetached().exit, 0);
    before_ = AwaitStatus(AllHaveArrived);
    const pid_t controller = before_["pid"];
    kill(controller, SIGKILL);
    waitpid(controller, nullptr, 0);
  }
  std::string ProcessOf(const std::string& actuator) const {
    return actuator + " (pid " + std::to_string(before_["actuators"][actuator]["pid"].get<int>()) +
           ")";
  }
  // In legs.log, where its TearDown is written down.
  void ReportsItsTearDown() const {
    Does("legs", "[state.TearDown]\nshell = \"echo torn >> " + (folder_ / "torn") + "\"\n");
  }
  void DropEyes() const {
    Replace("\"legs\", \"voice\", \"eyes\"]\nstates", "\"legs\", \"voice\"]\nstates");
    std::string toml = ReadFile(config_);
    const std::size_t eyes = toml.find("[actuator.eyes]");
    toml.erase(eyes, toml.find("[capability.guide]") - eyes);
    toml.replace(toml.find("actuators = [\"legs\", \"eyes\"]"), 28, "actuators = [\"legs\"]");
    std::ofstream(config_) << toml;
  }
  bool LegsWereTornDown() const { return std::filesystem::exists(folder_ / "torn"); }

  nlohmann::json before_;
};

TEST_F(WithoutController, TheRunningActuatorsAreListedFromWhatTheyLatched) {
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  // It looks for a second at most, since a person waits: on a busy computer at times in vain.
  Ended status;
  nlohmann::json json;
  Until([&] {
    status = Musher({"status"});
    json = Json(Musher({"status", "--json"}).out);
    return status.out.find("Active") != std::string::npos &&
           json["actuators"]["voice"]["state"] == "Active";
  });
  EXPECT_EQ(status.exit, 3);
  EXPECT_THAT(status.out, AllOf(HasSubstr("legs"), HasSubstr("Active")));
  EXPECT_THAT(status.err, AllOf(HasSubstr("no controller in namespace"),
                                HasSubstr(ProcessOf("legs")), HasSubstr(ProcessOf("eyes")),
                                HasSubstr("run without one: `musher up` with their config"),
                                HasSubstr("`musher down --without-controller` stops them")));
  EXPECT_EQ(json["actuators"]["voice"]["state"], "Active");
  EXPECT_EQ(json["actuators"]["voice"]["pid"], before_["actuators"]["voice"]["pid"]);
}

// `down` named it as one that still runs.
TEST_F(WithoutController, AnActuatorThatWasKilledIsNotListedThoughItsStatusLasts) {
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  kill(before_["actuators"]["eyes"]["pid"].get<pid_t>(), SIGKILL);
  Ended status;
  Until([&] {
    status = Musher({"status"});
    return status.err.find(ProcessOf("legs")) != std::string::npos;
  });
  EXPECT_THAT(status.err, Not(HasSubstr(ProcessOf("eyes"))));
}

TEST_F(WithoutController, DownTearsTheActuatorsDownAndEndsTheirProcesses) {
  ReportsItsTearDown();
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  const Ended down = Musher({"down", "--without-controller"});
  EXPECT_EQ(down.exit, 0) << down.out << down.err;
  EXPECT_THAT(down.out, HasSubstr("torn down, exited"));
  EXPECT_TRUE(LegsWereTornDown());
  EXPECT_TRUE(AwaitNoChildren());
  EXPECT_EQ(Musher({"down", "--without-controller"}).exit, 3);
}

TEST_F(WithoutController, DownKillsWhatStandsStill) {
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  kill(before_["actuators"]["legs"]["pid"].get<pid_t>(), SIGSTOP);
  const Ended down = Musher({"down", "--without-controller", "--timeout", "10"});
  EXPECT_EQ(down.exit, 1) << down.out << down.err;
  EXPECT_THAT(down.out, HasSubstr("exited without TearDown, after SIG"));
  EXPECT_THAT(down.err, HasSubstr("without TearDown what legs has switched on may still be on"));
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(WithoutController, DownLeavesALedMachineAlone) {
  ASSERT_EQ(UpDetached().exit, 0);
  const auto before = Status();
  const Ended down = Musher({"down", "--without-controller"});
  EXPECT_EQ(down.exit, 1);
  EXPECT_THAT(down.err, HasSubstr("a controller leads the actuators"));
  EXPECT_EQ(Status(), before);
}

TEST_F(WithoutController, UpOfAnotherConfigWithTheSameNamesIsRefusedWithoutAdopt) {
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  const std::string other = OtherRobot("sled", name_space_, "own");
  std::ofstream(other, std::ios::app) << "# another one\n";
  const Ended up = Musher({"up", other, "--detach"});
  EXPECT_EQ(up.exit, 2);
  EXPECT_THAT(up.err, AllOf(HasSubstr(ProcessOf("legs")),
                            HasSubstr("run already, with a different config than " + other),
                            HasRefusal(Refusal::kOtherConfigRuns)));
  EXPECT_EQ(Musher({"status"}).exit, 3);
  const Ended adopted = Musher({"up", other, "--detach", "--adopt"});
  EXPECT_EQ(adopted.exit, 0) << adopted.err;
  EXPECT_EQ(AwaitStatus(AllHaveArrived)["actuators"]["legs"]["pid"],
            before_["actuators"]["legs"]["pid"]);
}

TEST_F(WithoutController, UpOfTheMachinesOwnConfigWhichWasEditedTakesItsActuatorsOver) {
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  std::ofstream(config_, std::ios::app) << "# edited\n";
  const Ended up = Musher({"up", config_, "--detach"});
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_EQ(AwaitStatus(AllHaveArrived)["actuators"]["legs"]["pid"],
            before_["actuators"]["legs"]["pid"]);
}

TEST_F(WithoutController, AnActuatorThatTheConfigHasNoLongerIsNamedUntilItIsEnded) {
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  DropEyes();
  ASSERT_EQ(UpDetached().exit, 0);
  // The status of such an actuator is awaited for 300 ms, on a busy computer at times in vain.
  Ended status;
  Until([&status] {
    status = Musher({"status"});
    return !status.err.empty();
  });
  EXPECT_EQ(status.exit, 0);
  EXPECT_THAT(status.err,
              HasSubstr(ProcessOf("eyes") + " runs in this namespace and is not in " + config_));
  EXPECT_TRUE(Until([] { return Status()["unlisted"]["eyes"]["state"] == "Active"; }));
  EXPECT_TRUE(Until([] {
    return Musher({"history"}).out.find("does not list it: it is not controlled") !=
           std::string::npos;
  }));
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 1);
  EXPECT_THAT(down.err, HasSubstr(ProcessOf("eyes") + " still runs in this namespace"));
  EXPECT_EQ(Musher({"down", "--without-controller"}).exit, 0);
  EXPECT_TRUE(AwaitNoChildren());
}

// It hangs, so no status of it is received: `down` said nothing of it.
TEST_F(WithoutController, AnActuatorThatHangsIsNamedByDownUntilItIsEnded) {
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  DropEyes();
  ASSERT_EQ(UpDetached().exit, 0);
  kill(before_["actuators"]["eyes"]["pid"].get<pid_t>(), SIGSTOP);
  ASSERT_TRUE(Until([] { return Status()["unlisted"]["eyes"]["state"].is_null(); }));
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 1);
  EXPECT_THAT(down.err,
              HasSubstr(ProcessOf("eyes") + " holds its name and sends no status; `musher down "
                                            "--without-controller` stops what is left"));
  EXPECT_EQ(Musher({"down", "--without-controller", "--timeout", "0.5"}).exit, 1);
  EXPECT_TRUE(AwaitNoChildren());
}

// `musher estop` ended with exit code 0: the new controller does not list it.
TEST_F(WithoutController, AnActuatorThatHangsAndIsNotInTheConfigAnyMoreIsNamedByTheStop) {
  ASSERT_NO_FATAL_FAILURE(StartAndKillTheController());
  DropEyes();
  ASSERT_EQ(UpDetached().exit, 0);
  const pid_t eyes = before_["actuators"]["eyes"]["pid"];
  kill(eyes, SIGSTOP);
  const Ended stop = Musher({"estop", "--timeout", "3"});
  EXPECT_EQ(stop.exit, 1) << stop.out;
  EXPECT_THAT(stop.err, HasSubstr("eyes"));
  EXPECT_THAT(stop.out, HasSubstr("eyes   stop not confirmed"));
  kill(eyes, SIGCONT);
  const Ended again = Musher({"estop", "--timeout", "60"});
  EXPECT_EQ(again.exit, 0) << again.out << again.err;
  kill(eyes, SIGKILL);
  ASSERT_TRUE(Until([] { return Musher({"estop"}).exit == 0; })) << "its process is gone";
}

// What it had switched on may be on: without a controller, and at `musher down`, it was named.
TEST_F(WithoutController, AnActuatorThatCrashedAndIsNotInTheConfigAnyMoreIsNamedByTheStop) {
  Replace("stage = 2\n", "stage = 2\nrestart = \"no\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  before_ = AwaitStatus(AllHaveArrived);
  kill(before_["actuators"]["eyes"]["pid"].get<pid_t>(), SIGKILL);
  ASSERT_TRUE(Until([] { return Status()["actuators"]["eyes"]["presence"] == "lost"; }));
  const pid_t controller = before_["pid"];
  kill(controller, SIGKILL);
  waitpid(controller, nullptr, 0);
  DropEyes();
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended stop = Musher({"estop"});
  EXPECT_EQ(stop.exit, 1) << stop.out;
  EXPECT_THAT(stop.out, HasSubstr("eyes   its process has ended, and what it had switched on may "
                                  "be on: it was in Active"));
}

}  // namespace musher::testing::without_controller_test
