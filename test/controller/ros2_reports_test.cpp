// The contents of /diagnostics and /rosout.

#include <gmock/gmock.h>

#include "musher/base/code.hpp"
#include "musher/controller/ros2/diagnostics.hpp"
#include "musher/controller/ros2/other_vendors.hpp"
#include "musher/controller/ros2/rosout.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/transport/node_with_peers.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::ros2_reports_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Status = msg::DiagnosticStatus;

msg::MachineStatus Running() {
  msg::MachineStatus status;
  status.machine = "dog";
  status.host = "desk";
  status.phase = "running";
  status.state = "Active";
  msg::ActuatorInfo legs;
  legs.name = "legs";
  legs.state = "Active";
  legs.presence = "present";
  legs.health = "well";
  legs.host = "board";
  status.actuators = {legs};
  return status;
}

const Status& Of(const msg::DiagnosticArray& array, const std::string& name) {
  for (const Status& status : array.status) {
    if (status.name == "dog: " + name) return status;
  }
  static const Status none = {99, "", "no status of " + name, "", {}};
  return none;
}

TEST(Diagnostics, HaveTheMachineItsActuatorsAndDds) {
  const auto array = ToDiagnostics(Running(), {});
  std::vector<std::string> names;
  for (const Status& status : array.status) {
    names.push_back(status.name);
    EXPECT_EQ(status.level, Status::kOk) << status.name;
  }
  EXPECT_THAT(names, ElementsAre("dog: machine", "dog: legs", "dog: DDS"));
  EXPECT_EQ(Of(array, "legs").message, "Active");
  EXPECT_EQ(Of(array, "legs").hardware_id, "board");
}

TEST(Diagnostics, HaveALevelByTheEffectOnTheRobot) {
  const auto level = [](const std::function<void(msg::ActuatorInfo&)>& change) {
    msg::MachineStatus status = Running();
    change(status.actuators[0]);
    return Of(ToDiagnostics(status, {}), "legs").level;
  };
  EXPECT_EQ(level([](auto& legs) { legs.degraded = true; }), Status::kWarn);
  EXPECT_EQ(level([](auto& legs) { legs.degraded = legs.critical = true; }), Status::kError);
  EXPECT_EQ(level([](auto& legs) { legs.presence = "lost"; }), Status::kError);
  EXPECT_EQ(level([](auto& legs) { legs.health = "hung"; }), Status::kError);
  EXPECT_EQ(level([](auto& legs) { legs.health = "starved"; }), Status::kWarn);
  EXPECT_EQ(level([](auto& legs) { legs.presence = "absent"; }), Status::kStale);
}

TEST(Diagnostics, HaveTheReasonInTheMessage) {
  msg::MachineStatus status = Running();
  status.actuators[0].degraded = true;
  status.actuators[0].message = "joint 7 reports 81 °C";
  status.degraded = {"legs"};
  status.emergency_stop = true;
  status.emergency_stop_by = "alice";
  status.emergency_stop_reason = "smoke";
  const auto array = ToDiagnostics(status, {});
  EXPECT_EQ(Of(array, "legs").message, "Active, degraded: joint 7 reports 81 °C");
  EXPECT_EQ(Of(array, "machine").message, "Active, degraded: legs, emergency stop by alice: smoke");
  EXPECT_EQ(Of(array, "machine").level, Status::kError);
}

TEST(Diagnostics, NameTheActuatorsThatHaveNotStopped) {
  msg::MachineStatus status = Running();
  status.emergency_stop = true;
  status.emergency_stop_by = "alice";
  status.not_stopped = {"legs: the brake does not answer"};
  EXPECT_EQ(Of(ToDiagnostics(status, {}), "machine").message,
            "Active, emergency stop by alice, NOT STOPPED: legs: the brake does not answer");
}

TEST(Diagnostics, WarnOfTheRulesOfTheUserThatAreViolated) {
  msg::MachineStatus status = Running();
  status.violated_rules = {"never lamp Error", "never arm Active while legs is exited"};
  EXPECT_EQ(Of(ToDiagnostics(status, {}), "machine").level, Status::kWarn);
  EXPECT_EQ(Of(ToDiagnostics(status, {}), "machine").message,
            "Active, rule violated: never lamp Error, rule violated: never arm Active while legs "
            "is exited");
  status.phase = "failed";
  EXPECT_EQ(Of(ToDiagnostics(status, {}), "machine").level, Status::kError);
}

TEST(Diagnostics, HaveTheBatteryWhereAPolicyHasOne) {
  msg::MachineStatus status = Running();
  status.policy.active = true;
  EXPECT_EQ(Of(ToDiagnostics(status, {}), "battery").level, Status::kStale)
      << "no sample received yet";
  status.policy.battery = 80;
  EXPECT_EQ(Of(ToDiagnostics(status, {}), "battery").message, "80 %");
  status.policy.battery = 18;
  status.policy.ceiling = "Protected";
  const auto array = ToDiagnostics(status, {});
  EXPECT_EQ(Of(array, "battery").level, Status::kWarn);
  EXPECT_THAT(Of(array, "battery").message, HasSubstr("limited to Protected"));
}

TEST(Diagnostics, WarnWhileSamplesAreLost) {
  EXPECT_EQ(Of(ToDiagnostics(Running(), {7, true}), "DDS").level, Status::kWarn);
  EXPECT_EQ(Of(ToDiagnostics(Running(), {7, false}), "DDS").level, Status::kOk);
}

TEST(TheLogOfRos2, HasWarningsAndErrorsOfTheController) {
  MachineConfig config = testing::MachineOf(2);
  config.name_space = "fleet/dog1";
  config.actuators[1].critical = true;
  const auto log = [&](const std::string& kind, std::optional<ActuatorIndex> actuator,
                       std::int32_t code) {
    action::Record record;
    record.kind = kind;
    record.actuator = actuator;
    record.code = code;
    record.message = "it failed";
    return ToLog(config, record);
  };
  EXPECT_EQ(log("switch", std::nullopt, kCodeOk), std::nullopt) << "no warning";
  const auto refused = log("switch", std::nullopt, kCodeStateInvalid);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->level, msg::Log::kWarn);
  EXPECT_EQ(refused->name, "fleet.dog1.musher");
  EXPECT_THAT(refused->msg, HasSubstr("it failed"));
  const auto degraded = log("actuator", ActuatorIndex(1), kCodeFailed);
  ASSERT_TRUE(degraded);
  EXPECT_EQ(degraded->level, msg::Log::kError) << "critical";
  EXPECT_EQ(degraded->name, "fleet.dog1.musher." + config.actuators[1].name);
}

TEST(ParticipantsOfAnotherDds, AreNamedWithTheirProcess) {
  transport::sim::Network network{1};
  const auto node = network.MakeNode("robot");
  const std::vector<transport::PeerInfo> peers = {
      {1, 812, "dog1", 0x010f, ""}, {2, 813, "dog1", 0x0110, ""}, {3, 0, "", 0x0142, ""}};
  EXPECT_THAT(DescribeOtherVendors(*node, peers),
              ElementsAre("a process runs another DDS (vendor 01.42)",
                          "process 812 of host dog1 runs Fast DDS"));
}

class AnotherDds : public ::testing::Test {
 protected:
  // A process of this number, and no other.
  void Run(std::int32_t pid) {
    node_.peers = {
        {transport::ParticipantId(static_cast<std::uint64_t>(pid)), pid, "", 0x010f, ""}};
    network_.RunFor(std::chrono::seconds(6));
  }

  transport::sim::Network network_{1};
  testing::NodeWithPeers node_{network_.MakeNode("robot")};
  std::vector<std::string> status_;
  std::vector<std::string> recorded_;
  OtherVendors vendors_{node_, [this](std::vector<std::string> all) { status_ = std::move(all); },
                        [this](const std::string& one) { recorded_.push_back(one); }};
};

TEST_F(AnotherDds, IsInTheStatusWhileItsProcessExistsAndRecordedOnce) {
  Run(812);
  Run(812);
  EXPECT_THAT(status_, ElementsAre("process 812 runs Fast DDS"));
  EXPECT_THAT(recorded_, ElementsAre("process 812 runs Fast DDS"));
  node_.peers.clear();
  network_.RunFor(std::chrono::seconds(6));
  EXPECT_THAT(status_, ElementsAre());
}

// A launch file restarts a node that crashes again and again: each time it is a new participant.
TEST_F(AnotherDds, IsRecordedAlsoAfterOthersHaveComeAndGone) {
  for (std::int32_t pid = 1; pid <= 20; ++pid) Run(pid);
  EXPECT_EQ(recorded_.size(), 8U) << "a journal has room for other records";
  network_.RunFor(std::chrono::hours(1));
  Run(812);
  EXPECT_EQ(recorded_.back(), "process 812 runs Fast DDS");
}

}  // namespace musher::ros2_reports_test
