#pragma once
// The goals of one action server: their states, the choice of those that a cancel request means,
// and how long the results of ended goals are kept. Pure: the time is an argument. The server
// around it (raw_action_server.hpp) does the IO.
//
//   accepted --execute--> executing --succeed--> succeeded
//      |                   |    |   ---abort---> aborted
//      | cancel            |    '---- cancel
//      '--------------> canceling --end cancelled--> canceled
//                          '---- succeed, abort ---> succeeded, aborted
//
// succeeded, canceled and aborted are terminal. A goal that has ended is known until its result
// expires; after that its state is unknown and its id may be used again.
//
// Reentrant, no global state.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/messages/action_msgs/cancel_goal.hpp"
#include "musher/messages/action_msgs/goal_status.hpp"

namespace musher::transport {

using GoalId = decltype(msg::Uuid::uuid);

inline constexpr GoalId kNoGoalId{};

// ROS 2's, with its numbers.
enum class GoalState : std::int8_t {
  kUnknown = msg::GoalStatus::kStatusUnknown,
  kAccepted = msg::GoalStatus::kStatusAccepted,
  kExecuting = msg::GoalStatus::kStatusExecuting,
  kCanceling = msg::GoalStatus::kStatusCanceling,
  kSucceeded = msg::GoalStatus::kStatusSucceeded,
  kCanceled = msg::GoalStatus::kStatusCanceled,
  kAborted = msg::GoalStatus::kStatusAborted,
};

constexpr bool IsTerminal(GoalState state) {
  return state >= GoalState::kSucceeded && state <= GoalState::kAborted;
}
// Accepted and not ended.
constexpr bool IsActive(GoalState state) {
  return state != GoalState::kUnknown && !IsTerminal(state);
}
// "executing"
std::string_view GoalStateName(GoalState state);

// Whether ROS 2's state machine has that transition.
constexpr bool IsTransition(GoalState from, GoalState to) {
  switch (to) {
    case GoalState::kExecuting:
      return from == GoalState::kAccepted;
    case GoalState::kCanceling:
      return from == GoalState::kAccepted || from == GoalState::kExecuting;
    case GoalState::kSucceeded:
    case GoalState::kAborted:
      return from == GoalState::kExecuting || from == GoalState::kCanceling;
    case GoalState::kCanceled:
      return from == GoalState::kCanceling;
    default:
      return false;
  }
}

// How long the results of ended goals are kept.
struct ResultLimits {
  // After the end of the goal; zero: the result is only sent to the callers that wait for it.
  Duration timeout = std::chrono::minutes(15);
  std::size_t most = 1000;  // the oldest is discarded first
};

// The goals that a cancel request means.
struct CancelChoice {
  std::int8_t return_code = msg::CancelGoal::kErrorNone;
  std::vector<GoalId> goals;      // accepted or executing; may be cancelled
  std::vector<GoalId> canceling;  // canceling already; repeated in the reply
};

class ActionGoals {
 public:
  explicit ActionGoals(ResultLimits limits = {})
      : limits_{std::min(limits.timeout, Duration(kFarthestNs)), limits.most} {}

  // Adds a goal in the state accepted. False: the id is zero, which names no goal, or in use.
  bool Accept(const GoalId& id, const msg::Stamp& stamp);

  // False, and nothing changes, if the state machine does not have the transition.
  bool Change(const GoalId& id, GoalState to, Time now);

  GoalState StateOf(const GoalId& id) const;
  msg::GoalInfo InfoOf(const GoalId& id) const;  // of a known goal

  // Choice by ROS 2's rules: an id, a stamp, both or neither (action_msgs/cancel_goal.idl). A goal
  // that is cancelled already is in the reply once more, so that a request may be repeated.
  CancelChoice ChooseCancelled(const msg::GoalInfo& request) const;

  // Notes a request to cancel one goal that is not known: perhaps the request has overtaken its
  // goal. Other requests are ignored.
  void NoteEarlyCancel(const msg::GoalInfo& request, Time now);
  // Whether that was noted for this goal within the last minute: then it must not be accepted.
  bool WasCancelledEarly(const GoalId& id, Time now) const;
  static constexpr std::size_t kMostEarlyCancels = 1000;  // the oldest is dropped first

  // Forgets the goals whose results have expired, and returns them.
  std::vector<GoalId> Expire(Time now);
  // When Expire() has something to forget.
  std::optional<Time> NextExpiry() const;

  // All known goals in the order of their acceptance.
  msg::GoalStatusArray Statuses() const;
  std::size_t size() const { return goals_.size(); }

 private:
  struct Goal {
    GoalId id{};
    msg::Stamp stamp;
    GoalState state = GoalState::kAccepted;
  };
  struct Ended {
    GoalId id{};
    Time at;
  };
  struct EarlyCancel {
    GoalId id{};
    Time at;
  };
  using Number = std::uint64_t;  // in the order of acceptance

  const Goal* Find(const GoalId& id) const;

  ResultLimits limits_;
  Number accepted_ = 0;
  std::map<Number, Goal> goals_;
  std::map<GoalId, Number> numbers_;
  std::deque<Ended> ended_;                // in the order of their ends
  std::deque<EarlyCancel> early_cancels_;  // in the order of their times
};

}  // namespace musher::transport
