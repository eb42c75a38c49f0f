// The messages of the wedding robot that no other robot has: as the IDL says.

#include <geometry_msgs_point.h>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/test/contract/wire_exchange.hpp"
#include "musher/test/contract/wire_fields_ros.hpp"

namespace musher::msg {

MUSHER_SAME(geometry_msgs_msg_dds__PointStamped_, PointStamped) {
  SAME(header);
  SAME(point);
}

}  // namespace musher::msg

namespace musher::transport::wire_wedding_test {

MESSAGE(geometry_msgs, PointStamped)

}  // namespace musher::transport::wire_wedding_test
