// An actuator on the real middleware subscribes to the robot's battery if one of its functions
// needs it.

#include <gtest/gtest.h>

#include <fstream>
#include <future>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/transport/node.hpp"

namespace musher::battery_gate_test {

using testing::RobotFile;

constexpr ModuleCode kLegs{3000};

class Legs : public MachineActuator {
 public:
  Legs() : MachineActuator("legs") {
    RegisterStateCallback([](const State&) { return kCodeOk; });
  }
};

class BatteryGate : public ::testing::Test {
 protected:
  BatteryGate() : file_({"legs"}, {"SetUp", "SelfCheck", "Active", "LowPower"}) {
    std::ofstream(file_.path(), std::ios::app)
        << "[capability.jump]\nactuators = [\"legs\"]\nmin_battery = 30\n"
        << "[policy.battery]\ntopic = \"power/bms\"\n";
    node_ = transport::NodeThread::Start().value();
    node_->RunOnLoop([this] {
      publisher_ = transport::MakePublisher<msg::BmsStatus>(node_->node(),
                                                            RobotFile::name_space() + "/power/bms")
                       .value();
    });
  }
  ~BatteryGate() override {
    node_->RunOnLoop([this] {
      heartbeat_.reset();
      publisher_.reset();
    });
  }

  // Publishes such a battery until jumping is (not) allowed.
  bool Becomes(bool allowed, std::uint8_t percent) {
    std::promise<void> promise;
    std::future<void> done = promise.get_future();
    bool reported = false;
    node_->RunOnLoop([&] {
      heartbeat_ = node_->node().loop().Every(Milliseconds(5), [&, percent, allowed] {
        msg::BmsStatus status;
        status.batt_soc = percent;
        EXPECT_TRUE(publisher_->Publish(status).ok());
        if (legs_.Allowed("jump").ok() != allowed || std::exchange(reported, true)) return;
        promise.set_value();
      });
    });
    const bool came = done.wait_for(std::chrono::seconds(120)) == std::future_status::ready;
    node_->RunOnLoop([&] { heartbeat_.reset(); });
    return came;
  }

  RobotFile file_;
  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<transport::Publisher<msg::BmsStatus>> publisher_;
  transport::LoopHandlePtr heartbeat_;
  ActuatorRunner<Legs> legs_;
  MachineController controller_;
};

TEST_F(BatteryGate, FollowsTheTopicOfThePolicy) {
  ASSERT_TRUE(legs_.Init(file_.path()));
  ASSERT_TRUE(legs_.Start());
  ASSERT_TRUE(controller_.Init(file_.path()));
  ASSERT_TRUE(controller_.AwaitSetUp());
  ASSERT_TRUE(controller_.Switch("SelfCheck").done());
  ASSERT_TRUE(controller_.Switch("Active").done());
  EXPECT_FALSE(legs_.Allowed("jump").ok()) << "nothing is known of the battery";
  EXPECT_TRUE(Becomes(true, 80));
  EXPECT_TRUE(Becomes(false, 29));
  EXPECT_EQ(legs_.Allowed("jump", kLegs).error().code, 3013);
  ASSERT_TRUE(controller_.Switch("LowPower").done());
  EXPECT_EQ(legs_.Allowed("jump", kLegs).error().code, 3003);
}

}  // namespace musher::battery_gate_test
