// A client of a skill's action, as rclcpp has it on the wire: plain C with idlc's types.
//
//   skill_client_peer <domain> <action> <skill> <parameter> <value> [cancel]
//
// Reads the offered skills, sends one goal, and prints what it receives, a line each. With `cancel`
// it cancels the goal after its first feedback. It exits with the result.

#include "action_peer.h"

typedef plan_msgs_action_dds__SkillExecution_SendGoal_Request_ SkillGoal;
typedef plan_msgs_action_dds__SkillExecution_SendGoal_Response_ SkillGoalReply;
typedef plan_msgs_action_dds__SkillExecution_GetResult_Request_ SkillResultRequest;
typedef plan_msgs_action_dds__SkillExecution_GetResult_Response_ SkillResult;
typedef plan_msgs_action_dds__SkillExecution_FeedbackMessage_ SkillFeedbackMessage;
typedef musher_msgs_msg_dds__SkillOffers_ SkillOffers;

static dds_entity_t goal_writer, goal_reader, result_writer, result_reader, cancel_writer,
    cancel_reader, feedback_reader, offers_reader;
static uint64_t client;
static uint8_t goal_id[kIdSize];  // of this client alone
static bool offered, accepted, cancels, awaits_cancel, ended;
static int feedbacks;

static void OnOffers(const SkillOffers* offers) {
  offered = true;
  printf("offered by %s on %s:", offers->actuator, offers->action);
  for (uint32_t i = 0; i < offers->skills._length; ++i) {
    printf(" %s", offers->skills._buffer[i].skill);
  }
  printf("\n");
}

static void OnGoalReply(const SkillGoalReply* reply) {
  if (reply->client_id != client) return;
  accepted = reply->accepted;
  printf("%s\n", accepted ? "accepted" : "rejected");
  SkillResultRequest request = {.client_id = client, .sequence_number = 1};
  memcpy(request.goal_id.uuid, goal_id, kIdSize);
  dds_write(result_writer, &request);
}

static void OnFeedback(const SkillFeedbackMessage* message) {
  if (memcmp(message->goal_id.uuid, goal_id, kIdSize) != 0 || ++feedbacks > 1) return;
  printf("feedback: %s\n", message->feedback.status);
  if (!cancels) return;
  CancelRequest request = {.client_id = client, .sequence_number = 1};
  memcpy(request.goal_info.goal_id.uuid, goal_id, kIdSize);
  dds_write(cancel_writer, &request);
  awaits_cancel = true;
}

static void OnCancelReply(const CancelReply* reply) {
  if (reply->client_id != client) return;
  printf("cancel: code %d\n", reply->return_code);
  awaits_cancel = false;
}

static void OnResult(const SkillResult* reply) {
  if (reply->client_id != client) return;
  printf("result of status %d: %s %s\n", reply->status, reply->result.success ? "true" : "false",
         reply->result.message);
  ended = true;
}

static void SendGoal(char* skill, char* key, char* value) {
  plan_msgs_msg_dds__Parameter_ parameter = {.key = key, .value = value};
  plan_msgs_msg_dds__SkillInfo_ info = {.skill = skill, .object_id = "", .task_id = ""};
  info.params._maximum = info.params._length = 1;
  info.params._buffer = &parameter;
  SkillGoal request = {.client_id = client, .sequence_number = 1};
  memcpy(request.goal_id.uuid, goal_id, kIdSize);
  request.goal.skill_request.robot_id = "";
  request.goal.skill_request.skill_list._maximum = 1;
  request.goal.skill_request.skill_list._length = 1;
  request.goal.skill_request.skill_list._buffer = &info;
  dds_write(goal_writer, &request);
}

static void Open(const char* action) {
  offers_reader = Reader(&musher_msgs_msg_dds__SkillOffers__desc, "rt/%s", "skills", true);
  feedback_reader = Reader(&plan_msgs_action_dds__SkillExecution_FeedbackMessage__desc,
                           "rt/%s/_action/feedback", action, false);
  goal_reader = Reader(&plan_msgs_action_dds__SkillExecution_SendGoal_Response__desc,
                       "rr/%s/_action/send_goalReply", action, false);
  goal_writer = Writer(&plan_msgs_action_dds__SkillExecution_SendGoal_Request__desc,
                       "rq/%s/_action/send_goalRequest", action, false);
  result_reader = Reader(&plan_msgs_action_dds__SkillExecution_GetResult_Response__desc,
                         "rr/%s/_action/get_resultReply", action, false);
  result_writer = Writer(&plan_msgs_action_dds__SkillExecution_GetResult_Request__desc,
                         "rq/%s/_action/get_resultRequest", action, false);
  cancel_reader = Reader(&action_msgs_srv_dds__CancelGoal_Response__desc,
                         "rr/%s/_action/cancel_goalReply", action, false);
  cancel_writer = Writer(&action_msgs_srv_dds__CancelGoal_Request__desc,
                         "rq/%s/_action/cancel_goalRequest", action, false);
  dds_get_instance_handle(goal_writer, &client);
  memcpy(goal_id, &client, sizeof(client));
}

static bool Matched(void) {
  return WriterMatched(goal_writer) && ReaderMatched(goal_reader) && WriterMatched(result_writer) &&
         ReaderMatched(result_reader) && WriterMatched(cancel_writer) &&
         ReaderMatched(cancel_reader) && ReaderMatched(feedback_reader);
}

int main(int argc, char** argv) {
  if (argc < 6 || !OpenParticipant(argv[1])) return EXIT_FAILURE;
  cancels = argc > 6;
  Open(argv[2]);
  bool sent = false;
  const dds_time_t end = dds_time() + DDS_SECS(300);
  while (dds_time() < end && (!ended || awaits_cancel)) {  // the result may come first
    if (!sent && offered && Matched()) {
      SendGoal(argv[3], argv[4], argv[5]);
      sent = true;
    }
    dds_waitset_wait_until(waitset, NULL, 0, end);
    TAKE_ALL(offers_reader, OnOffers);
    TAKE_ALL(goal_reader, OnGoalReply);
    if (accepted) TAKE_ALL(feedback_reader, OnFeedback);  // DDS orders no two topics
    TAKE_ALL(cancel_reader, OnCancelReply);
    TAKE_ALL(result_reader, OnResult);
  }
  return ended ? EXIT_SUCCESS : EXIT_FAILURE;
}
