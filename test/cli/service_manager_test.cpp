#include "musher/cli/start/service_manager.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <vector>

#include "musher/test/cli/notify_socket.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::cli::service_manager_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

class Service : public ::testing::Test {
 protected:
  Service() {
    machine_.phase = Phase::kRunning;
    machine_.state = kActive;
    for (KnownActuator& actuator : machine_.actuators) actuator.presence = Presence::kPresent;
  }

  void Listen() { socket_ = std::make_unique<NotifySocket>(folder_ / "notify"); }
  // The messages sent within a second without any event.
  std::vector<std::string> ReceivedInASecond() {
    const ServiceManager manager(loop_, config_);
    network_.RunFor(std::chrono::seconds(1));
    return socket_->Take();
  }

  const TempFolder folder_;
  const MachineConfig config_ = RobotConfig();
  Machine machine_ = MakeMachine(config_);
  transport::sim::Network network_{1};
  const std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");
  transport::EventLoop& loop_ = node_->loop();
  std::unique_ptr<NotifySocket> socket_;
};

TEST_F(Service, IsReadyOnceTheMachineIsUsable) {
  Listen();
  ServiceManager manager(loop_, config_);
  EXPECT_THAT(socket_->Take(), IsEmpty());
  manager.StartUpEnded({true, "the machine is Active"});
  EXPECT_THAT(socket_->Take(), ElementsAre("READY=1"));
}

TEST_F(Service, ReportsWhyTheStartFailedAndIsNotReady) {
  Listen();
  ServiceManager manager(loop_, config_);
  machine_.phase = Phase::kFailed;
  manager.Update(machine_);
  manager.StartUpEnded({false, "start-up failed: legs\nare gone"});
  manager.Update(machine_);
  EXPECT_THAT(socket_->Take(), ElementsAre("STATUS=start-up failed: legs are gone"));
}

TEST_F(Service, SendsTheStateInWordsWheneverTheyChange) {
  Listen();
  ServiceManager manager(loop_, config_);
  manager.Update(machine_);
  manager.Update(machine_);
  EXPECT_THAT(socket_->Take(), ElementsAre("STATUS=Active, 2 actuators"));
  machine_.state = kLowPower;
  manager.Update(machine_);
  EXPECT_THAT(socket_->Take(), ElementsAre("STATUS=LowPower, 2 actuators"));
}

TEST_F(Service, DoesNotStopWhenTheMachineIsTakenDownToStartAgain) {
  Listen();
  ServiceManager manager(loop_, config_);
  manager.StartsAgain();
  machine_.phase = Phase::kStopping;
  manager.Update(machine_);
  EXPECT_THAT(socket_->Take(), ElementsAre("STATUS=stopping, Active, 2 actuators"));
}

TEST_F(Service, SendsOnceThatTheMachineIsTakenDownAndHowLongThatMayTake) {
  Listen();
  ServiceManager manager(loop_, config_);
  machine_.phase = Phase::kStopping;
  manager.Update(machine_);
  machine_.phase = Phase::kStopped;
  manager.Update(machine_);
  EXPECT_THAT(socket_->Take(), ElementsAre("STOPPING=1\nEXTEND_TIMEOUT_USEC=15000000",
                                           "STATUS=stopping, Active, 2 actuators",
                                           "STATUS=stopped, Active, 2 actuators"));
}

TEST_F(Service, SendsThatAnotherControllerLeadsTheMachineNow) {
  Listen();
  ServiceManager manager(loop_, config_);
  manager.Fenced("process 7 leads");
  EXPECT_THAT(socket_->Take(), ElementsAre("STOPPING=1", "STATUS=process 7 leads"));
}

TEST_F(Service, ServesItsWatchdogThreeTimesInAPeriod) {
  Listen();
  setenv("WATCHDOG_USEC", "900000", 1);
  EXPECT_THAT(ReceivedInASecond(), ElementsAre("WATCHDOG=1", "WATCHDOG=1", "WATCHDOG=1"));
  setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  EXPECT_EQ(ReceivedInASecond().size(), 3U);
}

TEST_F(Service, PingsTheWatchdogOfTheLauncherItsParent) {
  Listen();
  setenv("WATCHDOG_USEC", "900000", 1);
  setenv("WATCHDOG_PID", std::to_string(getppid()).c_str(), 1);
  EXPECT_EQ(ReceivedInASecond().size(), 3U);
}

TEST_F(Service, DoesNotPingTheWatchdogOfAnotherProcess) {
  Listen();
  setenv("WATCHDOG_USEC", "900000", 1);
  setenv("WATCHDOG_PID", std::to_string(getpid() + 1).c_str(), 1);
  EXPECT_THAT(ReceivedInASecond(), IsEmpty());
}

TEST_F(Service, HasNoWatchdogUnlessTheUnitHas) {
  Listen();
  EXPECT_THAT(ReceivedInASecond(), IsEmpty());
}

TEST_F(Service, DoesNothingWithoutAServiceManager) {
  unsetenv("NOTIFY_SOCKET");
  setenv("WATCHDOG_USEC", "900000", 1);
  setenv("WATCHDOG_PID", std::to_string(getppid()).c_str(), 1);
  ServiceManager manager(loop_, config_);
  EXPECT_EQ(std::getenv("WATCHDOG_PID"), std::to_string(getppid()));
  Listen();  // too late
  manager.StartUpEnded({true, ""});
  manager.Update(machine_);
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(socket_->Take(), IsEmpty());
}

// The received messages, without heartbeats.
std::vector<std::string> TakeReceived(NotifySocket& socket) {
  std::vector<std::string> messages = socket.Take();
  std::erase(messages, "WATCHDOG=1");
  return messages;
}

// It used to stand still until systemd had read something, and the machine with it.
TEST_F(Service, DoesNotWaitForAServiceManagerThatReadsNothing) {
  Listen();
  setenv("WATCHDOG_USEC", "3000", 1);
  ServiceManager manager(loop_, config_);
  network_.RunFor(std::chrono::seconds(5));  // far more heartbeats than a socket accepts
  manager.Update(machine_);
  manager.StartUpEnded({true, "the machine is Active"});
  machine_.state = kLowPower;
  manager.Update(machine_);
  manager.Fenced("process 7 leads");
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(TakeReceived(*socket_), IsEmpty()) << "there was no room for it";
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(TakeReceived(*socket_),
              ElementsAre("READY=1", "STOPPING=1", "STATUS=process 7 leads"))
      << "the latest of each kind";
  network_.RunFor(Milliseconds(2));
  EXPECT_THAT(socket_->Take(), Contains("WATCHDOG=1")) << "shows life again";
}

TEST_F(Service, SendsLaterWhatFoundNoRoomAlsoWithoutAWatchdog) {
  Listen();
  ServiceManager manager(loop_, config_);
  for (int i = 0; i < 5000; ++i) {
    machine_.state = i % 2 == 0 ? kActive : kLowPower;
    manager.Update(machine_);
  }
  manager.StartUpEnded({true, "the machine is LowPower"});
  EXPECT_THAT(socket_->Take(), Not(Contains("READY=1")));
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(socket_->Take(), ElementsAre("STATUS=LowPower, 2 actuators", "READY=1"));
}

TEST_F(Service, TriesOnceMoreAtItsEndWhatFoundNoRoom) {
  Listen();
  {
    ServiceManager manager(loop_, config_);
    for (int i = 0; i < 5000; ++i) {
      machine_.state = i % 2 == 0 ? kActive : kLowPower;
      manager.Update(machine_);
    }
    manager.Fenced("process 7 leads");
    EXPECT_THAT(socket_->Take(), Not(Contains("STOPPING=1")));
  }
  EXPECT_THAT(socket_->Take(), ElementsAre("STOPPING=1", "STATUS=process 7 leads"));
}

TEST_F(Service, AcceptsASocketWithoutAFile) {
  socket_ = std::make_unique<NotifySocket>("@musher-test-" + std::to_string(getpid()));
  ServiceManager manager(loop_, config_);
  manager.StartUpEnded({true, "the machine is Active"});
  EXPECT_THAT(socket_->Take(), ElementsAre("READY=1"));
}

TEST_F(Service, DescribesAMachineByItsPhaseItsStateAndItsMissingActuators) {
  EXPECT_EQ(StatusWords(config_, machine_), "Active, 2 actuators");
  machine_.actuators[1].presence = Presence::kStarting;
  EXPECT_EQ(StatusWords(config_, machine_), "Active, 1 of 2 actuators");
  machine_.phase = Phase::kStarting;
  machine_.state = kSelfCheck;
  EXPECT_EQ(StatusWords(config_, machine_), "starting, SelfCheck, 1 of 2 actuators");
  machine_.phase = Phase::kRunning;
  machine_.state = kProtected;
  for (KnownActuator& actuator : machine_.actuators)
    actuator.fault = ActuatorFault{kCodeNetError, "gone"};
  EXPECT_EQ(StatusWords(config_, machine_), "Protected, degraded: legs, eyes");
}

}  // namespace musher::cli::service_manager_test
