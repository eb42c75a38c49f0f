// A state folder without the machine's id: whose id a controller takes over.

#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "musher/base/host.hpp"
#include "musher/controller/controller.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::machine_identity_test {

using testing::kAllStates;
using testing::RobotFile;

constexpr const char* kFirst = "11111111-4f4e-4c3e-9a9a-5982c7ee0001";
constexpr const char* kSecond = "22222222-4f4e-4c3e-9a9a-5982c7ee0002";

// Two actuators that run already, of which "legs" has no command.
class FirstStart : public ::testing::Test {
 protected:
  FirstStart()
      : file_({"eyes", "legs"}, kAllStates),
        config_(*ReadConfigFile(file_.path()).config),
        node_(transport::MakeDdsNode(loop_, {}).value()),
        peer_(transport::MakeDdsNode(loop_, {}).value()) {
    config_.transport = TransportProfile::kLan;  // it listens for others before it begins
    config_.actuators[0].command = {"/opt/none"};
    config_.actuators[0].restart.policy = RestartPolicy::kNo;
  }

  void Publish(const std::string& actuator, const std::string& host, const std::string& id) {
    ActuatorReport report;
    report.state = kActive;
    report.incarnation = Incarnation(77 + publishers_.size());
    report.pid = 4711;
    report.host = host;
    report.config_hash = config_.hash;
    report.stamp = loop_.Now();
    msg::ActuatorStatus status = transport::ToMessage(actuator, report);
    status.machine = config_.name;
    status.machine_id = id;
    auto& publisher = publishers_[actuator];
    publisher =
        transport::MakePublisher<msg::ActuatorStatus>(
            *peer_, transport::ActuatorStatusTopic(config_.name_space), transport::kLatchedQos)
            .value();
    ASSERT_TRUE(publisher->Publish(status));
  }
  // The controller of a machine of this name on another host.
  void PublishRival(const std::string& id) {
    msg::ControllerHeartbeat heartbeat;
    heartbeat.machine = config_.name;
    heartbeat.machine_id = id;
    heartbeat.epoch = 9;
    heartbeat.host = "another host";
    heartbeat.pid = 7;
    heartbeat.incarnation = 7;
    heartbeat.period_ns = Duration(std::chrono::seconds(10)).count();
    rival_ =
        transport::MakePublisher<msg::ControllerHeartbeat>(
            *peer_, transport::ControllerHeartbeatTopic(config_.name_space), transport::kLatchedQos)
            .value();
    ASSERT_TRUE(rival_->Publish(heartbeat));
  }
  // Nothing in it can be opened for writing, as on a disk that is read-only.
  void CloseFolder() const {
    namespace fs = std::filesystem;
    fs::remove(config_.state_dir + "/controller.lock");
    fs::create_directories(config_.state_dir + "/controller.lock");
    fs::permissions(config_.state_dir, fs::perms(0700));
  }
  // The id of the machine, once it has begun.
  std::string IdAfterStart(bool takeover = false) {
    ControllerOptions options;
    options.by_hand = true;
    options.takeover = takeover;
    controller_ = Controller::Make(*node_, transport::TestDomain(), config_, options).value();
    EXPECT_TRUE(loop_.RunUntil([&] { return !controller_->shell().Status().machine_id.empty(); },
                               loop_.Now() + std::chrono::seconds(120)));
    return controller_->shell().Status().machine_id;
  }

  RobotFile file_;
  MachineConfig config_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Node> peer_;
  std::map<std::string, std::unique_ptr<transport::Publisher<msg::ActuatorStatus>>> publishers_;
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> rival_;
  std::unique_ptr<Controller> controller_;
};

TEST_F(FirstStart, TakesTheIdOfAnActuatorThatItDoesNotStart) {
  Publish("legs", "another host", kSecond);
  EXPECT_EQ(IdAfterStart(), kSecond);
}

TEST_F(FirstStart, TakesTheIdOfAnActuatorThatRunsHere) {
  Publish("eyes", HostId(), kFirst);
  EXPECT_EQ(IdAfterStart(), kFirst);
}

// It advised --takeover, which makes two robots of one name one machine.
TEST_F(FirstStart, BesideAControllerOfItsNameOnAnotherHostSaysThatItMayBeAnotherRobot) {
  PublishRival(kSecond);
  controller_ = Controller::Make(*node_, transport::TestDomain(), config_, {}).value();
  ASSERT_TRUE(loop_.RunUntil([&] { return controller_->shell().refused().has_value(); },
                             loop_.Now() + std::chrono::seconds(120)));
  EXPECT_THAT(*controller_->shell().refused(), testing::IsRefused(Refusal::kNameLedElsewhere));
}

// It may be that of another robot of the same name, made from the same image.
TEST_F(FirstStart, DoesNotTakeTheIdOfAnActuatorThatItStartsAndThatRunsElsewhere) {
  config_.actuators[0].host = "vision";
  HostConfig& vision = config_.hosts.emplace_back();
  vision.name = "vision";
  vision.address = "127.0.0.1";
  Publish("eyes", "another host", kFirst);
  Publish("legs", "another host", kSecond);  // by which the statuses are known to have arrived
  EXPECT_EQ(IdAfterStart(), kSecond);
}

// A disk that is read-only: the start forgot the stop, went up, and was without an id.
class ClosedFolder : public FirstStart {
 protected:
  void LeaveFolder(const std::string& id, const StoredStops& stops) {
    const MachineOrigin origin{config_.name, config_.name_space, transport::TestDomain(),
                               config_.file};
    auto store = StateStore::Open(config_.state_dir, origin);
    ASSERT_TRUE(store) << store.error().message;
    store.value().SetMachineId(id);
    ASSERT_TRUE(store.value().SaveMachineId());
    ASSERT_TRUE(store.value().SaveEmergencyStops(stops));
  }
};

TEST_F(ClosedFolder, IsReadForTheIdAndTheStops) {
  LeaveFolder(kFirst, {{{7, "alice", "smoke"}}, {}});
  CloseFolder();
  PublishRival(kSecond);
  EXPECT_EQ(IdAfterStart(), kFirst) << "another robot of this name leads nothing here";
  const Machine& machine = controller_->shell().machine();
  ASSERT_TRUE(loop_.RunUntil([&] { return machine.emergency.stop.has_value(); },
                             loop_.Now() + std::chrono::seconds(120)));
  EXPECT_EQ(machine.emergency.stop->reason, "smoke");
}

// A name alone: the start asked for --takeover, which ended the other robot's controller.
TEST_F(ClosedFolder, WithoutAnIdBeginsBesideNoControllerOfItsNameAlsoWithTakeover) {
  CloseFolder();
  PublishRival(kSecond);
  for (const bool takeover : {false, true}) {
    ControllerOptions options;
    options.takeover = takeover;
    controller_ = Controller::Make(*node_, transport::TestDomain(), config_, options).value();
    ASSERT_TRUE(loop_.RunUntil([&] { return controller_->shell().refused().has_value(); },
                               loop_.Now() + std::chrono::seconds(120)));
    EXPECT_THAT(*controller_->shell().refused(), testing::IsRefused(Refusal::kIdNotKnown));
    controller_ = nullptr;
  }
}

TEST_F(ClosedFolder, WithoutAnIdHasOneForThisRun) {
  CloseFolder();
  EXPECT_EQ(IdAfterStart().size(), std::string(kFirst).size());
}

TEST_F(ClosedFolder, TakesTheIdOfAnActuatorThatRunsHereAndNoOther) {
  CloseFolder();
  Publish("legs", "another host", kSecond);
  Publish("eyes", HostId(), kFirst);
  PublishRival(kSecond);
  EXPECT_EQ(IdAfterStart(), kFirst);
}

}  // namespace musher::machine_identity_test
