// ROS 2 nodes that the controller has not started: their exit, two of one name, and one that
// another client has finalized. The peers have the lease of a ROS 2 process, 10 s.

#include "musher/test/contract/plain_lifecycle_manager.hpp"
#include "musher/test/integration/foreign/mixed_machine.hpp"

namespace musher::testing::started_by_hand_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

class StartedByHand : public MachineByCli {
 protected:
  StartedByHand() {
    const std::string states =
        R"(["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower"])";
    std::ofstream(config_) << "[controller]\nname = \"robot\"\nactuators = [\"planner\"]\nstates = "
                           << states
                           << "\ndefault_time = 2000\ndefault_state = \"Uninitialized\"\nnamespace "
                              "= \""
                           << name_space_
                           << "\"\nstate_dir = \"state\"\n[actuator.planner]\nstates = " << states
                           << "\ntimes = [20000, 20000, 20000, 20000, 20000, 20000]\nprotocol = "
                              "\"ros2_lifecycle\"\ncritical = true\n";
  }
  std::vector<std::string> Node() const {
    return {BinDir() + "/protocol_peer", "ros2", name_space_, "planner", "10000"};
  }
  void Start() const {
    const Ended up = UpDetached();
    ASSERT_EQ(up.exit, 0) << up.out << up.err;
    ASSERT_EQ(Status()["state"], "Active");
  }
};

// It was shown as Active for 10 s, critical or not.
TEST_F(StartedByHand, ANodeThatIsKilledIsKnownToBeDeadAtOnce) {
  const Process node(Node());
  ASSERT_NO_FATAL_FAILURE(Start());
  StatusStream statuses;  // it has begun before: a command takes seconds on a busy computer
  statuses.Await(AllHaveArrivedIn("Active"));
  const auto begun = std::chrono::steady_clock::now();
  node.Signal(SIGKILL);
  const auto status = statuses.Await([](const nlohmann::json& now) {
    return now["actuators"]["planner"]["presence"] == "lost" && now["state"] == "Protected";
  });
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(9));
  EXPECT_THAT(status["actuators"]["planner"]["message"].get<std::string>(),
              HasSubstr("its process " + std::to_string(node.pid()) + " ended"));
  EXPECT_EQ(Musher({"down"}).exit, 1) << "it was killed in Active, without its TearDown";
}

TEST_F(StartedByHand, TwoNodesOfOneNameAreReportedAsThatAndNoneIsKilled) {
  const Process first(Node());
  ASSERT_NO_FATAL_FAILURE(Start());
  const Process second(Node());
  const auto status = AwaitStatus(
      [](const nlohmann::json& now) { return now["actuators"]["planner"]["degraded"] == true; });
  EXPECT_THAT(status["actuators"]["planner"]["message"].get<std::string>(),
              AllOf(HasSubstr("two nodes /" + name_space_ + "/planner: process " +
                              std::to_string(first.pid())),
                    HasSubstr("and process " + std::to_string(second.pid()))));
  EXPECT_EQ(status["state"], "Active");
  second.Signal(SIGTERM);
  AwaitStatus(
      [](const nlohmann::json& now) { return now["actuators"]["planner"]["degraded"] == false; });
  const std::string history = Musher({"history"}).out;
  EXPECT_THAT(history, AllOf(HasSubstr("two nodes /"), Not(HasSubstr("restart"))));
  EXPECT_EQ(kill(first.pid(), 0), 0);
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

class Finalized : public MixedMachine {
 protected:
  void Finalize() {
    ASSERT_EQ(UpDetached().exit, 0);
    PlainParticipant person(transport::TestDomain());
    PlainLifecycleClient planner(person, name_space_ + "/planner");
    constexpr std::uint8_t kActiveShutdown = 7;
    ASSERT_EQ(planner.ChangeState(kActiveShutdown), true);
  }
};

TEST_F(Finalized, ByAnotherClientANodeStaysDownAndSaysWhatBringsItBack) {
  ASSERT_NO_FATAL_FAILURE(Finalize());
  AwaitStatus([](const nlohmann::json& now) {
    return now["actuators"]["planner"]["message"].get<std::string>().find(
               "musher restart planner") != std::string::npos;
  });
  EXPECT_THAT(Started("planner"), SizeIs(1));
  EXPECT_EQ(Musher({"restart", "planner"}).exit, 0);
  EXPECT_EQ(Actuator("planner")["state"], "Active");
}

TEST_F(Finalized, ByAnotherClientANodeIsRestartedIfItsConfigSaysSo) {
  Config("planner", "restart_finalized = true\n");
  ASSERT_NO_FATAL_FAILURE(Finalize());
  AwaitStatus([this](const nlohmann::json& now) {
    return AllHaveArrived(now) && now["actuators"]["planner"]["pid"] != Started("planner").front();
  });
  EXPECT_THAT(Started("planner"), SizeIs(2));
}

}  // namespace musher::testing::started_by_hand_test
