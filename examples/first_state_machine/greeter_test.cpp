// [test]
#include "greeter.hpp"

#include <gtest/gtest.h>

#include "musher/behavior/fsm/recorder.hpp"
#include "musher/behavior/fsm/replay.hpp"
#include "musher/behavior/fsm/snapshot.hpp"

class GreeterTest : public testing::Test {
 protected:
  GreeterTest() {
    EXPECT_TRUE(machine_->Build("IDLE"));
    EXPECT_TRUE(machine_->Start(now_));
  }
  void RunFor(musher::Duration time) {
    for (const musher::Time end = now_ + time; now_ < end;) machine_->RunOnce(now_ += kStep);
  }

  static constexpr musher::Duration kStep = std::chrono::milliseconds(20);
  Robot robot_;
  std::unique_ptr<fsm::Machine> machine_ = MakeGreeter(robot_);
  musher::Time now_{};
};

TEST_F(GreeterTest, GreetsOnceAndReturnsToIdleWhenAloneAgain) {
  robot_.sees_person = true;
  RunFor(std::chrono::hours(1));
  EXPECT_EQ(robot_.said, std::vector<std::string>{"Hello!"});
  robot_.sees_person = false;
  RunFor(std::chrono::seconds(3));
  EXPECT_EQ(machine_->Path(), "IDLE");
  EXPECT_EQ(robot_.pose, "neutral");
}

TEST_F(GreeterTest, GreetsOnCommand) {
  ASSERT_TRUE(machine_->Send("greet"));
  RunFor(kStep);
  EXPECT_EQ(robot_.pose, "wave");
}
// [test end]

// [safety]
TEST_F(GreeterTest, KeepsStillWhileAPersonIsTooClose) {
  robot_.person_is_too_close = true;
  RunFor(std::chrono::minutes(1));
  EXPECT_EQ(robot_.pose, "still");
  EXPECT_EQ(machine_->unsafe(), "distance");
  robot_.person_is_too_close = false;
  RunFor(kStep);
  EXPECT_EQ(machine_->Path(), "IDLE");
}
// [safety end]

// [save]
TEST_F(GreeterTest, ContinuesInAnotherProcess) {
  ASSERT_TRUE(machine_->Send("greet"));
  RunFor(std::chrono::seconds(1));
  const musher::Result<fsm::Snapshot> saved = machine_->Save();
  ASSERT_TRUE(saved);

  Robot other_robot;
  const auto other = MakeGreeter(other_robot);
  ASSERT_TRUE(other->Build("IDLE"));
  ASSERT_TRUE(other->Restore(saved.value(), now_).empty());
  EXPECT_EQ(other->Path(), "GREETING");
  EXPECT_TRUE(other_robot.said.empty());  // it was entered before
}
// [save end]

// [replay]
TEST(Greeter, ReplaysARecordingWithTheSameOutput) {
  Robot robot;
  const auto machine = MakeGreeter(robot);
  ASSERT_TRUE(machine->Build("IDLE"));
  std::string record;  // a file on a robot
  fsm::Recorder recorder(*machine, [&](std::string_view line) { record += line; });
  musher::Time now{};
  ASSERT_TRUE(machine->Start(now));
  for (int i = 0; i < 300; ++i) {
    if (i == 50 || i == 100) {
      robot.sees_person = i == 50;
      recorder.Input("sees_person", i == 50 ? "yes" : "no");
    }
    machine->RunOnce(now += std::chrono::milliseconds(20));
  }

  Robot other_robot;
  const auto other = MakeGreeter(other_robot);
  ASSERT_TRUE(other->Build("IDLE"));
  const auto recording = fsm::ReadRecording(record, "greeter.record");
  ASSERT_TRUE(recording);
  const auto replayed =
      fsm::Replay(recording.value(), *other, [&](std::string_view, std::string_view text) {
        other_robot.sees_person = text == "yes";
        return musher::Ok();
      });
  ASSERT_TRUE(replayed);
  EXPECT_FALSE(replayed.value().difference);
  EXPECT_EQ(other_robot.said, robot.said);
}
// [replay end]
