// The same on real DDS, with peers that are processes of their own.

#include <gmock/gmock.h>
#include <signal.h>

#include <fstream>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/link/actuator_link.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/cyberdog/extension.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/protocols/cyberdog_manager.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::testing::real_peers_test {

const std::string kPeer = BinDir() + "/protocol_peer";
constexpr const char* kLeaseMs = "1000";

std::string NameSpace() {
  return "protocols_" + std::to_string(getpid());
}

class PeerProcess : public Process {
 public:
  PeerProcess(const std::string& kind, const std::string& name)
      : Process({kPeer, kind, NameSpace(), name, kLeaseMs}) {}
};

// One link against one process.
class ARealPeer : public ::testing::TestWithParam<const char*> {
 protected:
  ARealPeer() : config_(MachineOf(1)) {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    config_.name_space = NameSpace();
    const bool ros2 = std::string(GetParam()) == "ros2";
    config_.actuators[0].protocol = ros2 ? Protocol::kRos2Lifecycle : Protocol::kCyberdog;
    config_.actuators[0].heartbeat_name = "a";
    node_ = transport::MakeDdsNode(loop_).value();
    link_ = MakeLink(
                *node_, config_, 0, [this](const Event& event) { Note(event); },
                cyberdog::Extension("").links)
                .value();
    peer_.emplace(GetParam(), "a");
  }
  bool Until(const std::function<bool()>& done) {
    return loop_.RunUntil(done, loop_.Now() + std::chrono::seconds(120));
  }
  Verdict Do(const State& target) {
    reply_.reset();
    link_->Switch({1, ++number_, target, std::chrono::seconds(60), {}, {}, status_.incarnation});
    EXPECT_TRUE(Until([&] { return reply_.has_value(); }));
    return reply_.value_or(event::Replied{}).verdict;
  }
  void Note(const Event& event) {
    if (const auto* seen = std::get_if<event::StatusSeen>(&event)) status_ = seen->report;
    if (const auto* replied = std::get_if<event::Replied>(&event)) reply_ = *replied;
    if (std::holds_alternative<event::Vanished>(event)) lost_ = true;
  }

  MachineConfig config_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<ActuatorLink> link_;
  std::optional<PeerProcess> peer_;
  ActuatorReport status_;
  std::optional<event::Replied> reply_;
  bool lost_ = false;
  CommandNumber number_ = 0;
};
INSTANTIATE_TEST_SUITE_P(, ARealPeer, ::testing::Values("ros2", "cyberdog"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST_P(ARealPeer, IsDriven) {
  ASSERT_TRUE(Until([&] { return status_.state == "SetUp"; }));
  EXPECT_EQ(Do("SelfCheck"), Verdict::kDone);
  EXPECT_EQ(Do("Active"), Verdict::kDone);
  EXPECT_EQ(Do("LowPower"), Verdict::kDone);
  EXPECT_EQ(Do("TearDown"), Verdict::kDone);
}

TEST_P(ARealPeer, IsMissedWhenItIsKilledAndItsSuccessorIsDriven) {
  ASSERT_TRUE(Until([&] { return status_.state == "SetUp"; }));
  ASSERT_EQ(Do("Active"), Verdict::kDone);
  const Incarnation first = status_.incarnation;
  peer_.reset();
  EXPECT_TRUE(Until([&] { return lost_; }));
  peer_.emplace(GetParam(), "a");
  ASSERT_TRUE(Until([&] { return status_.state == "SetUp" && status_.incarnation != first; }));
  EXPECT_EQ(Do("Active"), Verdict::kDone);
}

TEST_P(ARealPeer, HasASuccessorThatIsDrivenBeforeThePreviousProcessIsLost) {
  ASSERT_TRUE(Until([&] { return status_.state == "SetUp"; }));
  const Incarnation first = status_.incarnation;
  peer_.reset();
  peer_.emplace(GetParam(), "a");
  ASSERT_TRUE(Until([&] { return status_.state == "SetUp" && status_.incarnation != first; }));
  EXPECT_EQ(Do("Active"), Verdict::kDone);
}

// A whole machine: the controller starts the processes.
class AMachineOfRealPeers : public ::testing::Test {
 protected:
  AMachineOfRealPeers() : file_({"dog", "planner"}, kAllStates) {
    std::ofstream file(file_.path(), std::ios::app);
    file << "protocol = \"ros2_lifecycle\"\n" << Command("ros2", "planner");
  }
  std::string Command(const std::string& kind, const std::string& name) {
    return "command = [\"" + kPeer + "\", \"" + kind + "\", \"test_" + std::to_string(getpid()) +
           "\", \"" + name + "\", \"" + kLeaseMs + "\", \"faulty\"]\n";
  }
  RobotFile file_;
};

TEST_F(AMachineOfRealPeers, ComesUpSwitchesAndEndsThoughFirstRepliesAreLost) {
  ActuatorRunner<MachineActuator> dog("dog");
  dog.RegisterStateCallback([](const State&) { return kCodeOk; });
  ASSERT_TRUE(dog.Init(file_.path()));
  ASSERT_TRUE(dog.Start());
  MachineController controller({cyberdog::Extension()});
  ASSERT_TRUE(controller.Init(file_.path()));
  ASSERT_TRUE(controller.AwaitSetUp());
  EXPECT_TRUE(controller.Switch("SelfCheck").done());
  EXPECT_TRUE(controller.Switch("Active").done());
  EXPECT_TRUE(controller.Switch("LowPower").done());
  EXPECT_THAT(controller.States(), ::testing::ElementsAre(::testing::Pair("dog", "LowPower"),
                                                          ::testing::Pair("planner", "LowPower")));
  EXPECT_TRUE(controller.Switch("TearDown").done());
}

TEST(OurActuatorOnDds, IsSwitchedByACyberdogManagerAndSendsItHeartbeats) {
  const RobotFile file({"arm"}, kAllStates);
  ActuatorRunner<MachineActuator> arm("arm");
  arm.RegisterStateCallback([](const State&) { return kCodeOk; });
  ASSERT_TRUE(arm.Init(file.path()));
  ASSERT_TRUE(arm.Start());
  transport::LinuxEventLoop loop;
  const auto node = transport::MakeDdsNode(loop).value();
  CyberdogManager manager(*node, "test_" + std::to_string(getpid()), {"arm"},
                          std::chrono::seconds(60));
  const auto until = [&](const std::function<bool()>& done) {
    return loop.RunUntil(done, loop.Now() + std::chrono::seconds(120));
  };
  ASSERT_TRUE(until([&] { return manager.Ready() && manager.heartbeat_counts["arm"] >= 2; }));
  std::vector<CyberdogManager::Result> results;
  manager.SetState("Active", [&](auto r) { results = std::move(r); });
  ASSERT_TRUE(until([&] { return !results.empty(); }));
  EXPECT_EQ(results[0].code, 0);
  EXPECT_EQ(results[0].current_state, 4);
  EXPECT_EQ(arm.CurrentState(), "Active");
}

}  // namespace musher::testing::real_peers_test
