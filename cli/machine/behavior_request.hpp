#pragma once
// Queries the state machine or the behaviour tree of an application.

#include <string>
#include <variant>

#include "musher/cli/machine/application_request.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/tree.hpp"

namespace musher::cli {

using BehaviorAnswer = std::variant<msg::GetBehavior::Response, Failure>;
using TreeAnswer = std::variant<msg::GetTree::Response, Failure>;

BehaviorAnswer QueryBehavior(Link& link, const GlobalOptions& global, const std::string& name,
                             const msg::GetBehavior::Request& request);
TreeAnswer QueryTree(Link& link, const GlobalOptions& global, const std::string& name,
                     const msg::GetTree::Request& request);

}  // namespace musher::cli
