// The race under injected faults: it sends frames of a walk in Active only and never during an
// emergency stop, and ends each stream that it has begun.

#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/race_robot.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/transport/service.hpp"

namespace musher::race::race_robot_fault_test {

// A walk that takes minutes.
constexpr const char* kCourse = R"(
start = "START"
end = "END"
error = "ERROR"
stand = "stand"
[robot]
audio = "none"
[movement.forward]
motion = 303
twist = [0.4, 0.0, 0.0]
[movement.stand]
motion = 111
[state.START]
number = 0
next = "DRIVE"
[state.DRIVE]
number = 1
steps = [{ move = "forward", count = 500 }]
next = "END"
[state.END]
number = 2
[state.ERROR]
number = 3
)";

// A body that executes every command, and an operator who starts the race again and again.
class Body {
 public:
  explicit Body(transport::Node& desk)
      : command_(
            transport::MakePublisher<msg::String>(desk, "state_machine/start_command").value()),
        status_(transport::MakePublisher<msg::MotionStatus>(desk, "motion_status").value()),
        motion_(transport::MakeServer<msg::MotionResultCmd>(
                    desk, "motion_result_cmd",
                    [](const auto& request, const auto& reply, auto) {
                      reply({request.motion_id, true, 0});
                    })
                    .value()),
        servo_(transport::MakeSubscription<msg::MotionServoCmd>(
                   desk, "motion_servo_cmd",
                   [this](const msg::MotionServoCmd& frame, const auto&) {
                     streaming = frame.cmd_type != msg::MotionServoCmd::kEnd;
                     if (streaming) ++frames;
                   })
                   .value()),
        ticker_(desk.loop().Every(Milliseconds(100), [this] {
          static_cast<void>(status_->Publish({}));
          if (++ticks_ % 10 == 0) static_cast<void>(command_->Publish({"START:DRIVE"}));
        })) {}

  int frames = 0;
  bool streaming = false;

 private:
  int ticks_ = 0;
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::MotionStatus>> status_;
  std::unique_ptr<transport::Server<msg::MotionResultCmd>> motion_;
  std::unique_ptr<transport::Subscription> servo_;
  transport::LoopHandlePtr ticker_;
};

TEST(TheRace, WalksInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  const CourseReading reading = ReadCourseText(kCourse, "walk.toml");
  for (const Diagnostic& found : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(found);
  ASSERT_TRUE(reading.course);
  testing::ModuleFaultTest<RaceRobot, Body> test;
  test.make = [&] { return std::make_unique<RaceRobot>("race", *reading.course); };
  int walked = 0;
  const auto check = [&](const ActuatorReport& report, bool permitted) {
    test.Pass(Milliseconds(100));  // what is under way
    // A process that was killed ends nothing; the body's watchdog does.
    if (report.state == kUninitialized || report.state == kSetUp) test.peers->streaming = false;
    EXPECT_TRUE(permitted || !test.peers->streaming) << "a stream has no end in " << report.state;
    test.peers->frames = 0;
    test.Pass(Milliseconds(1100));
    EXPECT_TRUE(permitted || test.peers->frames == 0) << "it walks in " << report.state;
    if (test.peers->frames > 0) ++walked;
  };
  test.always = [&](const RaceRobot&, const ActuatorReport& report) {
    check(report, report.state == kActive && report.emergency_stop == 0);
  };
  test.after_emergency_stop = [&](const RaceRobot&, const ActuatorReport& report) {
    check(report, false);
  };
  test.Run();
  EXPECT_GT(walked, 50) << "or nothing has been tried";
}

}  // namespace musher::race::race_robot_fault_test
