// A robot whose config has [safety] permit_ms, and a person on another host who gives the permits.

#include <gmock/gmock.h>

#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::permit_test {

using simulation::SimRobot;

constexpr Duration kPermit = Milliseconds(500);
constexpr Duration kPeriod = Milliseconds(50);
constexpr std::size_t kDock = 1;  // a host

MachineConfig Robot() {
  MachineConfig config = MachineOf(3);
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  config.permit = kPermit;
  return config;
}

simulation::Layout RobotAndDock() {
  simulation::Layout layout;
  layout.hosts = {"robot", "dock"};
  layout.host_of = PerActuator<std::size_t>(3, 0);
  layout.machine_id = "5982c7ee-0000-4000-8000-000000000001";
  return layout;
}

class ARobotThatNeedsPermits : public ::testing::Test {
 protected:
  // Gives permits from the dock, until the node is dropped.
  struct Holder {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::Permit>> publisher;
    transport::LoopHandlePtr timer;
    ~Holder() {
      timer = nullptr;
      publisher = nullptr;
    }
  };

  std::unique_ptr<Holder> Hold(const std::string& machine, const std::string& id) {
    auto holder = std::make_unique<Holder>();
    const std::string name = "holder" + std::to_string(++holders_);
    robot_.hosts().Attach(name, kDock);
    holder->node = robot_.network().MakeNode(name);
    holder->publisher = transport::MakePublisher<msg::Permit>(
                            *holder->node, transport::PermitTopic(""), transport::kHeartbeatQos)
                            .value();
    holder->timer = holder->node->loop().Every(
        kPeriod, [&node = *holder->node, machine, id, publisher = holder->publisher.get()] {
          msg::Permit permit;
          permit.machine = machine;
          permit.machine_id = id;
          permit.stamp_ns = transport::ToNanoseconds(node.loop().Now());
          permit.participant = node.participant().value();
          permit.by = "alice";
          static_cast<void>(publisher->Publish(permit));
        });
    return holder;
  }
  std::unique_ptr<Holder> Hold() { return Hold("test", robot_.identity().id); }

  void Start() {
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }))
        << robot_.machine().emergency.stop.value_or(EmergencyStop{}).reason;
  }
  bool AllStopped() const {
    return std::ranges::all_of(std::array{"a", "b", "c"}, [&](const char* name) {
      const auto report = robot_.ReportOf(name);
      return report && report->emergency_stop != 0;
    });
  }
  bool NoneStopped() const {
    return std::ranges::all_of(std::array{"a", "b", "c"}, [&](const char* name) {
      const auto report = robot_.ReportOf(name);
      return report && report->emergency_stop == 0;
    });
  }

  SimRobot robot_{1, Robot(), {}, RobotAndDock()};
  int holders_ = 0;
};

TEST_F(ARobotThatNeedsPermits, MovesWhileTheyArriveAndStopsWhenTheLinkIsCut) {
  const auto holder = Hold();
  Start();
  EXPECT_EQ(robot_.machine().state, "Active");
  robot_.RunFor(std::chrono::seconds(30));
  EXPECT_TRUE(NoneStopped());
  robot_.hosts().SetHostBlocked(kDock, 0, true);
  robot_.RunFor(kPermit + kPeriod);
  EXPECT_TRUE(AllStopped());
  EXPECT_EQ(robot_.machine().emergency.stop->by, "[safety] permit_ms");
}

TEST_F(ARobotThatNeedsPermits, StopsWhenTheirProgramIsKilled) {
  auto holder = Hold();
  Start();
  holder.reset();
  robot_.RunFor(kPermit + kPeriod);
  EXPECT_TRUE(AllStopped());
}

TEST_F(ARobotThatNeedsPermits, StaysStoppedWhenTheLinkIsBackUntilAPersonReleasesIt) {
  const auto holder = Hold();
  Start();
  robot_.hosts().SetHostBlocked(kDock, 0, true);
  robot_.RunFor(std::chrono::seconds(2));
  robot_.hosts().SetHostBlocked(kDock, 0, false);
  robot_.RunFor(std::chrono::seconds(30));
  EXPECT_TRUE(AllStopped());
  robot_.ReleaseEmergencyStop();
  ASSERT_TRUE(robot_.RunUntil([&] { return NoneStopped(); }, std::chrono::seconds(5)));
  EXPECT_TRUE(robot_.Set("Active")->done());
  robot_.RunFor(std::chrono::seconds(5));
  EXPECT_TRUE(NoneStopped());
}

TEST_F(ARobotThatNeedsPermits, DoesNotStartToMoveWithoutThem) {
  robot_.StartController();
  robot_.RunFor(std::chrono::seconds(30));
  for (const char* name : {"a", "b", "c"}) EXPECT_NE(robot_.ReportOf(name)->state, "Active");
  ASSERT_TRUE(robot_.machine().emergency.stop);
  EXPECT_EQ(robot_.machine().emergency.stop->reason, "no permit to move has arrived");
}

TEST_F(ARobotThatNeedsPermits, StopsAgainWhenTheStopIsReleasedAndNoneArrives) {
  auto holder = Hold();
  Start();
  holder.reset();
  robot_.RunFor(std::chrono::seconds(2));
  robot_.ReleaseEmergencyStop();
  robot_.RunFor(std::chrono::seconds(2));
  EXPECT_TRUE(AllStopped());
}

TEST_F(ARobotThatNeedsPermits, MovesOnNoPermitOfAnotherMachineOrOfAny) {
  const auto other_name = Hold("other", "");
  const auto other_id = Hold("test", "5982c7ee-0000-4000-8000-000000000002");
  const auto any = Hold("", "");
  robot_.StartController();
  robot_.RunFor(std::chrono::seconds(30));
  for (const char* name : {"a", "b", "c"}) EXPECT_NE(robot_.ReportOf(name)->state, "Active");
}

}  // namespace musher::testing::permit_test
