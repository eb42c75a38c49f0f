#include "musher/transport/action_goals.hpp"

#include "musher/base/check.hpp"
#include "musher/messages/stamp.hpp"

namespace musher::transport {

std::string_view GoalStateName(GoalState state) {
  switch (state) {
    case GoalState::kAccepted:
      return "accepted";
    case GoalState::kExecuting:
      return "executing";
    case GoalState::kCanceling:
      return "canceling";
    case GoalState::kSucceeded:
      return "succeeded";
    case GoalState::kCanceled:
      return "canceled";
    case GoalState::kAborted:
      return "aborted";
    case GoalState::kUnknown:
      break;
  }
  return "unknown";
}

bool ActionGoals::Accept(const GoalId& id, const msg::Stamp& stamp) {
  if (id == kNoGoalId || !numbers_.emplace(id, accepted_).second) return false;
  goals_.emplace(accepted_, Goal{id, stamp});
  ++accepted_;
  return true;
}

bool ActionGoals::Change(const GoalId& id, GoalState to, Time now) {
  const auto number = numbers_.find(id);
  if (number == numbers_.end()) return false;
  Goal& goal = goals_.at(number->second);
  if (!IsTransition(goal.state, to)) return false;
  goal.state = to;
  if (IsTerminal(to)) ended_.push_back({id, now});
  return true;
}

const ActionGoals::Goal* ActionGoals::Find(const GoalId& id) const {
  const auto number = numbers_.find(id);
  return number == numbers_.end() ? nullptr : &goals_.at(number->second);
}

GoalState ActionGoals::StateOf(const GoalId& id) const {
  const Goal* goal = Find(id);
  return goal == nullptr ? GoalState::kUnknown : goal->state;
}

msg::GoalInfo ActionGoals::InfoOf(const GoalId& id) const {
  const Goal* goal = Find(id);
  MUSHER_CHECK(goal != nullptr);
  return {{id}, goal->stamp};
}

CancelChoice ActionGoals::ChooseCancelled(const msg::GoalInfo& request) const {
  const GoalId& id = request.goal_id.uuid;
  const bool has_stamp = request.stamp != msg::Stamp{};
  const bool one_goal = id != kNoGoalId && !has_stamp;
  const bool all_goals = id == kNoGoalId && !has_stamp;
  const auto until = msg::FromStamp(request.stamp);
  CancelChoice choice;
  for (const auto& [number, goal] : goals_) {
    const bool early = all_goals || (has_stamp && msg::FromStamp(goal.stamp) <= until);
    if (goal.id != id && !early) continue;
    if (IsTransition(goal.state, GoalState::kCanceling)) {
      choice.goals.push_back(goal.id);
    } else if (goal.state == GoalState::kCanceling) {
      choice.canceling.push_back(goal.id);
    } else if (one_goal) {
      choice.return_code = msg::CancelGoal::kErrorGoalTerminated;
    }
  }
  if (one_goal && Find(id) == nullptr) choice.return_code = msg::CancelGoal::kErrorUnknownGoalId;
  return choice;
}

void ActionGoals::NoteEarlyCancel(const msg::GoalInfo& request, Time now) {
  const GoalId& id = request.goal_id.uuid;
  if (id == kNoGoalId || request.stamp != msg::Stamp{} || Find(id) != nullptr) return;
  std::erase_if(early_cancels_, [&](const EarlyCancel& noted) { return noted.id == id; });
  early_cancels_.push_back({id, now});
  if (early_cancels_.size() > kMostEarlyCancels) early_cancels_.pop_front();
}

bool ActionGoals::WasCancelledEarly(const GoalId& id, Time now) const {
  constexpr Duration kKept = std::chrono::minutes(1);
  return std::ranges::any_of(early_cancels_, [&](const EarlyCancel& noted) {
    return noted.id == id && now - noted.at < kKept;
  });
}

std::vector<GoalId> ActionGoals::Expire(Time now) {
  std::vector<GoalId> expired;
  while (!ended_.empty() &&
         (ended_.size() > limits_.most || ended_.front().at + limits_.timeout <= now)) {
    const GoalId& id = expired.emplace_back(ended_.front().id);
    goals_.erase(numbers_.at(id));
    numbers_.erase(id);
    ended_.pop_front();
  }
  return expired;
}

std::optional<Time> ActionGoals::NextExpiry() const {
  if (ended_.empty()) return std::nullopt;
  const Time first = ended_.front().at;
  return ended_.size() > limits_.most ? first : first + limits_.timeout;
}

msg::GoalStatusArray ActionGoals::Statuses() const {
  msg::GoalStatusArray statuses;
  for (const auto& [number, goal] : goals_) {
    statuses.status_list.push_back({{{goal.id}, goal.stamp}, static_cast<std::int8_t>(goal.state)});
  }
  return statuses;
}

}  // namespace musher::transport
