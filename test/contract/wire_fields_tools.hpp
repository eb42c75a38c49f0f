#pragma once
// The same for the types of ROS 2's tools: managed nodes, bonds, diagnostics, the log.

#include <bond.h>
#include <diagnostic_msgs.h>
#include <lifecycle_msgs_graph.h>
#include <rcl_interfaces.h>

#include "musher/messages/bond/status.hpp"
#include "musher/messages/diagnostic_msgs/diagnostic_array.hpp"
#include "musher/messages/lifecycle_msgs/graph.hpp"
#include "musher/messages/rcl_interfaces/log.hpp"
#include "musher/test/contract/wire_fields.hpp"
#include "musher/test/contract/wire_fields_ros.hpp"

namespace musher::msg {

MUSHER_SAME(lifecycle_msgs_msg_dds__TransitionDescription_, TransitionDescription) {
  SAME(transition);
  SAME(start_state);
  SAME(goal_state);
}

MUSHER_SAME(lifecycle_msgs_srv_dds__GetAvailableStates_Request_, GetAvailableStates::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(lifecycle_msgs_srv_dds__GetAvailableStates_Response_, GetAvailableStates::Response) {
  SAME_ITEMS(available_states);
}

MUSHER_SAME(lifecycle_msgs_srv_dds__GetAvailableTransitions_Request_,
            GetAvailableTransitions::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(lifecycle_msgs_srv_dds__GetAvailableTransitions_Response_,
            GetAvailableTransitions::Response) {
  SAME_ITEMS(available_transitions);
}

MUSHER_SAME(bond_msg_dds__Status_, BondStatus) {
  SAME(header);
  SAME(id);
  SAME(instance_id);
  SAME(active);
  SAME(heartbeat_timeout);
  SAME(heartbeat_period);
}

MUSHER_SAME(diagnostic_msgs_msg_dds__KeyValue_, KeyValue) {
  SAME(key);
  SAME(value);
}

MUSHER_SAME(diagnostic_msgs_msg_dds__DiagnosticStatus_, DiagnosticStatus) {
  SAME(level);
  SAME(name);
  SAME(message);
  SAME(hardware_id);
  SAME_ITEMS(values);
}

MUSHER_SAME(diagnostic_msgs_msg_dds__DiagnosticArray_, DiagnosticArray) {
  SAME(header);
  SAME_ITEMS(status);
}

MUSHER_SAME(rcl_interfaces_msg_dds__Log_, Log) {
  SAME(stamp);
  SAME(level);
  SAME(name);
  SAME(msg);
  SAME(file);
  SAME(function);
  SAME(line);
}

}  // namespace musher::msg
