#pragma once
// Field by field, by name: that a sample of a plain C program (idlc's struct) and one of Musher are
// the same. A field that is missing here is still caught when it makes the round trip.

#include <musher_msgs_body.h>
#include <protocol.h>

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/manager.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/protocol/motion_sequence.hpp"
#include "musher/test/contract/wire_fields_ros.hpp"

namespace musher::msg {

MUSHER_SAME(protocol_msg_dds__MotionServoCmd_, MotionServoCmd) {
  SAME(motion_id);
  SAME(cmd_type);
  SAME(cmd_source);
  SAME(value);
  SAME_ITEMS(vel_des);
  SAME_ITEMS(rpy_des);
  SAME_ITEMS(pos_des);
  SAME_ITEMS(acc_des);
  SAME_ITEMS(ctrl_point);
  SAME_ITEMS(foot_pose);
  SAME_ITEMS(step_height);
}

MUSHER_SAME(protocol_msg_dds__MotionServoResponse_, MotionServoResponse) {
  SAME(motion_id);
  SAME(cmd_id);
  SAME(order_process_bar);
  SAME(status);
  SAME(result);
  SAME(code);
}

MUSHER_SAME(protocol_msg_dds__MotionStatus_, MotionStatus) {
  SAME(motion_id);
  SAME(contact);
  SAME(order_process_bar);
  SAME(switch_status);
  SAME(ori_error);
  SAME(footpos_error);
  SAME_ITEMS(motor_error);
}

MUSHER_SAME(protocol_msg_dds__MotionCustomCmd_, MotionCustomCommand) {
  SAME(mode);
  SAME(gait_id);
  SAME(contact);
  SAME(life_count);
  SAME_ITEMS(vel_des);
  SAME_ITEMS(rpy_des);
  SAME_ITEMS(pos_des);
  SAME_ITEMS(acc_des);
  SAME_ITEMS(ctrl_point);
  SAME_ITEMS(foot_pose);
  SAME_ITEMS(step_height);
  SAME(value);
  SAME(duration);
}

MUSHER_SAME(protocol_srv_dds__MotionResultCmd_Request_, MotionResultCmd::Request) {
  SAME(motion_id);
  SAME(cmd_source);
  SAME_ITEMS(vel_des);
  SAME_ITEMS(rpy_des);
  SAME_ITEMS(pos_des);
  SAME_ITEMS(acc_des);
  SAME_ITEMS(ctrl_point);
  SAME_ITEMS(foot_pose);
  SAME_ITEMS(step_height);
  SAME(duration);
  SAME(value);
  SAME(contact);
  SAME(gait_toml);
  SAME(toml_data);
}

MUSHER_SAME(protocol_srv_dds__MotionResultCmd_Response_, MotionResultCmd::Response) {
  SAME(motion_id);
  SAME(result);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__MotionCustomCmd_Request_, MotionCustomCmd::Request) {
  SAME(cmd_type);
  SAME(cmd_source);
  SAME(motion_id);
}

MUSHER_SAME(protocol_srv_dds__MotionCustomCmd_Response_, MotionCustomCmd::Response) {
  SAME(motion_id);
  SAME(result);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__MotionQueueCustomCmd_Request_, MotionQueueCustomCmd::Request) {
  SAME_ITEMS(cmds);
}

MUSHER_SAME(protocol_srv_dds__MotionQueueCustomCmd_Response_, MotionQueueCustomCmd::Response) {
  SAME(result);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__MotorTemp_Request_, MotorTemp::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(protocol_srv_dds__MotorTemp_Response_, MotorTemp::Response) {
  SAME(result);
  SAME_ITEMS(motor_temp);
  SAME(code);
}

MUSHER_SAME(protocol_msg_dds__MotionSequenceGait_, MotionSequenceGait) {
  SAME(right_forefoot);
  SAME(left_forefoot);
  SAME(right_hindfoot);
  SAME(left_hindfoot);
  SAME(duration);
}

MUSHER_SAME(protocol_msg_dds__MotionSequencePace_, MotionSequencePace) {
  SAME(twist);
  SAME(centroid);
  SAME(weight);
  SAME(right_forefoot);
  SAME(left_forefoot);
  SAME(right_hindfoot);
  SAME(left_hindfoot);
  SAME(friction_coefficient);
  SAME(landing_gain);
  SAME(use_mpc_track);
  SAME(duration);
}

MUSHER_SAME(protocol_msg_dds__MotionSequenceParam_, MotionSequenceParam) {
  SAME(twist);
  SAME(centroid_height);
  SAME(right_forefoot);
  SAME(left_forefoot);
  SAME(right_hindfoot);
  SAME(left_hindfoot);
  SAME(forefoot_height);
  SAME(hindfoot_height);
  SAME(friction_coefficient);
  SAME(duration_ms);
}

MUSHER_SAME(protocol_srv_dds__MotionSequenceShow_Request_, MotionSequenceShow::Request) {
  SAME(motion_id);
  SAME(cmd_source);
  SAME(duration);
  SAME_ITEMS(gait_list);
  SAME_ITEMS(pace_list);
  SAME_ITEMS(gait_toml_list);
  SAME_ITEMS(pace_toml_list);
  SAME(gait_toml);
  SAME(pace_toml);
}

MUSHER_SAME(protocol_srv_dds__MotionSequenceShow_Response_, MotionSequenceShow::Response) {
  SAME(result);
  SAME(code);
  SAME(describe);
  SAME(motion_id);
}

MUSHER_SAME(protocol_srv_dds__MotionSequence_Request_, MotionSequence::Request) {
  SAME(motion_id);
  SAME(duration);
  SAME(toml_data);
  SAME_ITEMS(params);
}

MUSHER_SAME(protocol_srv_dds__MotionSequence_Response_, MotionSequence::Response) {
  SAME(result);
  SAME(code);
  SAME(describe);
  SAME(motion_id);
}

MUSHER_SAME(protocol_msg_dds__BmsStatus_, BmsStatus) {
  SAME(header);
  SAME(batt_volt);
  SAME(batt_curr);
  SAME(batt_soc);
  SAME(batt_temp);
  SAME(power_adapter_temp);
  SAME(wireless_charging_temp);
  SAME(batt_st);
  SAME(bms_state_one);
  SAME(bms_state_two);
  SAME(batt_health);
  SAME(batt_loop_number);
  SAME(power_normal);
  SAME(power_wired_charging);
  SAME(power_finished_charging);
  SAME(power_motor_shutdown);
  SAME(power_soft_shutdown);
  SAME(power_wp_place);
  SAME(power_wp_charging);
  SAME(power_expower_supply);
  SAME(charge_over_current);
  SAME(discharge_over_current);
  SAME(cell_over_voltage);
  SAME(cell_under_voltage);
  SAME(cell_volt_abnormal);
  SAME(mos_over_temp);
  SAME(discharge_short);
  SAME(fuse);
  SAME(discharge_over_tmp);
  SAME(discharge_under_tmp);
  SAME(charge_over_temp);
  SAME(charge_under_temp);
  SAME(charge_mos_state);
  SAME(discharge_mos_state);
  SAME(chg_mos_fault);
  SAME(dsg_mos_fault);
}

MUSHER_SAME(protocol_msg_dds__TouchStatus_, TouchStatus) {
  SAME(header);
  SAME(touch_state);
  SAME(timestamp);
}

MUSHER_SAME(protocol_msg_dds__UwbRaw_, UwbRaw) {
  SAME(header);
  SAME(dist);
  SAME(angle);
  SAME(n_los);
  SAME(rssi_1);
  SAME(rssi_2);
}

MUSHER_SAME(protocol_srv_dds__LedExecute_Request_, LedExecute::Request) {
  SAME(occupation);
  SAME(client);
  SAME(target);
  SAME(mode);
  SAME(effect);
  SAME(r_value);
  SAME(g_value);
  SAME(b_value);
}

MUSHER_SAME(protocol_srv_dds__LedExecute_Response_, LedExecute::Response) {
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__BmsCmd_Request_, BmsCmd::Request) {
  SAME(electric_machine_command);
  SAME(wireless_charging_command);
}

MUSHER_SAME(protocol_srv_dds__BmsCmd_Response_, BmsCmd::Response) {
  SAME(success);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__BmsInfo_Request_, BmsInfo::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(protocol_srv_dds__BmsInfo_Response_, BmsInfo::Response) {
  SAME(msg);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__GetUWBMacSessionID_Request_, GetUWBMacSessionID::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(protocol_srv_dds__GetUWBMacSessionID_Response_, GetUWBMacSessionID::Response) {
  SAME(session_id);
  SAME(master);
  SAME(slave1);
  SAME(slave2);
  SAME(slave3);
  SAME(slave4);
  SAME(code);
}

MUSHER_SAME(protocol_msg_dds__StateSwitchStatus_, StateSwitchStatus) {
  SAME(state);
  SAME(code);
}

MUSHER_SAME(protocol_msg_dds__SelfCheckStatus_, SelfCheckStatus) {
  SAME(code);
  SAME(description);
}

MUSHER_SAME(protocol_msg_dds__NodeError_, NodeError) {
  SAME(name);
  SAME(code);
}

MUSHER_SAME(protocol_msg_dds__ManagerState_, ManagerState) {
  SAME(state);
  SAME(err_msg);
}

MUSHER_SAME(protocol_srv_dds__MachineState_Request_, MachineState::Request) {
  SAME(state);
  SAME(ticks);
}

MUSHER_SAME(protocol_srv_dds__MachineState_Response_, MachineState::Response) {
  SAME(success);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__DeviceInfo_Request_, DeviceInfo::Request) {
  SAME_ITEMS(enables);
  SAME(uid);
}

MUSHER_SAME(protocol_srv_dds__DeviceInfo_Response_, DeviceInfo::Response) {
  SAME(info);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__UidSn_Request_, UidSn::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(protocol_srv_dds__UidSn_Response_, UidSn::Response) {
  SAME(uid);
  SAME(sn);
  SAME(code);
}

MUSHER_SAME(musher_msgs_msg_dds__BodyState_, BodyState) {
  SAME(header);
  SAME(mode);
  SAME(gait_id);
  SAME(contact);
  SAME(order_process_bar);
  SAME(switch_status);
  SAME(ori_error);
  SAME(footpos_error);
  SAME(motor_error);
  SAME(motor_temperature);
  SAME(life_count);
  SAME(pose);
  SAME(twist);
  SAME(linear_acceleration);
}

MUSHER_SAME(musher_msgs_msg_dds__LedState_, LedState) {
  SAME(target);
  SAME(mode);
  SAME(effect);
  SAME(r);
  SAME(g);
  SAME(b);
  SAME(client);
}

}  // namespace musher::msg
