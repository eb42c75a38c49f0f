#pragma once
// Queues and sequences of motions as a list of orders that the decision code plays.
//
// A queue names motions as the board does, by mode and gait. A sequence (motion_sequence_cmd) is
// played as far as a board goes by its table: a motion of the table, or a list of paces that say
// how fast to walk and for how long. Foot placements, gaits of one's own and TOML definitions need
// a board that takes them, and are refused with the reason (UnSupport) instead of half done.

#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/protocol/motion_sequence.hpp"
#include "musher/modules/motion/motion_command.hpp"

namespace musher::motion {

using Orders = std::vector<MotionOrder>;

Result<Orders> OrdersOf(const MotionTable& table, const msg::MotionQueueCustomCmd::Request& queue);
Result<Orders> OrdersOf(const msg::MotionSequenceShow::Request& sequence);
// Only a motion of the table can be executed; defining one needs a board that takes definitions.
Result<Orders> OrdersOf(const msg::MotionCustomCmd::Request& custom);

}  // namespace musher::motion
