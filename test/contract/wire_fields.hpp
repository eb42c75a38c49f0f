#pragma once
// Field by field, by name: that a sample of a plain C program (idlc's struct) and one of Musher are
// the same. A field that is missing here is still caught when it makes the round trip.

#include <lifecycle_msgs.h>
#include <musher_msgs.h>
#include <protocol.h>
#include <std_msgs.h>

#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/lifecycle_msgs/transition_event.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/contract/wire_same.hpp"

namespace musher::msg {

MUSHER_SAME(std_msgs_msg_dds__String_, String) {
  SAME(data);
}

MUSHER_SAME(std_srvs_srv_dds__Trigger_Request_, Trigger::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(std_srvs_srv_dds__Trigger_Response_, Trigger::Response) {
  SAME(success);
  SAME(message);
}

MUSHER_SAME(protocol_msg_dds__Heartbeats_, Heartbeats) {
  SAME(name);
  SAME(state);
  SAME(timestamp);
  SAME(params);
}

MUSHER_SAME(protocol_srv_dds__FsMachine_Request_, FsMachine::Request) {
  SAME(target_state);
}

MUSHER_SAME(protocol_srv_dds__FsMachine_Response_, FsMachine::Response) {
  SAME(current_state);
  SAME(code);
}

MUSHER_SAME(lifecycle_msgs_msg_dds__State_, State) {
  SAME(id);
  SAME(label);
}

MUSHER_SAME(lifecycle_msgs_msg_dds__Transition_, Transition) {
  SAME(id);
  SAME(label);
}

MUSHER_SAME(lifecycle_msgs_msg_dds__TransitionEvent_, TransitionEvent) {
  SAME(timestamp);
  SAME(transition);
  SAME(start_state);
  SAME(goal_state);
}

MUSHER_SAME(lifecycle_msgs_srv_dds__ChangeState_Request_, ChangeState::Request) {
  SAME(transition);
}

MUSHER_SAME(lifecycle_msgs_srv_dds__ChangeState_Response_, ChangeState::Response) {
  SAME(success);
}

MUSHER_SAME(lifecycle_msgs_srv_dds__GetState_Request_, GetState::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(lifecycle_msgs_srv_dds__GetState_Response_, GetState::Response) {
  SAME(current_state);
}

MUSHER_SAME(musher_msgs_msg_dds__ActuatorStatus_, ActuatorStatus) {
  SAME(name);
  SAME(state);
  SAME(target);
  SAME(busy_number);
  SAME(epoch);
  SAME(number);
  SAME(outcome_number);
  SAME(outcome_code);
  SAME(outcome_message);
  SAME(incarnation);
  SAME(pid);
  SAME(host);
  SAME(config_hash);
  SAME(apart);
  SAME(emergency_stop);
  SAME(stamp_ns);
  SAME(held_by_stop);
  SAME(degraded_code);
  SAME(degraded_reason);
  SAME(emergency_stop_by);
  SAME(emergency_stop_reason);
}

MUSHER_SAME(musher_msgs_msg_dds__ActuatorInfo_, ActuatorInfo) {
  SAME(name);
  SAME(state);
  SAME(target);
  SAME(presence);
  SAME(pid);
  SAME(host);
  SAME(stage);
  SAME(critical);
  SAME(held);
  SAME(degraded);
  SAME(code);
  SAME(message);
  SAME(health);
  SAME(restarts);
  SAME(restarting);
  SAME(protocol);
}

MUSHER_SAME(musher_msgs_msg_dds__ActuatorBeat_, ActuatorBeat) {
  SAME(name);
  SAME(incarnation);
  SAME(period_ns);
  SAME(work);
  SAME(during);
  SAME(silent_ns);
  SAME(waited_ns);
}

MUSHER_SAME(musher_msgs_msg_dds__ControllerBeat_, ControllerBeat) {
  SAME(machine);
  SAME(epoch);
  SAME(incarnation);
  SAME(host);
  SAME(pid);
  SAME(period_ns);
}

MUSHER_SAME(musher_msgs_msg_dds__EmergencyStop_, EmergencyStop) {
  SAME(id);
  SAME(engaged);
  SAME(by);
  SAME(reason);
}

MUSHER_SAME(musher_msgs_msg_dds__PolicyInfo_, PolicyInfo) {
  SAME(active);
  SAME(battery);
  SAME(charging);
  SAME(battery_silent);
  SAME(ceiling);
  SAME(ceiling_reason);
  SAME(kept);
  SAME(keep_s);
  SAME(low_power_switch);
  SAME(power);
}

MUSHER_SAME(musher_msgs_msg_dds__MachineStatus_, MachineStatus) {
  SAME(machine);
  SAME(name_space);
  SAME(phase);
  SAME(state);
  SAME(target);
  SAME(epoch);
  SAME(switch_number);
  SAME(pid);
  SAME(host);
  SAME(config_file);
  SAME(config_hash);
  SAME(emergency_stop);
  SAME(emergency_stop_by);
  SAME(emergency_stop_reason);
  SAME_ITEMS(degraded);
  SAME_ITEMS(actuators);
  SAME(policy);
  SAME_ITEMS(not_on_disk);
  SAME_ITEMS(held_by_stop);
}

MUSHER_SAME(musher_msgs_msg_dds__MachineInfo_, MachineInfo) {
  SAME(machine);
  SAME(name_space);
  SAME(host);
  SAME(pid);
}

MUSHER_SAME(musher_msgs_msg_dds__ActuatorOutcome_, ActuatorOutcome) {
  SAME(name);
  SAME(outcome);
  SAME(code);
  SAME(message);
  SAME(duration_ms);
  SAME(state);
}

MUSHER_SAME(musher_msgs_msg_dds__PlanStep_, PlanStep) {
  SAME(name);
  SAME(wave);
  SAME(from);
  SAME(to);
  SAME(deadline_ms);
  SAME(note);
}

MUSHER_SAME(musher_msgs_msg_dds__HistoryEntry_, HistoryEntry) {
  SAME(id);
  SAME(wall_ns);
  SAME(epoch);
  SAME(switch_number);
  SAME(kind);
  SAME(actuator);
  SAME(code);
  SAME(message);
  SAME(cause);
  SAME(state);
  SAME(data);
}

MUSHER_SAME(musher_msgs_srv_dds__ActuatorCommand_Request_, ActuatorCommand::Request) {
  SAME(kind);
  SAME(epoch);
  SAME(number);
  SAME(target);
  SAME(budget_ns);
  SAME(status_stamp_ns);
  SAME(since_status_ns);
  SAME(incarnation);
  SAME(stop);
  SAME(apart);
}

MUSHER_SAME(musher_msgs_srv_dds__ActuatorCommand_Response_, ActuatorCommand::Response) {
  SAME(verdict);
  SAME(code);
  SAME(message);
  SAME(status);
}

MUSHER_SAME(musher_msgs_srv_dds__SetState_Request_, SetState::Request) {
  SAME(target);
  SAME(actuator);
}

MUSHER_SAME(musher_msgs_srv_dds__SetState_Response_, SetState::Response) {
  SAME(switch_number);
  SAME(target);
  SAME(actuator);
  SAME(outcome);
  SAME(code);
  SAME(reason);
  SAME(state);
  SAME_ITEMS(degraded);
  SAME_ITEMS(actuators);
}

MUSHER_SAME(musher_msgs_srv_dds__RequestPolicy_Request_, RequestPolicy::Request) {
  SAME(request);
  SAME(state);
  SAME(seconds);
  SAME(enable);
}

MUSHER_SAME(musher_msgs_srv_dds__RequestPolicy_Response_, RequestPolicy::Response) {
  SAME(code);
  SAME(reason);
  SAME(state);
}

MUSHER_SAME(musher_msgs_srv_dds__RestartActuator_Request_, RestartActuator::Request) {
  SAME(actuator);
}

MUSHER_SAME(musher_msgs_srv_dds__RestartActuator_Response_, RestartActuator::Response) {
  SAME(code);
  SAME(reason);
}

MUSHER_SAME(musher_msgs_srv_dds__ReleaseEmergencyStop_Request_, ReleaseEmergencyStop::Request) {
  SAME(by);
}

MUSHER_SAME(musher_msgs_srv_dds__ReleaseEmergencyStop_Response_, ReleaseEmergencyStop::Response) {
  SAME(code);
  SAME(reason);
}

MUSHER_SAME(musher_msgs_srv_dds__GetStatus_Request_, GetStatus::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(musher_msgs_srv_dds__GetStatus_Response_, GetStatus::Response) {
  SAME(status);
}

MUSHER_SAME(musher_msgs_msg_dds__Capability_, Capability) {
  SAME(name);
  SAME(description);
  SAME(allowed);
  SAME(code);
  SAME(reason);
  SAME_ITEMS(actuators);
  SAME_ITEMS(states);
}

MUSHER_SAME(musher_msgs_msg_dds__Capabilities_, Capabilities) {
  SAME_ITEMS(capabilities);
}

MUSHER_SAME(musher_msgs_srv_dds__GetCapabilities_Request_, GetCapabilities::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(musher_msgs_srv_dds__GetCapabilities_Response_, GetCapabilities::Response) {
  SAME_ITEMS(capabilities);
}

MUSHER_SAME(musher_msgs_srv_dds__GetPlan_Request_, GetPlan::Request) {
  SAME(target);
  SAME(actuator);
}

MUSHER_SAME(musher_msgs_srv_dds__GetPlan_Response_, GetPlan::Response) {
  SAME(target);
  SAME(actuator);
  SAME(allowed);
  SAME(code);
  SAME(reason);
  SAME(direction);
  SAME(state);
  SAME_ITEMS(steps);
}

MUSHER_SAME(musher_msgs_srv_dds__GetSwitch_Request_, GetSwitch::Request) {
  SAME(epoch);
  SAME(switch_number);
}

MUSHER_SAME(musher_msgs_srv_dds__GetSwitch_Response_, GetSwitch::Response) {
  SAME(found);
  SAME(epoch);
  SAME(switch_number);
  SAME(target);
  SAME(actuator);
  SAME(outcome);
  SAME(code);
  SAME(reason);
  SAME(state);
}

MUSHER_SAME(musher_msgs_srv_dds__GetHistory_Request_, GetHistory::Request) {
  SAME(since_wall_ns);
  SAME(limit);
}

MUSHER_SAME(musher_msgs_srv_dds__GetHistory_Response_, GetHistory::Response) {
  SAME(error);
  SAME_ITEMS(entries);
}

}  // namespace musher::msg
