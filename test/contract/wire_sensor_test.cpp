// The messages of a robot's range sensors and its GPS: as the IDL says.

#include <protocol_sensor.h>
#include <sensor_msgs_range.h>

#include "musher/messages/protocol/sensor.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/nav_sat_fix.hpp"
#include "musher/test/contract/wire_exchange.hpp"
#include "musher/test/contract/wire_fields_ros.hpp"

namespace musher::msg {

MUSHER_SAME(sensor_msgs_msg_dds__Range_, Range) {
  SAME(header);
  SAME(radiation_type);
  SAME(field_of_view);
  SAME(min_range);
  SAME(max_range);
  SAME(range);
  SAME(variance);
}

MUSHER_SAME(sensor_msgs_msg_dds__LaserScan_, LaserScan) {
  SAME(header);
  SAME(angle_min);
  SAME(angle_max);
  SAME(angle_increment);
  SAME(time_increment);
  SAME(scan_time);
  SAME(range_min);
  SAME(range_max);
  SAME_ITEMS(ranges);
  SAME_ITEMS(intensities);
}

MUSHER_SAME(sensor_msgs_msg_dds__NavSatStatus_, NavSatStatus) {
  SAME(status);
  SAME(service);
}

MUSHER_SAME(sensor_msgs_msg_dds__NavSatFix_, NavSatFix) {
  SAME(header);
  SAME(status);
  SAME(latitude);
  SAME(longitude);
  SAME(altitude);
  SAME(position_covariance);
  SAME(position_covariance_type);
}

MUSHER_SAME(protocol_msg_dds__UltrasonicPayload_, UltrasonicPayload) {
  SAME(ultrasonic_info);
}

MUSHER_SAME(protocol_msg_dds__SingleTofPayload_, SingleTofPayload) {
  SAME(header);
  SAME(data_available);
  SAME(tof_position);
  SAME_ITEMS(data);
  SAME_ITEMS(intensity);
}

MUSHER_SAME(protocol_msg_dds__HeadTofPayload_, HeadTofPayload) {
  SAME(left_head);
  SAME(right_head);
}

MUSHER_SAME(protocol_msg_dds__RearTofPayload_, RearTofPayload) {
  SAME(left_rear);
  SAME(right_rear);
}

MUSHER_SAME(protocol_msg_dds__GpsPayload_, GpsPayload) {
  SAME(sec);
  SAME(nanosec);
  SAME(itow);
  SAME(fix_type);
  SAME(num_sv);
  SAME(lon);
  SAME(lat);
}

MUSHER_SAME(protocol_srv_dds__SensorOperation_Request_, SensorOperation::Request) {
  SAME(sensor_id);
  SAME(operation);
}

MUSHER_SAME(protocol_srv_dds__SensorOperation_Response_, SensorOperation::Response) {
  SAME(success);
  SAME(code);
}

}  // namespace musher::msg

namespace musher::transport::wire_sensor_test {

MESSAGE(sensor_msgs, Range)
MESSAGE(sensor_msgs, LaserScan)
MESSAGE(sensor_msgs, NavSatStatus)
MESSAGE(sensor_msgs, NavSatFix)
MESSAGE(protocol, UltrasonicPayload)
MESSAGE(protocol, SingleTofPayload)
MESSAGE(protocol, HeadTofPayload)
MESSAGE(protocol, RearTofPayload)
MESSAGE(protocol, GpsPayload)
SERVICE(protocol, SensorOperation)

}  // namespace musher::transport::wire_sensor_test
