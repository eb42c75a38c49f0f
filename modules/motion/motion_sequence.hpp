#pragma once
// Queues and sequences of motions as a list of requests that the decision code plays.
//
// A queue names motions as the board does, by mode and gait. A sequence (motion_sequence_cmd) is
// played as far as a board's motion table permits: a motion of the table, or a list of paces with
// speed and duration. Gaits of users (user_gait.hpp) need a board that takes them; where it does
// not, they are refused with the reason (UnSupport) instead of half done.

#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/protocol/motion_sequence.hpp"
#include "musher/modules/motion/motion_command.hpp"

namespace musher::motion {

using MotionRequests = std::vector<MotionRequest>;

Result<MotionRequests> RequestsOf(const MotionTable& table,
                                  const msg::MotionQueueCustomCmd::Request& queue);
Result<MotionRequests> RequestsOf(const msg::MotionSequenceShow::Request& sequence);
// Of a board that takes no gaits: only a motion of the table can be executed.
Result<MotionRequests> RequestsOf(const msg::MotionCustomCmd::Request& custom);

}  // namespace musher::motion
