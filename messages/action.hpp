#pragma once
// Action types as ROS 2 has them: two services and a message, which carry the goal, the result and
// the feedback. Reentrant, no global state.

#include "musher/messages/cdr.hpp"
#include "musher/messages/unique_identifier_msgs/uuid.hpp"

namespace musher::msg {

// A generated struct with the parts of an action (messages/README.md), such as msg::Fibonacci.
template <class A>
concept Action = requires {
  { A::kTypeName } -> std::convertible_to<std::string_view>;
}
&&Fielded<typename A::Goal>&& Fielded<typename A::Result>&& Fielded<typename A::Feedback>&& Service<
    typename A::SendGoal>&& Service<typename A::GetResult>&& Message<typename A::FeedbackMessage>;

}  // namespace musher::msg
