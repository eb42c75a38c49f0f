// What an actuator does beside the commands it is given, with real threads and DDS: an emergency
// stop in the middle of a callback, the loss of its controller, a work thread that hangs.

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <stdexcept>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/transport/node.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::unattended_test {

using testing::RobotFile;

constexpr auto kWaitLimit = std::chrono::seconds(120);
const std::vector<std::string> kStates = {"SetUp", "SelfCheck", "Active", "Protected", "LowPower"};

class Arm : public MachineActuator {
 public:
  explicit Arm(std::function<void(const std::string&)> on_state = {})
      : MachineActuator("arm"), on_state_(std::move(on_state)) {
    RegisterStateCallback([this](const State& state) {
      if (on_state_) on_state_(state);
      return kCodeOk;
    });
  }

  std::future<void> stopped() { return stopped_.get_future(); }
  void FailStops() { fails_ = true; }
  using MachineActuator::ReportStopTrouble;

 private:
  void OnEmergencyStop() override {
    if (fails_) throw std::runtime_error("the brake does not answer");
    stopped_.set_value();
  }

  const std::function<void(const std::string&)> on_state_;
  std::promise<void> stopped_;
  std::atomic<bool> fails_ = false;
};

// Waits for heartbeats and statuses of the robot.
class Listener {
 public:
  Listener() : node_(transport::NodeThread::Start().value()) {
    const std::string name_space = "test_" + std::to_string(getpid());
    node_->RunOnLoop([&] {
      heartbeats_ =
          transport::MakeSubscription<msg::ActuatorHeartbeat>(
              node_->node(), transport::ActuatorHeartbeatTopic(name_space),
              [this](const msg::ActuatorHeartbeat& heartbeat, const transport::SampleInfo&) {
                const std::lock_guard lock(mutex_);
                heartbeat_ = heartbeat;
                changed_.notify_all();
              },
              transport::kHeartbeatQos)
              .value();
      states_ = transport::MakeSubscription<msg::ActuatorStatus>(
                    node_->node(), transport::ActuatorStatusTopic(name_space),
                    [this](const msg::ActuatorStatus& status, const transport::SampleInfo&) {
                      const std::lock_guard lock(mutex_);
                      done_ += status.emergency_stop != 0 && status.stop_trouble.empty();
                      status_ = status;
                      changed_.notify_all();
                    },
                    transport::kLatchedFromManyQos)
                    .value();
      button_ =
          transport::MakePublisher<msg::EmergencyStop>(
              node_->node(), transport::EmergencyStopTopic(name_space), transport::kLatchedQos)
              .value();
    });
  }
  ~Listener() {
    node_->RunOnLoop([this] {
      heartbeats_.reset();
      states_.reset();
      button_.reset();
    });
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void PressTheButton() {
    node_->RunOnLoop([this] { static_cast<void>(button_->Publish({7, true, "a test", ""})); });
  }
  bool AwaitHeartbeat(const std::function<bool(const msg::ActuatorHeartbeat&)>& holds) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kWaitLimit, [&] { return holds(heartbeat_); });
  }
  // How many statuses have said that it is stopped.
  int DoneBefore() {
    const std::lock_guard lock(mutex_);
    return done_;
  }
  bool AwaitStatus(const std::function<bool(const msg::ActuatorStatus&)>& holds) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kWaitLimit, [&] { return holds(status_); });
  }

 private:
  std::shared_ptr<transport::NodeThread> node_;
  std::mutex mutex_;
  std::condition_variable changed_;
  msg::ActuatorHeartbeat heartbeat_;
  msg::ActuatorStatus status_;
  int done_ = 0;
  std::unique_ptr<transport::Subscription> heartbeats_;
  std::unique_ptr<transport::Subscription> states_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> button_;
};

TEST(Unattended, AnEmergencyStopReachesAModuleWhoseCallbackBlocks) {
  const RobotFile file({"arm"}, kStates);
  Listener listener;
  std::promise<void> begun;
  std::promise<void> release;
  ActuatorRunner<Arm> arm([&](const std::string& state) {
    if (state != "SelfCheck") return;
    begun.set_value();
    release.get_future().wait();
  });
  auto stopped = arm.stopped();
  ASSERT_TRUE(arm.Init(file.path()).ok());
  ASSERT_TRUE(arm.Start().ok());
  MachineController controller;
  ASSERT_TRUE(controller.Init(file.path()).ok());
  ASSERT_TRUE(controller.AwaitSetUp().ok());
  auto checked =
      std::async(std::launch::async, [&] { return controller.Switch("SelfCheck").done(); });
  ASSERT_EQ(begun.get_future().wait_for(kWaitLimit), std::future_status::ready);
  listener.PressTheButton();
  EXPECT_EQ(stopped.wait_for(kWaitLimit), std::future_status::ready) << "beside the callback";
  release.set_value();
  EXPECT_TRUE(checked.get());
  EXPECT_FALSE(controller.Switch("Active").done()) << "no switch up is possible";
  EXPECT_TRUE(listener.AwaitStatus([](const auto& status) { return status.emergency_stop == 7; }));
}

TEST(Unattended, AModuleWhoseStopFailsSaysSoUntilItIsDone) {
  const RobotFile file({"arm"}, kStates);
  Listener listener;
  ActuatorRunner<Arm> arm;
  arm.FailStops();
  ASSERT_TRUE(arm.Init(file.path()).ok());
  ASSERT_TRUE(arm.Start().ok());
  listener.PressTheButton();
  const auto fails = [](const msg::ActuatorStatus& status) {
    return status.emergency_stop == 7 &&
           status.stop_trouble.find("the brake does not answer") != std::string::npos;
  };
  EXPECT_TRUE(listener.AwaitStatus(fails));
  // What was posted before that is over.
  arm.ReportStopTrouble("OnEmergencyStop has failed: the brake does not answer, still");
  EXPECT_TRUE(listener.AwaitStatus(
      [](const auto& status) { return status.stop_trouble.find("still") != std::string::npos; }));
  EXPECT_EQ(listener.DoneBefore(), 0) << "no status has said that it is done";
  arm.ReportStopTrouble("");  // by another thread, which has braked
  EXPECT_TRUE(listener.AwaitStatus([](const auto& status) {
    return status.emergency_stop == 7 && status.stop_trouble.empty();
  }));
}

TEST(Unattended, AModuleThatHasLostItsControllerGoesToItsSafeStateByItself) {
  const RobotFile file({"arm"}, kStates, {}, "controller_lost_ms = 3000\n");
  Listener listener;
  ActuatorRunner<Arm> arm;
  ASSERT_TRUE(arm.Init(file.path()).ok());
  ASSERT_TRUE(arm.Start().ok());
  {
    MachineController controller;
    ASSERT_TRUE(controller.Init(file.path()).ok());
    ASSERT_TRUE(controller.AwaitSetUp().ok());
    ASSERT_TRUE(controller.Switch("SelfCheck").done());
    ASSERT_TRUE(controller.Switch("Active").done());
    EXPECT_EQ(arm.CurrentState(), "Active");
  }  // it exits without a message
  EXPECT_TRUE(listener.AwaitStatus([](const auto& status) { return status.state == "Protected"; }));
}

TEST(Unattended, AHungWorkThreadIsReportedThoughItsLoopKeepsRunning) {
  const RobotFile file({"arm"}, kStates, {}, "checkpoint_ms = 100\n");
  Listener listener;
  ActuatorRunner<Arm> arm;
  ASSERT_TRUE(arm.Init(file.path()).ok());
  ASSERT_TRUE(arm.Start().ok());
  arm.Checkpoint();  // and no more
  EXPECT_TRUE(listener.AwaitHeartbeat(
      [](const auto& heartbeat) { return heartbeat.work == msg::ActuatorHeartbeat::kWorkHung; }));
  arm.Checkpoint(MachineActuator::kNoMore);
  EXPECT_TRUE(listener.AwaitHeartbeat(
      [](const auto& heartbeat) { return heartbeat.work == msg::ActuatorHeartbeat::kWorkWell; }));
}

}  // namespace musher::unattended_test
