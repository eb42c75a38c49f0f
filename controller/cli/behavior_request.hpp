#pragma once
// Queries the state machine of an application.

#include <set>
#include <string>
#include <variant>

#include "musher/controller/cli/link.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"

namespace musher::cli {

using BehaviorAnswer = std::variant<msg::GetBehavior::Response, Failure>;

// Queries the actuator `name`. The Failure says whether no actuator of that name runs, it is not a
// state machine, it does not answer, or it answered with an error.
BehaviorAnswer QueryBehavior(Link& link, const GlobalOptions& global, const std::string& name,
                             const msg::GetBehavior::Request& request);

// The failure "no actuator '<name>' in namespace …"; `present`: the actuators that run there.
Failure NoSuchActuator(const Link& link, const GlobalOptions& global, const std::string& name,
                       const std::set<std::string>& present);

}  // namespace musher::cli
