#pragma once
// Field by field, by name: that a sample of a plain C program (idlc's struct) and one of Musher are
// the same. A field that is missing here is still caught when it makes the round trip.

#include <builtin_interfaces.h>
#include <geometry_msgs.h>
#include <nav_msgs.h>
#include <rosgraph_msgs.h>
#include <sensor_msgs.h>
#include <std_msgs.h>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/sensor_msgs/imu.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/empty.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/test/contract/wire_same.hpp"

namespace musher::msg {

MUSHER_SAME(builtin_interfaces_msg_dds__Time_, Stamp) {
  SAME(sec);
  SAME(nanosec);
}

MUSHER_SAME(rosgraph_msgs_msg_dds__Clock_, Clock) {
  SAME(clock);
}

MUSHER_SAME(std_msgs_msg_dds__Header_, Header) {
  SAME(stamp);
  SAME(frame_id);
}

MUSHER_SAME(std_msgs_msg_dds__Bool_, Bool) {
  SAME(data);
}

MUSHER_SAME(std_msgs_msg_dds__UInt8_, UInt8) {
  SAME(data);
}

MUSHER_SAME(std_msgs_msg_dds__UInt16_, UInt16) {
  SAME(data);
}

MUSHER_SAME(std_msgs_msg_dds__Int32_, Int32) {
  SAME(data);
}

MUSHER_SAME(std_msgs_msg_dds__Float32_, Float32) {
  SAME(data);
}

MUSHER_SAME(std_msgs_msg_dds__ColorRGBA_, ColorRGBA) {
  SAME(r);
  SAME(g);
  SAME(b);
  SAME(a);
}

MUSHER_SAME(std_srvs_srv_dds__SetBool_Request_, SetBool::Request) {
  SAME(data);
}

MUSHER_SAME(std_srvs_srv_dds__SetBool_Response_, SetBool::Response) {
  SAME(success);
  SAME(message);
}

MUSHER_SAME(std_srvs_srv_dds__Empty_Request_, EmptyService::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(std_srvs_srv_dds__Empty_Response_, EmptyService::Response) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(geometry_msgs_msg_dds__Vector3_, Vector3) {
  SAME(x);
  SAME(y);
  SAME(z);
}

MUSHER_SAME(geometry_msgs_msg_dds__Point_, Point) {
  SAME(x);
  SAME(y);
  SAME(z);
}

MUSHER_SAME(geometry_msgs_msg_dds__Quaternion_, Quaternion) {
  SAME(x);
  SAME(y);
  SAME(z);
  SAME(w);
}

MUSHER_SAME(geometry_msgs_msg_dds__Pose_, Pose) {
  SAME(position);
  SAME(orientation);
}

MUSHER_SAME(geometry_msgs_msg_dds__PoseStamped_, PoseStamped) {
  SAME(header);
  SAME(pose);
}

MUSHER_SAME(geometry_msgs_msg_dds__Twist_, Twist) {
  SAME(linear);
  SAME(angular);
}

MUSHER_SAME(geometry_msgs_msg_dds__PoseWithCovariance_, PoseWithCovariance) {
  SAME(pose);
  SAME(covariance);
}

MUSHER_SAME(geometry_msgs_msg_dds__TwistWithCovariance_, TwistWithCovariance) {
  SAME(twist);
  SAME(covariance);
}

MUSHER_SAME(geometry_msgs_msg_dds__Transform_, Transform) {
  SAME(translation);
  SAME(rotation);
}

MUSHER_SAME(geometry_msgs_msg_dds__TransformStamped_, TransformStamped) {
  SAME(header);
  SAME(child_frame_id);
  SAME(transform);
}

MUSHER_SAME(nav_msgs_msg_dds__Odometry_, Odometry) {
  SAME(header);
  SAME(child_frame_id);
  SAME(pose);
  SAME(twist);
}

MUSHER_SAME(sensor_msgs_msg_dds__Imu_, Imu) {
  SAME(header);
  SAME(orientation);
  SAME(orientation_covariance);
  SAME(angular_velocity);
  SAME(angular_velocity_covariance);
  SAME(linear_acceleration);
  SAME(linear_acceleration_covariance);
}

MUSHER_SAME(sensor_msgs_msg_dds__BatteryState_, BatteryState) {
  SAME(header);
  SAME(voltage);
  SAME(temperature);
  SAME(current);
  SAME(charge);
  SAME(capacity);
  SAME(design_capacity);
  SAME(percentage);
  SAME(power_supply_status);
  SAME(power_supply_health);
  SAME(power_supply_technology);
  SAME(present);
  SAME_ITEMS(cell_voltage);
  SAME_ITEMS(cell_temperature);
  SAME(location);
  SAME(serial_number);
}

}  // namespace musher::msg
