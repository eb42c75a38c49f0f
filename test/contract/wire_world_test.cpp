// The messages of a humanoid's joints: as the IDL says.

#include <sensor_msgs_joints.h>

#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/test/contract/wire_exchange.hpp"
#include "musher/test/contract/wire_fields_ros.hpp"

namespace musher::msg {

MUSHER_SAME(sensor_msgs_msg_dds__JointState_, JointState) {
  SAME(header);
  SAME_ITEMS(name);
  SAME_ITEMS(position);
  SAME_ITEMS(velocity);
  SAME_ITEMS(effort);
}

}  // namespace musher::msg

namespace musher::transport::wire_world_test {

MESSAGE(sensor_msgs, JointState)

}  // namespace musher::transport::wire_world_test
