// CyberDog's tasks, connection and older interfaces, its action Speech and its names: as the IDL
// says.

#include <protocol_speech.h>
#include <protocol_tasks.h>

#include "musher/messages/protocol/speech.hpp"
#include "musher/messages/protocol/tasks.hpp"
#include "musher/test/contract/wire_exchange.hpp"
#include "musher/test/contract/wire_fields_audio.hpp"
#include "musher/test/contract/wire_fields_ros.hpp"

namespace musher::msg {

MUSHER_SAME(unique_identifier_msgs_msg_dds__UUID_, Uuid) {
  Same(c.uuid, m, "uuid");
}

MUSHER_SAME(protocol_msg_dds__Bms_, Bms) {
  SAME(batt_volt);
  SAME(batt_curr);
  SAME(batt_soc);
  SAME(batt_temp);
  SAME(batt_st);
  SAME(key_val);
  SAME(disable_charge);
  SAME(power_supply);
  SAME(buzze);
  SAME(status);
  SAME(batt_health);
  SAME(batt_loop_number);
  SAME(powerboard_status);
}

MUSHER_SAME(protocol_msg_dds__ConnectorStatus_, ConnectorStatus) {
  SAME(is_connected);
  SAME(is_internet);
  SAME(ssid);
  SAME(robot_ip);
  SAME(provider_ip);
  SAME(strength);
  SAME(code);
}

MUSHER_SAME(protocol_msg_dds__AlgoTaskStatus_, AlgoTaskStatus) {
  SAME(task_status);
  SAME(task_sub_status);
}

MUSHER_SAME(protocol_srv_dds__ManagerInit_Request_, ManagerInit::Request) {
  SAME(structure_needs_at_least_one_member);
}

MUSHER_SAME(protocol_srv_dds__ManagerInit_Response_, ManagerInit::Response) {
  SAME(res_code);
}

MUSHER_SAME(protocol_srv_dds__TaskProcessor_Request_, TaskProcessor::Request) {
  SAME(processor);
}

MUSHER_SAME(protocol_srv_dds__TaskProcessor_Response_, TaskProcessor::Response) {
  SAME(purview);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__Trigger_Request_, ProtocolTrigger::Request) {
  SAME(data);
}

MUSHER_SAME(protocol_srv_dds__Trigger_Response_, ProtocolTrigger::Response) {
  SAME(success);
  SAME(message);
  SAME(code);
}

MUSHER_SAME(protocol_srv_dds__AudioNickName_Request_, AudioNickName::Request) {
  SAME(nick_name);
  SAME(wake_name);
}

MUSHER_SAME(protocol_srv_dds__AudioNickName_Response_, AudioNickName::Response) {
  SAME(success);
  SAME(code);
}

MUSHER_SAME(protocol_action_dds__Speech_Goal_, Speech::Goal) {
  SAME(module_name);
  SAME(is_online);
  SAME(speech);
  SAME(text);
}

MUSHER_SAME(protocol_action_dds__Speech_Result_, Speech::Result) {
  SAME(status);
}

MUSHER_SAME(protocol_action_dds__Speech_Feedback_, Speech::Feedback) {
  SAME(talking);
}

MUSHER_SAME(protocol_action_dds__Speech_FeedbackMessage_, Speech::FeedbackMessage) {
  SAME(goal_id);
  SAME(feedback);
}

MUSHER_SAME(protocol_action_dds__Speech_SendGoal_Request_, Speech::SendGoal::Request) {
  SAME(goal_id);
  SAME(goal);
}

MUSHER_SAME(protocol_action_dds__Speech_SendGoal_Response_, Speech::SendGoal::Response) {
  SAME(accepted);
  SAME(stamp);
}

MUSHER_SAME(protocol_action_dds__Speech_GetResult_Request_, Speech::GetResult::Request) {
  SAME(goal_id);
}

MUSHER_SAME(protocol_action_dds__Speech_GetResult_Response_, Speech::GetResult::Response) {
  SAME(status);
  SAME(result);
}

}  // namespace musher::msg

namespace musher::transport::wire_tasks_test {

MESSAGE(protocol, Bms)
MESSAGE(protocol, ConnectorStatus)
MESSAGE(protocol, AlgoTaskStatus)
SERVICE(protocol, ManagerInit)
SERVICE(protocol, TaskProcessor)
MUSHER_SERVICE(protocol, Trigger, ProtocolTrigger)
SERVICE(protocol, AudioNickName)

TEST_F(Wire, CarriesTheActionSpeechAsTheIdlSays) {
  using msg::Speech;
  ExchangeMessage<protocol_action_dds__Speech_Goal_, Speech::Goal>(
      protocol_action_dds__Speech_Goal__desc);
  ExchangeMessage<protocol_action_dds__Speech_Result_, Speech::Result>(
      protocol_action_dds__Speech_Result__desc);
  ExchangeMessage<protocol_action_dds__Speech_Feedback_, Speech::Feedback>(
      protocol_action_dds__Speech_Feedback__desc);
  ExchangeMessage<protocol_action_dds__Speech_FeedbackMessage_, Speech::FeedbackMessage>(
      protocol_action_dds__Speech_FeedbackMessage__desc);
  ExchangeService<protocol_action_dds__Speech_SendGoal_Request_,
                  protocol_action_dds__Speech_SendGoal_Response_, Speech::SendGoal>(
      protocol_action_dds__Speech_SendGoal_Request__desc,
      protocol_action_dds__Speech_SendGoal_Response__desc);
  ExchangeService<protocol_action_dds__Speech_GetResult_Request_,
                  protocol_action_dds__Speech_GetResult_Response_, Speech::GetResult>(
      protocol_action_dds__Speech_GetResult_Request__desc,
      protocol_action_dds__Speech_GetResult_Response__desc);
}

}  // namespace musher::transport::wire_tasks_test
