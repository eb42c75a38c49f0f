// A race whose process could not run for a while: what it does with the commands that waited, and
// with its walk. The actuator with the real controller, on /clock.

#include <gmock/gmock.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/race_robot.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/application/suspended_thread.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/service.hpp"

namespace musher::race::break_test {

// A walk that takes minutes.
constexpr const char* kCourse = R"(
start = "START"
end = "END"
error = "ERROR"
stand = "stand"
[robot]
audio = "none"
self_check_ms = 200
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

Course LongWay() {
  const CourseReading reading = ReadCourseText(kCourse, "walk.toml");
  for (const Diagnostic& found : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(found);
  return reading.course.value_or(Course{});
}

// With the name of the harness's config.
class Driven : public RaceRobot {
 public:
  Driven() : RaceRobot("show", LongWay()) {}
  template <class Look>
  auto Of(Look look) {
    decltype(look(*this)) found{};
    RunOnLoop([&] { found = look(*this); });
    return found;
  }
  bool Logged(const std::string& part) {
    return Of([&](Driven& race) { return race.log_.find(part) != std::string::npos; });
  }
  std::string Path() {
    return Of([](Driven& race) { return race.machine().Path(); });
  }
  bool IsTimely() {
    return Of([](Driven& race) { return race.CheckNotLate().ok(); });
  }
  bool HasRefusedAsLate() {
    return Of([](Driven& race) {
      return testing::HasSentence(race.log_, ApplicationRefusal::kMayBeLate, false);
    });
  }
  using RaceRobot::Now;

 private:
  void Log(const std::string& line) override { log_ += line + "\n"; }

  std::string log_;
};

class ARaceAfterASuspension : public ::testing::Test {
 protected:
  ARaceAfterASuspension() {
    Loop([this] {
      transport::Node& node = harness_.node().node();
      command_ = transport::MakePublisher<msg::String>(node, "state_machine/start_command").value();
      body_ = transport::MakePublisher<msg::MotionStatus>(node, "motion_status").value();
      motion_ = transport::MakeServer<msg::MotionResultCmd>(
                    node, "motion_result_cmd",
                    [](const auto& request, const auto& reply, auto) {
                      reply({request.motion_id, true, 0});
                    })
                    .value();
      servo_ = transport::MakeSubscription<msg::MotionServoCmd>(
                   node, "motion_servo_cmd",
                   [this](const msg::MotionServoCmd& frame, const auto&) {
                     streaming_ = frame.cmd_type != msg::MotionServoCmd::kEnd;
                     if (streaming_) ++frames_;
                   })
                   .value();
    });
  }
  ~ARaceAfterASuspension() override {
    Loop([this] {
      servo_.reset();
      motion_.reset();
      body_.reset();
      command_.reset();
    });
  }
  void SetUp() override {
    harness_.Open(race_, thread_);
    ASSERT_TRUE(testing::Until([this] { return Go("SelfCheck"); })) << "the body is found";
    ASSERT_TRUE(Go("Active"));
    ASSERT_TRUE(Await([this] { return command_->MatchedReaders() == 1; }));
  }

  void Loop(const std::function<void()>& work) { harness_.node().RunOnLoop(work); }
  bool Go(const State& state) { return harness_.controller().Switch(state).done(); }
  void Command(const std::string& word) {
    Loop([&] { EXPECT_TRUE(command_->Publish({word})); });
  }
  // This many ticks of 20 ms, in which the body reports.
  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      Loop([this] { static_cast<void>(body_->Publish({})); });
      harness_.Tick(race_, 1);
    }
  }
  // Until it holds on the loop.
  bool Await(const std::function<bool()>& holds) {
    return testing::Until([&] {
      bool met = false;
      Loop([&] { met = holds(); });
      return met;
    });
  }
  bool AwaitFrames() {
    Loop([this] { frames_ = 0; });
    return testing::Until([this] {
      Run(5);
      int frames = 0;
      Loop([&] { frames = frames_; });
      return frames > 0;
    });
  }
  // For a second of the machine.
  void ExpectNoFrames() {
    Loop([this] { frames_ = 0; });
    Run(50);
    Loop([this] { EXPECT_EQ(frames_, 0); });
  }

  testing::Harness harness_;
  const std::shared_ptr<testing::SuspendedThread> thread_ =
      std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Driven> race_;
  int frames_ = 0;
  bool streaming_ = false;
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::MotionStatus>> body_;
  std::unique_ptr<transport::Server<msg::MotionResultCmd>> motion_;
  std::unique_ptr<transport::Subscription> servo_;
};

// It was sent while the computer was suspended, and walked off when it ran again.
TEST_F(ARaceAfterASuspension, BeginsByNoCommandThatWaitedMeanwhile) {
  for (const char* word : {"START", "START:DRIVE"}) {
    thread_->SuspendEachTime(std::chrono::seconds(9));
    Command(word);
    ASSERT_TRUE(testing::Until([&] {
      return race_.Logged(std::string(word) + " is refused: show could not run for ");
    })) << word;
    EXPECT_TRUE(race_.HasRefusedAsLate());
    thread_->SuspendEachTime({});
    ExpectNoFrames();
    EXPECT_EQ(race_.Path(), "START") << word;
    Run(60);  // so that the next refusal is logged at once
  }
  ASSERT_TRUE(testing::Until([this] { return race_.IsTimely(); }));
  Command("START:DRIVE");
  EXPECT_TRUE(AwaitFrames()) << "it is a new one";
  EXPECT_EQ(race_.Path(), "DRIVE");
}

TEST_F(ARaceAfterASuspension, IsStoppedByACommandThatWaitedMeanwhile) {
  Command("START:DRIVE");
  ASSERT_TRUE(AwaitFrames());
  thread_->SuspendEachTime(std::chrono::seconds(9));
  Command("STOP");
  ASSERT_TRUE(testing::Until([this] {
    Run(1);
    return race_.Path() == "START";
  }));
  thread_->SuspendEachTime({});
  ASSERT_TRUE(Await([this] { return !streaming_; }));
  ExpectNoFrames();
}

// It walked on, wherever it was put meanwhile.
TEST_F(ARaceAfterASuspension, StandsInTheMiddleOfItsWayUntilStart) {
  Command("START:DRIVE");
  ASSERT_TRUE(AwaitFrames());
  thread_->Suspend(std::chrono::seconds(20));
  ASSERT_TRUE(testing::Until([this] {
    Run(1);
    return race_.Logged("DRIVE: this process could not run for 2");
  }));
  ASSERT_TRUE(Await([this] { return !streaming_; }));
  ExpectNoFrames();
  EXPECT_EQ(race_.Path(), "DRIVE");
  ASSERT_TRUE(testing::Until([this] { return race_.IsTimely(); }));
  Command("START");
  EXPECT_TRUE(AwaitFrames());
  EXPECT_EQ(race_.Path(), "DRIVE");
}

// Its clock does not count a suspension: after a night it went on as after some seconds.
TEST_F(ARaceAfterASuspension, WaitsForStartWhereThatCameInALongPause) {
  Command("START:DRIVE");
  ASSERT_TRUE(AwaitFrames());
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Await([this] { return !streaming_; }));
  thread_->Suspend(std::chrono::hours(8));
  ASSERT_TRUE(Go("Active"));
  ExpectNoFrames();
  EXPECT_TRUE(race_.Logged("it goes on after START"));
}

}  // namespace musher::race::break_test
