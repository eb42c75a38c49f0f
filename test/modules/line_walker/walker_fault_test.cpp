// The line walker under injected faults: it walks in Active only and never during an emergency
// stop, even if it gets START.

#include "musher/messages/stamp.hpp"
#include "musher/modules/line_walker/walker_actuator.hpp"
#include "musher/test/modules/line_walker/s_lane.hpp"
#include "musher/test/modules/module_fault_test.hpp"

namespace musher::line_walker::walker_fault_test {

// A body in the middle of a straight lane, its cameras, and an operator who sends START.
class Lane {
 public:
  explicit Lane(transport::Node& desk)
      : desk_(desk),
        command_(Publisher<msg::String>("yellow_line_walker/command")),
        odometry_(Publisher<msg::Odometry>("odom_out")),
        lines_{Publisher<msg::YellowLines>("yellow_line_detector/left"),
               Publisher<msg::YellowLines>("yellow_line_detector/right"),
               Publisher<msg::YellowLines>("yellow_line_detector/front")},
        frames_(transport::MakeSubscription<msg::MotionServoCmd>(
                    desk, "motion_servo_cmd",
                    [this](const msg::MotionServoCmd& frame, const auto&) {
                      if (frame.cmd_type != msg::MotionServoCmd::kEnd) ++frames;
                    })
                    .value()),
        ticker_(desk.loop().Every(Milliseconds(100), [this] { Tick(); })) {}

  int frames = 0;  // of walks

 private:
  template <msg::Message M>
  std::unique_ptr<transport::Publisher<M>> Publisher(const std::string& topic) {
    return transport::MakePublisher<M>(desk_, topic).value();
  }
  static msg::YellowLines LineOf(const MountedCamera& mounted, double left_m) {
    const WorldCamera camera(mounted, Pose{}, 0.29);
    msg::YellowLines lines;
    for (double x = -0.5; x < 1; x += 0.05) {
      const auto share = camera.ShareOf({x, left_m});
      if (!share) continue;
      lines.edge_x.push_back(float((*share)[0]));
      lines.edge_y.push_back(float((*share)[1]));
    }
    return lines;
  }
  void Tick() {
    const msg::Stamp stamp = msg::ToStamp(desk_.loop().Now().time_since_epoch());
    msg::Odometry odometry;
    odometry.header.stamp = stamp;
    static_cast<void>(odometry_->Publish(odometry));
    left_.header.stamp = right_.header.stamp = stamp;
    static_cast<void>(lines_[0]->Publish(left_));
    static_cast<void>(lines_[1]->Publish(right_));
    static_cast<void>(command_->Publish({"START"}));
  }

  transport::Node& desk_;
  msg::YellowLines left_ = LineOf(CameraSet().left, 0.415);
  msg::YellowLines right_ = LineOf(CameraSet().right, -0.415);
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> lines_[3];
  std::unique_ptr<transport::Subscription> frames_;
  transport::LoopHandlePtr ticker_;
};

TEST(TheLineWalker, WalksInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  testing::ModuleFaultTest<WalkerActuator, Lane> test;
  test.make = [] { return std::make_unique<WalkerActuator>("walker", WalkerConfig{}); };
  const auto frames = [&test] {
    test.Pass(Milliseconds(100));  // what is under way
    test.peers->frames = 0;
    test.Pass(Milliseconds(900));
    return test.peers->frames;
  };
  int walked = 0;
  test.always = [&](const WalkerActuator&, const ActuatorReport& report) {
    const bool walks = frames() > 0;
    if (walks) ++walked;
    EXPECT_TRUE(!walks || (report.state == kActive && report.emergency_stop == 0))
        << "it walks in " << report.state;
  };
  test.after_emergency_stop = [&](const WalkerActuator&, const ActuatorReport&) {
    EXPECT_EQ(frames(), 0) << "during a stop";
  };
  test.Run();
  EXPECT_GT(walked, 50) << "or nothing has been tried";
}

}  // namespace musher::line_walker::walker_fault_test
