// What an application's state machine publishes on the wire: as in the IDL.

#include <musher_msgs_behavior.h>

#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/test/contract/wire_exchange.hpp"
#include "musher/test/contract/wire_fields_ros.hpp"

namespace musher::msg {

MUSHER_SAME(musher_msgs_msg_dds__BehaviorChange_, BehaviorChange) {
  SAME(time_s);
  SAME(tick);
  SAME(from);
  SAME(to);
  SAME(cause);
  SAME(command);
}

MUSHER_SAME(musher_msgs_srv_dds__GetBehavior_Request_, GetBehavior::Request) {
  SAME(format);
  SAME(history);
}

MUSHER_SAME(musher_msgs_srv_dds__GetBehavior_Response_, GetBehavior::Response) {
  SAME(error);
  SAME(running);
  SAME(ticking);
  SAME(current_state);
  SAME(operating_mode);
  SAME(iter_count);
  SAME(safety_triggered);
  SAME(unsafe);
  SAME(time_s);
  SAME(time_in_state_s);
  SAME(last_fault);
  SAME(graph);
  SAME_ITEMS(history);
  SAME(held_by_stop);
  SAME_ITEMS(commands);
}

MUSHER_SAME(musher_msgs_srv_dds__SendCommand_Request_, SendCommand::Request) {
  SAME(command);
}

MUSHER_SAME(musher_msgs_srv_dds__SendCommand_Response_, SendCommand::Response) {
  SAME(success);
  SAME(message);
}

}  // namespace musher::msg

namespace musher::transport::wire_behavior_test {

MESSAGE(musher_msgs, BehaviorChange)
SERVICE(musher_msgs, GetBehavior)
SERVICE(musher_msgs, SendCommand)

}  // namespace musher::transport::wire_behavior_test
