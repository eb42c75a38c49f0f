#pragma once
// ROS 2's mapping of actions on services and topics, and the samples that do not depend on the
// action's type.

#include <string>

#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/messages/cdr.hpp"
#include "musher/messages/unique_identifier_msgs/uuid.hpp"
#include "musher/transport/endpoint.hpp"

namespace musher::transport {

inline std::string SendGoalService(const std::string& action) {
  return action + "/_action/send_goal";
}
inline std::string GetResultService(const std::string& action) {
  return action + "/_action/get_result";
}
inline std::string CancelGoalService(const std::string& action) {
  return action + "/_action/cancel_goal";
}
inline std::string FeedbackTopic(const std::string& action) {
  return action + "/_action/feedback";
}
inline std::string StatusTopic(const std::string& action) {
  return action + "/_action/status";
}

// The names of an action's types on DDS.
struct ActionTypes {
  std::string send_goal;   // of a service: "example_interfaces::action::dds_::Fibonacci_SendGoal_"
  std::string get_result;  // of a service
  std::string feedback;    // of a message
};

namespace internal {

// The reply to send_goal.
struct SendGoalReply {
  msg::RequestId id;
  bool accepted = false;
  msg::Stamp stamp;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.id, m.accepted, m.stamp);
  }
};

// The beginning of a request of send_goal, and a whole request of get_result.
struct GoalRequest {
  msg::RequestId id;
  msg::Uuid goal_id;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.id, m.goal_id);
  }
};

// The beginning of a reply of get_result; the result follows.
struct ResultReply {
  msg::RequestId id;
  std::int8_t status = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.id, m.status);
  }
};

}  // namespace internal

}  // namespace musher::transport
