#pragma once
// Asks an application what its state machine is like.

#include <string>
#include <variant>

#include "musher/controller/cli/link.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"

namespace musher::cli {

using BehaviorAnswer = std::variant<msg::GetBehavior::Response, Failure>;

// Of the actuator `name`. Fails, saying which, when nobody of that name runs, when it is no state
// machine, when it does not answer, and when the answer is an error.
BehaviorAnswer AskBehavior(Link& link, const GlobalOptions& global, const std::string& name,
                           const msg::GetBehavior::Request& request);

}  // namespace musher::cli
