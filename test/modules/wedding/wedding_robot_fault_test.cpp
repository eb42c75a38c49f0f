// The wedding robot under injected faults: it turns to a guest in Active only and never during an
// emergency stop, when it neither poses, looks nor plays.

#include "musher/messages/stamp.hpp"
#include "musher/modules/wedding/wedding_robot.hpp"
#include "musher/test/modules/module_fault_test.hpp"

namespace musher::wedding::wedding_robot_fault_test {

// A guest before the camera, and the robot's body and voice.
class Hall {
 public:
  explicit Hall(transport::Node& desk)
      : target_(
            transport::MakePublisher<msg::PointStamped>(desk, "wedding/perception/target").value()),
        looks_(transport::MakeSubscription<msg::PointStamped>(desk, "wedding/motion/look_at",
                                                              [this](const auto&...) { ++outputs; })
                   .value()),
        poses_(transport::MakeSubscription<msg::String>(desk, "wedding/motion/pose",
                                                        [this](const auto&...) { ++outputs; })
                   .value()),
        sounds_(transport::MakeSubscription<msg::String>(desk, "wedding/audio/play",
                                                         [this](const auto&...) { ++outputs; })
                    .value()),
        ticker_(desk.loop().Every(Milliseconds(100), [this, &desk] {
          msg::PointStamped target;
          target.header.stamp = msg::ToStamp(desk.loop().Now().time_since_epoch());
          target.point = {++ticks_ % 20 < 10 ? 0.3 : 0.7, 0.5, 1.5};
          static_cast<void>(target_->Publish(target));
        })) {}

  int outputs = 0;

 private:
  int ticks_ = 0;
  std::unique_ptr<transport::Publisher<msg::PointStamped>> target_;
  std::unique_ptr<transport::Subscription> looks_;
  std::unique_ptr<transport::Subscription> poses_;
  std::unique_ptr<transport::Subscription> sounds_;
  transport::LoopHandlePtr ticker_;
};

TEST(TheWeddingRobot, MovesAndPlaysInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  testing::ModuleFaultTest<WeddingRobot, Hall> test;
  test.make = [] {
    WeddingConfig config;
    config.autostart = true;
    return std::make_unique<WeddingRobot>("wedding", config);
  };
  const auto outputs = [&test] {
    test.Pass(Milliseconds(100));  // what is under way
    test.peers->outputs = 0;
    test.Pass(Milliseconds(700));
    return test.peers->outputs;
  };
  int shown = 0;
  test.always = [&](const WeddingRobot&, const ActuatorReport& report) {
    const bool shows = outputs() > 0;
    if (shows) ++shown;
    EXPECT_TRUE(!shows || (report.state == kActive && report.emergency_stop == 0))
        << "the show goes on in " << report.state;
  };
  test.after_emergency_stop = [&](const WeddingRobot&, const ActuatorReport&) {
    EXPECT_EQ(outputs(), 0) << "during a stop";
  };
  test.Run();
  EXPECT_GT(shown, 50) << "or nothing has been tried";
}

}  // namespace musher::wedding::wedding_robot_fault_test
