// The action speech_text_action, on the simulated network.

#include <gmock/gmock.h>

#include <optional>
#include <string>
#include <vector>

#include "musher/test/modules/audio/voice_on_a_network.hpp"

namespace musher::audio::speech_action_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using transport::GoalEnd;
using transport::GoalState;

// What the client sees of a goal.
struct Seen {
  bool accepted = false;
  std::vector<GoalState> states;
  int talking = 0;  // feedback
  std::optional<transport::GoalOutcome<msg::Speech>> outcome;
};

class SpeechGoals : public testing::VoiceOnANetwork {
 protected:
  SpeechGoals() { network_.RunFor(Milliseconds(500)); }

  transport::GoalId Send(const msg::Speech::Goal& goal, Seen& seen) {
    transport::GoalEvents<msg::Speech> events;
    events.on_accepted = [&] { seen.accepted = true; };
    events.on_state = [&](GoalState state) { seen.states.push_back(state); };
    events.on_feedback = [&](const msg::Speech::Feedback& feedback) {
      EXPECT_TRUE(feedback.talking);
      ++seen.talking;
    };
    events.on_end = [&](const auto& outcome) { seen.outcome = outcome; };
    return client_->SendGoal(goal, Milliseconds(1000), events);
  }
  transport::GoalId SendText(const std::string& text, Seen& seen) {
    return Send({"app", true, {}, text}, seen);
  }
  void Cancel(const transport::GoalId& id) {
    client_->Cancel(id, Milliseconds(1000), [](const auto& reply) {
      ASSERT_TRUE(reply);
      EXPECT_EQ(reply.value().return_code, msg::CancelGoal::kErrorNone);
    });
    network_.RunFor(Milliseconds(100));
  }

  std::unique_ptr<transport::ActionClient<msg::Speech>> client_ =
      transport::MakeActionClient<msg::Speech>(*desk_, "dog1/speech_text_action").value();
};

TEST_F(SpeechGoals, AreSpokenWithFeedbackWhileTheySound) {
  Seen seen;
  SendText("twenty characters...", seen);
  network_.RunFor(Milliseconds(1'900));
  EXPECT_TRUE(seen.accepted);
  EXPECT_THAT(seen.states, ::testing::ElementsAre(GoalState::kExecuting));
  EXPECT_EQ(seen.talking, 4) << "at the beginning, and every 500 ms";
  EXPECT_FALSE(seen.outcome);
  network_.RunFor(Milliseconds(200));
  ASSERT_TRUE(seen.outcome);
  EXPECT_EQ(seen.outcome->end, GoalEnd::kSucceeded);
  EXPECT_EQ(seen.outcome->result.status, 0);
}

TEST_F(SpeechGoals, MayTakeLongerThanACallOfTheService) {
  Seen seen;
  SendText(std::string(100, 'a'), seen);
  Seen next;
  Send({"app", false, {"app", 60}, ""}, next);
  network_.RunFor(Milliseconds(9'000));
  EXPECT_TRUE(next.accepted);
  EXPECT_THAT(next.states, IsEmpty()) << "it is queued";
  network_.RunFor(Milliseconds(6'000));
  ASSERT_TRUE(seen.outcome && next.outcome);
  EXPECT_EQ(next.outcome->end, GoalEnd::kSucceeded);
  EXPECT_THAT(log_, HasSubstr(R"(plays "all well" for "app")"));
}

TEST_F(SpeechGoals, AreSilencedByACancellation) {
  Seen seen;
  const auto id = SendText(std::string(50, 'a'), seen);
  network_.RunFor(Milliseconds(1'000));
  Cancel(id);
  ASSERT_TRUE(seen.outcome);
  EXPECT_EQ(seen.outcome->end, GoalEnd::kCanceled);
  EXPECT_EQ(seen.outcome->result.status, 1);
  EXPECT_FALSE(reports_.back()) << "there is no sound";
}

TEST_F(SpeechGoals, AreCancelledWhileTheyAreQueued) {
  Seen first, second;
  SendText("twenty characters...", first);
  const auto id = SendText("never heard", second);
  network_.RunFor(Milliseconds(500));
  Cancel(id);
  ASSERT_TRUE(second.outcome);
  EXPECT_EQ(second.outcome->end, GoalEnd::kCanceled);
  network_.RunFor(Milliseconds(3'000));
  ASSERT_TRUE(first.outcome);
  EXPECT_EQ(first.outcome->end, GoalEnd::kSucceeded);
  EXPECT_THAT(log_, Not(HasSubstr("never heard")));
}

TEST_F(SpeechGoals, AreAbortedByASoundThatInterrupts) {
  Seen seen;
  SendText(std::string(50, 'a'), seen);
  network_.RunFor(Milliseconds(500));
  ASSERT_TRUE(play_->Publish({"app", 60}));
  network_.RunFor(Milliseconds(200));
  ASSERT_TRUE(seen.outcome);
  EXPECT_EQ(seen.outcome->end, GoalEnd::kAborted);
  EXPECT_EQ(seen.outcome->result.status, 1);
}

TEST_F(SpeechGoals, AreRejectedIfTheyCannotBePlayed) {
  Seen empty, unknown;
  SendText(" ", empty);
  Send({"app", false, {"app", 4711}, ""}, unknown);
  network_.RunFor(Milliseconds(500));
  ASSERT_TRUE(empty.outcome && unknown.outcome);
  EXPECT_EQ(empty.outcome->end, GoalEnd::kRejected);
  EXPECT_EQ(unknown.outcome->end, GoalEnd::kRejected);
  EXPECT_THAT(reports_, IsEmpty());
  shell_->Enter(State(kTearDown));
  Seen late;
  SendText("late", late);
  network_.RunFor(Milliseconds(500));
  ASSERT_TRUE(late.outcome);
  EXPECT_EQ(late.outcome->end, GoalEnd::kRejected);
}

TEST_F(SpeechGoals, StopAllSoundsWithTheId9999) {
  Seen speech, stop;
  SendText(std::string(50, 'a'), speech);
  network_.RunFor(Milliseconds(500));
  Send({"app", false, {"app", msg::AudioPlay::kStop}, ""}, stop);
  network_.RunFor(Milliseconds(500));
  ASSERT_TRUE(speech.outcome && stop.outcome);
  EXPECT_EQ(speech.outcome->end, GoalEnd::kAborted);
  EXPECT_EQ(stop.outcome->end, GoalEnd::kSucceeded);
}

TEST_F(SpeechGoals, AreLostWhenTheModuleExits) {
  Seen seen;
  SendText(std::string(90, 'a'), seen);
  network_.RunFor(Milliseconds(500));
  network_.Crash(*robot_);
  network_.RunUntil([&] { return seen.outcome.has_value(); },
                    network_.now() + std::chrono::seconds(60));
  ASSERT_TRUE(seen.outcome);
  EXPECT_EQ(seen.outcome->end, GoalEnd::kLost);
  EXPECT_THAT(seen.outcome->reason, HasSubstr("connection to the server lost"));
}

}  // namespace musher::audio::speech_action_test
