// The goals of an action server, in virtual time.

#include "musher/transport/action_goals.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <map>
#include <vector>

#include "musher/messages/stamp.hpp"

namespace musher::transport::action_goals_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr std::array kStates = {GoalState::kUnknown,   GoalState::kAccepted,  GoalState::kExecuting,
                                GoalState::kCanceling, GoalState::kSucceeded, GoalState::kCanceled,
                                GoalState::kAborted};

GoalId Id(std::uint8_t number) {
  GoalId id{};
  id[0] = number;
  return id;
}

msg::Stamp At(int sec) {
  return {sec, 0};
}

msg::GoalInfo Request(std::uint8_t id, int sec = 0) {
  return {{Id(id)}, At(sec)};
}

Time After(Duration duration) {
  return Time{} + duration;
}

class Goals : public ::testing::Test {
 protected:
  // Accepted at the second of its number, then in `state`.
  void Add(std::uint8_t number, GoalState state = GoalState::kAccepted) {
    ASSERT_TRUE(goals_.Accept(Id(number), At(number)));
    if (state == GoalState::kAccepted) return;
    if (state != GoalState::kCanceling) {
      ASSERT_TRUE(goals_.Change(Id(number), GoalState::kExecuting, now_));
    }
    if (state == GoalState::kCanceled) {
      ASSERT_TRUE(goals_.Change(Id(number), GoalState::kCanceling, now_));
    }
    if (state != GoalState::kExecuting) {
      ASSERT_TRUE(goals_.Change(Id(number), state, now_));
    }
  }
  CancelChoice Choose(std::uint8_t id, int sec = 0) const {
    return goals_.ChooseCancelled(Request(id, sec));
  }

  Time now_;
  ActionGoals goals_;
};

TEST(GoalStates, HaveTheTransitionsOfRos2) {
  using enum GoalState;
  std::vector<std::pair<GoalState, GoalState>> found;
  for (const GoalState from : kStates) {
    for (const GoalState to : kStates) {
      if (IsTransition(from, to)) found.emplace_back(from, to);
    }
  }
  EXPECT_THAT(found, UnorderedElementsAre(
                         std::pair(kAccepted, kExecuting), std::pair(kAccepted, kCanceling),
                         std::pair(kExecuting, kCanceling), std::pair(kExecuting, kSucceeded),
                         std::pair(kExecuting, kAborted), std::pair(kCanceling, kCanceled),
                         std::pair(kCanceling, kSucceeded), std::pair(kCanceling, kAborted)));
}

TEST(GoalStates, HaveTheNumbersOfRos2) {
  for (std::size_t i = 0; i < kStates.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(kStates[i]), i) << GoalStateName(kStates[i]);
  }
}

TEST_F(Goals, RefusesAnIdThatIsInUseAlsoAfterTheEndOfItsGoal) {
  Add(1, GoalState::kSucceeded);
  EXPECT_FALSE(goals_.Accept(Id(1), At(2)));
  EXPECT_EQ(goals_.size(), 1U);
}

TEST_F(Goals, RefusesTheIdThatNamesNoGoal) {
  EXPECT_FALSE(goals_.Accept(kNoGoalId, At(1)));
}

TEST_F(Goals, RefusesATransitionThatRos2DoesNotHave) {
  Add(1, GoalState::kAborted);
  EXPECT_FALSE(goals_.Change(Id(1), GoalState::kSucceeded, now_));
  EXPECT_FALSE(goals_.Change(Id(2), GoalState::kExecuting, now_)) << "unknown";
  EXPECT_EQ(goals_.StateOf(Id(1)), GoalState::kAborted);
}

TEST_F(Goals, CancelOneByItsId) {
  Add(1);
  Add(2, GoalState::kExecuting);
  EXPECT_THAT(Choose(1).goals, ElementsAre(Id(1)));
  EXPECT_THAT(Choose(2).goals, ElementsAre(Id(2)));
  EXPECT_EQ(Choose(2).return_code, msg::CancelGoal::kErrorNone);
}

TEST_F(Goals, CancelNoGoalThatIsUnknownOrHasEnded) {
  Add(1, GoalState::kSucceeded);
  EXPECT_EQ(Choose(1).return_code, msg::CancelGoal::kErrorGoalTerminated);
  EXPECT_EQ(Choose(2).return_code, msg::CancelGoal::kErrorUnknownGoalId);
  EXPECT_THAT(Choose(1).goals, IsEmpty());
}

TEST_F(Goals, RefuseTheIdOfACancellationThatCameBeforeItsGoalForAMinute) {
  goals_.NoteEarlyCancel(Request(1), now_);
  EXPECT_FALSE(goals_.WasCancelledEarly(Id(2), now_));
  EXPECT_TRUE(goals_.WasCancelledEarly(Id(1), now_));
  EXPECT_TRUE(goals_.WasCancelledEarly(Id(1), now_ + std::chrono::seconds(59)));
  EXPECT_FALSE(goals_.WasCancelledEarly(Id(1), now_ + std::chrono::seconds(60)));
  goals_.NoteEarlyCancel(Request(1), now_ + std::chrono::seconds(30));
  EXPECT_TRUE(goals_.WasCancelledEarly(Id(1), now_ + std::chrono::seconds(89))) << "repeated";
}

TEST_F(Goals, KeepNoEarlyCancellationOfAGoalThatIsKnownOrOfMany) {
  Add(1);
  for (const msg::GoalInfo& request : {Request(1), Request(0), Request(2, 7), Request(0, 7)}) {
    goals_.NoteEarlyCancel(request, now_);
  }
  EXPECT_FALSE(goals_.WasCancelledEarly(Id(1), now_));
  EXPECT_FALSE(goals_.WasCancelledEarly(Id(2), now_));
  EXPECT_FALSE(goals_.WasCancelledEarly(kNoGoalId, now_));
}

TEST_F(Goals, KeepALimitedNumberOfEarlyCancellations) {
  for (std::size_t i = 0; i <= ActionGoals::kMostEarlyCancels; ++i) {
    GoalId id{};
    id[0] = static_cast<std::uint8_t>(i % 256);
    id[1] = static_cast<std::uint8_t>(i / 256 + 1);
    goals_.NoteEarlyCancel({{id}, {}}, now_);
  }
  GoalId first{}, second{};
  first[1] = second[1] = 1;
  second[0] = 1;
  EXPECT_FALSE(goals_.WasCancelledEarly(first, now_)) << "the oldest is dropped first";
  EXPECT_TRUE(goals_.WasCancelledEarly(second, now_));
}

TEST_F(Goals, ReportOneThatIsCancelingOnceMore) {
  Add(1, GoalState::kCanceling);
  EXPECT_THAT(Choose(1).goals, IsEmpty());
  EXPECT_THAT(Choose(1).canceling, ElementsAre(Id(1)));
  EXPECT_EQ(Choose(1).return_code, msg::CancelGoal::kErrorNone);
}

TEST_F(Goals, CancelAllWithoutAnIdAndAStamp) {
  Add(3);
  Add(1, GoalState::kExecuting);
  Add(2, GoalState::kAborted);
  EXPECT_THAT(Choose(0).goals, ElementsAre(Id(3), Id(1)));
  EXPECT_EQ(Choose(0).return_code, msg::CancelGoal::kErrorNone);
}

TEST_F(Goals, CancelAllUpToAStamp) {
  for (std::uint8_t number = 1; number <= 3; ++number) Add(number);
  EXPECT_THAT(Choose(0, 2).goals, ElementsAre(Id(1), Id(2)));
  EXPECT_THAT(Choose(3, 1).goals, ElementsAre(Id(1), Id(3))) << "and the one with the id";
  EXPECT_THAT(Choose(9, 1).goals, ElementsAre(Id(1))) << "whether or not it is known";
  EXPECT_EQ(Choose(9, 1).return_code, msg::CancelGoal::kErrorNone);
}

TEST_F(Goals, ListTheirStatesInTheOrderOfAcceptance) {
  Add(7, GoalState::kSucceeded);
  Add(2, GoalState::kCanceling);
  const auto statuses = goals_.Statuses().status_list;
  ASSERT_EQ(statuses.size(), 2U);
  EXPECT_EQ(statuses[0], (msg::GoalStatus{{{Id(7)}, At(7)}, msg::GoalStatus::kStatusSucceeded}));
  EXPECT_EQ(statuses[1], (msg::GoalStatus{{{Id(2)}, At(2)}, msg::GoalStatus::kStatusCanceling}));
}

TEST_F(Goals, AreKnownForFifteenMinutesAfterTheirEnd) {
  Add(1, GoalState::kSucceeded);
  now_ = After(std::chrono::minutes(1));
  Add(2, GoalState::kExecuting);
  EXPECT_EQ(goals_.NextExpiry(), After(std::chrono::minutes(15)));
  EXPECT_THAT(goals_.Expire(After(std::chrono::minutes(15) - Milliseconds(1))), IsEmpty());
  EXPECT_THAT(goals_.Expire(After(std::chrono::minutes(15))), ElementsAre(Id(1)));
  EXPECT_EQ(goals_.StateOf(Id(1)), GoalState::kUnknown);
  EXPECT_EQ(goals_.NextExpiry(), std::nullopt) << "one that has not ended does not expire";
  EXPECT_TRUE(goals_.Accept(Id(1), At(9))) << "its id may be used again";
}

TEST_F(Goals, KeepALimitedNumberOfResults) {
  goals_ = ActionGoals({std::chrono::minutes(15), 2});
  for (std::uint8_t number = 1; number <= 3; ++number) Add(number, GoalState::kSucceeded);
  EXPECT_EQ(goals_.NextExpiry(), now_);
  EXPECT_THAT(goals_.Expire(now_), ElementsAre(Id(1)));
  EXPECT_EQ(goals_.size(), 2U);
}

TEST_F(Goals, KeepNoResultWithoutATimeout) {
  goals_ = ActionGoals({Duration::zero(), 10});
  Add(1, GoalState::kSucceeded);
  EXPECT_THAT(goals_.Expire(now_), ElementsAre(Id(1)));
}

TEST_F(Goals, KeepResultsForAsLongAsATimeCanBe) {
  goals_ = ActionGoals({Duration::max(), 10});
  Add(1, GoalState::kSucceeded);
  EXPECT_THAT(goals_.Expire(After(std::chrono::hours(24 * 365))), IsEmpty());
}

// What the documentation says, written once more and as simply as possible.
struct Model {
  struct Goal {
    GoalState state = GoalState::kAccepted;
    int stamp = 0;
    Time ended;
  };
  std::map<GoalId, Goal> goals;
};

RC_GTEST_PROP(GoalsOfAServer, FollowTheModelInEveryOrderOfEvents, ()) {
  constexpr Duration kKept = std::chrono::seconds(5);
  ActionGoals goals({kKept, 1000});
  Model model;
  Time now;
  const int steps = *rc::gen::inRange(1, 80);
  for (int step = 1; step <= steps; ++step) {
    const GoalId id = Id(*rc::gen::inRange<std::uint8_t>(0, 6));
    const auto known = model.goals.find(id);
    switch (*rc::gen::inRange(0, 4)) {
      case 0: {
        const bool accepted = id != kNoGoalId && known == model.goals.end();
        RC_ASSERT(goals.Accept(id, At(step)) == accepted);
        if (accepted) model.goals[id] = {GoalState::kAccepted, step, {}};
        break;
      }
      case 1: {
        const GoalState to = *rc::gen::elementOf(kStates);
        const bool changes = known != model.goals.end() && IsTransition(known->second.state, to);
        RC_ASSERT(goals.Change(id, to, now) == changes);
        if (changes) known->second.state = to;
        if (changes && IsTerminal(to)) known->second.ended = now;
        break;
      }
      case 2: {
        now += std::chrono::seconds(*rc::gen::inRange(0, 4));
        const auto expired = goals.Expire(now);
        const auto gone = std::erase_if(model.goals, [&](const auto& goal) {
          return IsTerminal(goal.second.state) && goal.second.ended + kKept <= now;
        });
        RC_ASSERT(expired.size() == gone);
        break;
      }
      default: {
        const int stamp = *rc::gen::inRange(0, steps);
        const CancelChoice choice = goals.ChooseCancelled({{id}, At(stamp)});
        const bool all = id == kNoGoalId && stamp == 0;
        std::size_t chosen = 0;
        for (const auto& [each, goal] : model.goals) {
          const bool meant = all || each == id || (stamp != 0 && goal.stamp <= stamp);
          chosen += meant && IsActive(goal.state) ? 1 : 0;
        }
        RC_ASSERT(choice.goals.size() + choice.canceling.size() == chosen);
        for (const GoalId& each : choice.goals) {
          RC_ASSERT(IsTransition(goals.StateOf(each), GoalState::kCanceling));
        }
        const bool one = id != kNoGoalId && stamp == 0;
        RC_ASSERT((choice.return_code == msg::CancelGoal::kErrorNone) == (!one || chosen == 1));
      }
    }
    RC_ASSERT(goals.size() == model.goals.size());
    for (const auto& [each, goal] : model.goals) RC_ASSERT(goals.StateOf(each) == goal.state);
    for (const auto& status : goals.Statuses().status_list) {
      RC_ASSERT(model.goals.contains(status.goal_info.goal_id.uuid));
    }
  }
}

}  // namespace musher::transport::action_goals_test
