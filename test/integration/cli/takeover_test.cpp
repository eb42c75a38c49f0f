// A second controller beside a living one: refused, or in its place.

#include <signal.h>

#include <sstream>

#include "musher/base/host.hpp"
#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::testing::takeover_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Takeover : public MachineByCli {
 protected:
  void Start() {
    first_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(first_->LineWith("eyes: Active done"), "");
    before_ = AwaitStatus(AllHaveArrived);
    leader_ = "process " + std::to_string(before_["pid"].get<int>());
  }
  // The same machine, led from another folder from now on.
  void MoveToOtherFolder() const { Replace("state_dir = \"state\"", "state_dir = \"other\""); }
  static Ended TakeOver(const std::string& config) {
    return Musher({"up", config, "--takeover", "--detach"});
  }
  // Another controller leads the same processes in the same states. It may meet those of stage 2
  // only after it has said that the machine is up.
  void ExpectAdopted() const {
    const auto after = AwaitStatus(AllHaveArrived);
    SCOPED_TRACE(after.dump());
    EXPECT_NE(after["pid"], before_["pid"]);
    EXPECT_GT(after["epoch"], before_["epoch"]);
    for (const char* actuator : {"legs", "voice", "eyes"}) {
      EXPECT_EQ(after["actuators"][actuator]["pid"], before_["actuators"][actuator]["pid"]);
      EXPECT_EQ(after["actuators"][actuator]["state"], "Active");
    }
  }

  std::unique_ptr<Process> first_;
  nlohmann::json before_;
  std::string leader_;
};

TEST_F(Takeover, IsTheWayOutOfARefusalThatNamesTheLivingController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  for (const bool other_folder : {false, true}) {
    if (other_folder) MoveToOtherFolder();
    const Ended second = Musher({"up", config_});
    EXPECT_EQ(second.exit, 2);
    EXPECT_THAT(second.err, AllOf(HasSubstr(leader_), HasSubstr("--takeover replaces it")));
    if (other_folder) {
      EXPECT_THAT(second.err, HasRefusal(Refusal::kNameTaken));
    }
  }
  EXPECT_EQ(Status(), before_);  // it was not disturbed
}

TEST_F(Takeover, EndsTheFirstWhichReportsWhyAndKeepsItsActuators) {
  ASSERT_NO_FATAL_FAILURE(Start());
  Process second(Command({"up", config_, "--takeover"}));
  EXPECT_NE(second.LineWith("the machine is adopted in Active"), "");
  const Ended first = first_->Wait();
  EXPECT_EQ(first.exit, 1);
  const std::string who = "process " + std::to_string(Status()["pid"].get<int>());
  EXPECT_THAT(first.err, HasSubstr("another controller, " + who + " of this host, leads"));
  EXPECT_THAT(first.err, HasSubstr("this controller exits, the actuators keep running\n"));
  EXPECT_THAT(first.out, HasSubstr("this controller (epoch 1) releases control"));
  ExpectAdopted();
  second.Signal(SIGINT);
  EXPECT_EQ(second.Wait().exit, 0);
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(Takeover, EndsAControllerThatLeadsFromAnotherFolder) {
  ASSERT_NO_FATAL_FAILURE(Start());
  MoveToOtherFolder();
  const Ended second = TakeOver(config_);
  EXPECT_EQ(second.exit, 0) << second.err;
  EXPECT_EQ(first_->Wait().exit, 1);
  ExpectAdopted();
  EXPECT_EQ(Musher({"up", config_}).exit, 2);  // the name is the second's now
}

// That controller has ended before it could say so; its folder says it.
TEST_F(Takeover, FromAnotherFolderHoldsTheStopThatIsEngagedThere) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Musher({"estop", "it", "smokes"}).exit, 0);
  MoveToOtherFolder();
  TakeOver(config_);
  EXPECT_THAT(ReadFile(folder_ / "other/controller.log"),
              HasSubstr("an emergency stop is engaged in " + (folder_ / "state")));
  EXPECT_EQ(Status()["emergency_stop"]["reason"], "it smokes");
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 1);
  EXPECT_EQ(Musher({"estop", "--release"}).exit, 0);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
}

TEST_F(Takeover, FromAnotherFolderSwitchesNothingOnAfterTheStopThatWasReleasedThere) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Musher({"estop"}).exit, 0);
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  MoveToOtherFolder();
  ASSERT_EQ(TakeOver(config_).exit, 0);
  EXPECT_THAT(
      ReadFile(folder_ / "other/controller.log"),
      HasSubstr("no state was requested since the last emergency stop in " + (folder_ / "state")));
  const pid_t legs = before_["actuators"]["legs"]["pid"];
  kill(legs, SIGKILL);
  const auto restarted = AwaitStatus([legs](const nlohmann::json& status) {
    const nlohmann::json& now = status["actuators"]["legs"];
    return now["pid"] != legs && now["state"] == "SelfCheck" && now["target"].is_null();
  });
  EXPECT_EQ(restarted["actuators"]["legs"]["degraded"], true) << restarted;
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  EXPECT_EQ(Status()["actuators"]["legs"]["state"], "Active");
}

// A process of another user holds the name of the controller: it is neither trusted nor signalled.
TEST_F(Takeover, OfANameThatAnotherUserHoldsLeadsBesideThatProcess) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  const std::string name =
      NameLock::NameOf(transport::TestDomain(), name_space_, "musher/controller");
  Process holder({"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "env",
                  "PATH=/usr/bin:/bin", "python3", "-c",
                  "import socket; s = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM); "
                  "s.bind('\\0musher/" +
                      name + "'); print('holds', flush=True); \nwhile True: s.recv(99)"});
  if (holder.LineWith("holds") == "") GTEST_SKIP() << "no python3 for another user here";
  const Ended plain = Musher({"up", config_, "--detach"});
  EXPECT_EQ(plain.exit, 2);
  EXPECT_THAT(plain.err, AllOf(HasRefusal(Refusal::kNameHeld), HasSubstr("of user 65534")));
  const Ended taken = TakeOver(config_);
  EXPECT_EQ(taken.exit, 0) << taken.err;
  AwaitStatus(AllHaveArrivedIn("Active"));
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
  const Ended stop = Musher({"estop"});
  EXPECT_EQ(stop.exit, 0) << stop.err;
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_EQ(kill(holder.pid(), 0), 0) << "it was not signalled";
}

// Both are called robot.toml, as every example is, in one namespace and one domain.
TEST_F(Takeover, NeverEndsTheControllerOfAnotherMachine) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string file = OtherRobot("", name_space_, "../state");
  for (const char* state_dir : {"../state", "own"}) {  // the same folder, and one of its own
    OtherRobot("", name_space_, state_dir);
    const Ended plain = Musher({"up", file});
    EXPECT_EQ(plain.exit, 2);
    EXPECT_THAT(plain.err, Not(HasSubstr("--takeover")));
    const Ended second = TakeOver(file);
    EXPECT_EQ(second.exit, 2);
    EXPECT_THAT(second.err,
                AllOf(HasSubstr(leader_), HasSubstr("another machine, robot of " + config_),
                      HasSubstr("this one"), HasSubstr("robot of " + file)));
    if (state_dir == std::string("own")) {
      EXPECT_THAT(second.err, HasRefusal(Refusal::kLeadsOtherMachine));
    }
  }
  EXPECT_EQ(Status(), before_);  // it was not disturbed
}

TEST_F(Takeover, RobotsOfOneNameInTwoNamespacesDoNotMeet) {
  setenv("XDG_STATE_HOME", (folder_ / "xdg").c_str(), 1);
  Drop("state_dir = \"state\"\n");
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string file = OtherRobot("", name_space_ + "_b", "");
  const Ended second = TakeOver(file);
  EXPECT_EQ(second.exit, 0) << second.err;
  EXPECT_EQ(Status(), before_);
  EXPECT_EQ(Musher({"down", "--namespace", name_space_ + "_b"}).exit, 0);
  EXPECT_EQ(Status(), before_);
}

// Each command that meets it gives the cause and what to do, instead of leading to the next one.
TEST_F(Takeover, AStoppedControllerIsNamedAsStoppedByEveryCommand) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t leader = before_["pid"];
  kill(leader, SIGSTOP);
  const std::string cure = "`kill -CONT " + std::to_string(leader) + "` continues it";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"status"}, {"down"}, {"down", "--without-controller"}}) {
    const Ended asked = Musher(words);
    SCOPED_TRACE(asked.err);
    EXPECT_NE(asked.exit, 0);
    EXPECT_THAT(asked.err, AllOf(HasSubstr(leader_), HasSubstr("it is stopped"), HasSubstr(cure),
                                 HasSubstr("--takeover` replaces it")));
    EXPECT_THAT(asked.err, AllOf(Not(HasSubstr("keys")), Not(HasSubstr("without one"))));
  }
  const Ended up = Musher({"up", config_});
  EXPECT_EQ(up.exit, 2);
  EXPECT_THAT(up.err, AllOf(HasSubstr(cure), HasSubstr("--takeover replaces it")));
  kill(leader, SIGCONT);
}

// These wait for a minute where a controller that runs may take as long.
TEST_F(Takeover, ARequestToAStoppedControllerIsGivenUpInSeconds) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t leader = before_["pid"];
  kill(leader, SIGSTOP);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"restart", "legs"}, {"keep", "LowPower", "--for", "5"}}) {
    const Time begun = std::chrono::steady_clock::now();
    const Ended ended = Musher(words);
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(40)) << words[0];
    EXPECT_EQ(ended.exit, 4);
    EXPECT_THAT(ended.err, HasSubstr("`kill -CONT " + std::to_string(leader) + "` continues it"));
    EXPECT_THAT(ended.err, Not(HasSubstr("restart of legs continues")));
  }
  kill(leader, SIGCONT);
}

TEST_F(Takeover, EndsAStoppedController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  kill(before_["pid"].get<pid_t>(), SIGSTOP);
  const Ended second = TakeOver(config_);
  EXPECT_EQ(second.exit, 0) << second.err;
  const Ended first = first_->Wait();
  EXPECT_EQ(first.exit, 1);
  EXPECT_THAT(first.err, HasSubstr("the controller of robot has crashed (killed by SIGKILL)"));
  ExpectAdopted();
}

// Its shell has other settings of DDS than the service that has started the robot.
TEST_F(Takeover, LeavesAControllerOfWhichItReceivesNothing) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const char* own = std::getenv("CYCLONEDDS_URI");
  const std::string before = own == nullptr ? "" : own;
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><Discovery><Tag>another</Tag></Discovery></Domain></CycloneDDS>", 1);
  const Ended second = TakeOver(config_);
  own == nullptr ? unsetenv("CYCLONEDDS_URI") : setenv("CYCLONEDDS_URI", before.c_str(), 1);
  EXPECT_EQ(second.exit, 2) << second.out;
  EXPECT_THAT(second.err, AllOf(HasSubstr(leader_ + " leads this machine and runs"),
                                HasSubstr("its CYCLONEDDS_URI is "), HasSubstr("<Tag>another"),
                                HasSubstr("`kill -KILL ")));
  EXPECT_EQ(Status(), before_);
}

TEST_F(Takeover, IsPrintedAsJson) {
  Process first(Command({"up", config_, "--json"}));
  ASSERT_NE(first.LineWith(R"("kind":"start-up")"), "");
  ASSERT_EQ(TakeOver(config_).exit, 0);
  const auto fenced = Json(first.LineWith(R"("kind":"fenced")"));
  EXPECT_EQ(fenced["code"], 106);
  EXPECT_EQ(first.Wait().exit, 1);
}

TEST_F(Takeover, OfAMachineWithoutAControllerIsAnOrdinaryStart) {
  EXPECT_EQ(TakeOver(config_).exit, 0);
  EXPECT_EQ(Status()["state"], "Active");
}

}  // namespace musher::testing::takeover_test
