#pragma once
// The status of a state machine as a message. Plain function, no IO.

#include "musher/behavior/fsm/machine.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"

namespace musher {

// `ticking`: it is not paused. The response has an `error` when the request has an unknown format.
msg::GetBehavior::Response ReportBehavior(const fsm::Machine& machine, bool ticking,
                                          const msg::GetBehavior::Request& request);

}  // namespace musher
