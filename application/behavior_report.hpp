#pragma once
// A state machine as others are told of it. Plain function, no IO.

#include "musher/behavior/fsm/machine.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"

namespace musher {

// `ticking`: it is not paused. The answer has an `error` when the request asks for what there is
// not.
msg::GetBehavior::Response ReportBehavior(const fsm::Machine& machine, bool ticking,
                                          const msg::GetBehavior::Request& request);

}  // namespace musher
