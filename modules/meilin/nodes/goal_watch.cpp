#include "musher/modules/meilin/nodes/goal_watch.hpp"

#include <chrono>

#include <fmt/format.h>

namespace musher::meilin {

using tree::Status;

std::string_view Name(GoalState state) {
  switch (state) {
    case GoalState::kWaiting:
      return "waiting";
    case GoalState::kSent:
      return "sent";
    case GoalState::kAccepted:
      return "accepted";
    case GoalState::kSucceeded:
      return "succeeded";
    case GoalState::kFailed:
      return "failed";
    case GoalState::kCancelled:
      return "cancelled";
    case GoalState::kRejected:
      return "rejected";
    case GoalState::kLost:
      return "lost";
    case GoalState::kUnavailable:
      return "unavailable";
  }
  return "";
}

std::string MoveClientName(const std::string& server) {
  return "Motion_control_accurate /" + server;
}

void GoalWatch::Begin(GoalPtr goal, Names names, double limit_s, Time now) {
  Cancel();
  goal_ = std::move(goal);
  names_ = std::move(names);
  limit_s_ = limit_s;
  begun_ = now;
  failure_.clear();
  status_ = Status::kRunning;
}

Status GoalWatch::Look(Time now) {
  if (status_ != Status::kRunning) return status_;
  const GoalState state = goal_->state();
  if (state == GoalState::kSucceeded) return status_ = Status::kSuccess;
  const std::chrono::duration<double> spent = now - begun_;
  if (HasEnded(state)) {
    failure_ = FailureText(spent.count());
    return status_ = Status::kFailure;
  }
  if (limit_s_ > 0 && spent.count() > limit_s_) {
    failure_ = fmt::format("{} timed out ({:g} s; the goal of {} is {}{})", names_.what, limit_s_,
                           names_.server, Name(state),
                           goal_->feedback().empty() ? "" : ", " + goal_->feedback());
    goal_->Cancel();
    return status_ = Status::kFailure;
  }
  return status_;
}

std::string GoalWatch::FailureText(double spent_s) const {
  const std::string& message = goal_->message();
  const std::string because = message.empty() ? "" : ": " + message;
  switch (goal_->state()) {
    case GoalState::kUnavailable:
      return names_.client + " action server not available" + because;
    case GoalState::kRejected:
      return "Goal rejected by " + names_.server + because;
    case GoalState::kLost:
      return names_.what + " lost its server " + names_.server + because;
    case GoalState::kCancelled:
      return names_.what + " was cancelled by " + names_.server + because;
    default:
      break;
  }
  std::string text = fmt::format("{}: {} after {:.0f} s ({}", names_.server,
                                 message.empty() ? "failed" : message, spent_s, names_.what);
  if (limit_s_ > 0) text += fmt::format(", of at most {:g} s", limit_s_);
  if (!goal_->feedback().empty()) text += "; " + goal_->feedback();
  return text + ")";
}

bool GoalWatch::accepted() const {
  if (goal_ == nullptr) return false;
  const GoalState state = goal_->state();
  return state == GoalState::kAccepted || state == GoalState::kSucceeded ||
         state == GoalState::kFailed || state == GoalState::kCancelled;
}

void GoalWatch::Cancel() {
  if (running()) goal_->Cancel();
  status_ = Status::kIdle;
}

void GoalWatch::Release() {
  goal_.reset();
  status_ = Status::kIdle;
}

}  // namespace musher::meilin
