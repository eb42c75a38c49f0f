// The motion manager under injected faults: it lets the body walk in Active only and never during
// an emergency stop, whatever a streamer sends, and the body lies in LowPower, OTA and TearDown.
// After a switch from Active to Protected a walk ends by its watchdog, 200 ms after its last frame.

#include "musher/modules/motion/motion_manager.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/test/modules/motion/harness.hpp"
#include "musher/test/modules/motion/topic_board.hpp"

namespace musher::motion::motion_manager_fault_test {

// A body, and a streamer that lets it walk at all times.
class BodyAndStreamer {
 public:
  explicit BodyAndStreamer(transport::Node& desk)
      : body(desk),
        commands_(transport::MakeSubscription<msg::MotionCustomCommand>(
                      desk, "world/body_command",
                      [this](const msg::MotionCustomCommand& command, const auto&) {
                        if (command.mode != Walk().mode || command.vel_des.empty()) return;
                        if (command.vel_des[0] != 0) ++steps;
                      })
                      .value()),
        frames_(transport::MakePublisher<msg::MotionServoCmd>(desk, "motion_servo_cmd").value()),
        ticker_(desk.loop().Every(Milliseconds(50), [this] {
          msg::MotionServoCmd frame;
          frame.motion_id = Walk().id;
          frame.cmd_type = msg::MotionServoCmd::kData;
          frame.vel_des = {0.2F, 0, 0};
          frame.step_height = {0.05F, 0.05F};
          static_cast<void>(frames_->Publish(frame));
        })) {
    const Motion& lying = *testing::TheTable().Find(kGetDown);  // one that is off takes no walk
    body.board.report.mode = lying.mode;
    body.board.report.gait = lying.gait;
    body.board.report.bar = 100;
  }

  static const Motion& Walk() { return *testing::TheTable().Find(303); }
  // It has lain down, or is off.
  bool Lies() const {
    const std::int8_t mode = body.board.report.mode;
    return mode == 0 || mode == testing::TheTable().Find(kGetDown)->mode;
  }

  testing::TopicBoard body;
  int steps = 0;  // commands to walk

 private:
  std::unique_ptr<transport::Subscription> commands_;
  std::unique_ptr<transport::Publisher<msg::MotionServoCmd>> frames_;
  transport::LoopHandlePtr ticker_;
};

TEST(TheMotionManager, WalksInActiveOnlyAndLiesInLowPowerUnderInjectedFaults) {
  musher::testing::ModuleFaultTest<MotionManager, BodyAndStreamer> test;
  test.scenarios = 60;
  test.make = [] {
    return std::make_unique<MotionManager>("motion_manager", MotionConfig{}, testing::TheTable());
  };
  const auto steps = [&test](Duration under_way) {
    test.Pass(under_way);
    test.peers->steps = 0;
    test.Pass(Milliseconds(500));
    return test.peers->steps;
  };
  int walked = 0;
  int lay = 0;
  test.always = [&](const MotionManager&, const ActuatorReport& report) {
    const bool lies =
        report.state == kLowPower || report.state == kOta || report.state == kTearDown;
    const bool lay_down = test.peers->Lies();
    if (lies && lay_down) ++lay;
    EXPECT_TRUE(!lies || lay_down) << "the body stands in " << report.state;
    const bool walks = steps(Milliseconds(250)) > 0;
    if (walks) ++walked;
    EXPECT_TRUE(!walks || (report.state == kActive && report.emergency_stop == 0))
        << "the body walks in " << report.state;
  };
  test.after_emergency_stop = [&](const MotionManager&, const ActuatorReport&) {
    EXPECT_EQ(steps(Milliseconds(60)), 0) << "during a stop";
  };
  test.Run();
  EXPECT_GT(walked, 30) << "or nothing has been tried";
  EXPECT_GT(lay, 30) << "or nothing has been tried";
}

}  // namespace musher::motion::motion_manager_fault_test
