// A client of a Fibonacci action, as rclcpp has it on the wire.
//
//   action_client_peer <domain> <action> <order> [cancel]
//
// Sends one goal and prints what it receives, a line each. With `cancel` it cancels the goal after
// the first feedback. When the goal has ended it requests the result once more, and that of a goal
// that does not exist, then exits.

#include "action_peer.h"

static dds_entity_t goal_writer, goal_reader, result_writer, result_reader, cancel_writer,
    cancel_reader, feedback_reader, status_reader;
static uint64_t client;
static const uint8_t kGoal[kIdSize] = {1, 2, 3};
static bool accepted, rejected, cancels;
static int last_status = kUnknown, feedbacks, results;

static void PrintSequence(const char* what, const dds_sequence_int32* sequence) {
  printf("%s:", what);
  for (uint32_t i = 0; i < sequence->_length; ++i) printf(" %d", sequence->_buffer[i]);
  printf("\n");
}

static void RequestResult(uint8_t first_byte, int64_t sequence) {
  ResultRequest request = {.client_id = client, .sequence_number = sequence};
  memcpy(request.goal_id.uuid, kGoal, kIdSize);
  request.goal_id.uuid[0] = first_byte;
  dds_write(result_writer, &request);
}

static void OnGoalReply(const GoalReply* reply) {
  if (reply->client_id != client) return;
  accepted = reply->accepted;
  rejected = !accepted;
  printf("%s%s\n", accepted ? "accepted" : "rejected", reply->stamp.sec > 0 ? " at a time" : "");
  if (accepted) RequestResult(kGoal[0], 1);
}

static void OnFeedback(const Feedback* feedback) {
  if (memcmp(feedback->goal_id.uuid, kGoal, kIdSize) != 0) return;
  PrintSequence("feedback", &feedback->feedback.sequence);
  if (++feedbacks > 1 || !cancels) return;
  CancelRequest request = {.client_id = client, .sequence_number = 1};
  memcpy(request.goal_info.goal_id.uuid, kGoal, kIdSize);
  dds_write(cancel_writer, &request);
}

static void OnCancelReply(const CancelReply* reply) {
  if (reply->client_id != client) return;
  printf("cancel: code %d, %u canceling\n", reply->return_code, reply->goals_canceling._length);
}

static void OnStatuses(const Statuses* statuses) {
  for (uint32_t i = 0; i < statuses->status_list._length; ++i) {
    const action_msgs_msg_dds__GoalStatus_* status = &statuses->status_list._buffer[i];
    if (memcmp(status->goal_info.goal_id.uuid, kGoal, kIdSize) == 0) last_status = status->status;
  }
}

static void OnResult(const ResultReply* reply) {
  if (reply->client_id != client) return;
  char what[kNameSize];
  snprintf(what, sizeof(what), "result %d of status %d", (int)reply->sequence_number,
           reply->status);
  PrintSequence(what, &reply->result.sequence);
  ++results;
  if (results == 1) RequestResult(kGoal[0], 2);
  if (results == 2) RequestResult(99, 3);
}

static bool Matched(void) {
  return WriterMatched(goal_writer) && ReaderMatched(goal_reader) && WriterMatched(result_writer) &&
         ReaderMatched(result_reader) && WriterMatched(cancel_writer) &&
         ReaderMatched(cancel_reader) && ReaderMatched(feedback_reader) &&
         ReaderMatched(status_reader);
}

int main(int argc, char** argv) {
  if (argc < 4 || !OpenParticipant(argv[1])) return EXIT_FAILURE;
  const char* action = argv[2];
  cancels = argc > 4;
  feedback_reader = Reader(&example_interfaces_action_dds__Fibonacci_FeedbackMessage__desc,
                           "rt/%s/_action/feedback", action, false);
  status_reader =
      Reader(&action_msgs_msg_dds__GoalStatusArray__desc, "rt/%s/_action/status", action, true);
  goal_reader = Reader(&example_interfaces_action_dds__Fibonacci_SendGoal_Response__desc,
                       "rr/%s/_action/send_goalReply", action, false);
  goal_writer = Writer(&example_interfaces_action_dds__Fibonacci_SendGoal_Request__desc,
                       "rq/%s/_action/send_goalRequest", action, false);
  result_reader = Reader(&example_interfaces_action_dds__Fibonacci_GetResult_Response__desc,
                         "rr/%s/_action/get_resultReply", action, false);
  result_writer = Writer(&example_interfaces_action_dds__Fibonacci_GetResult_Request__desc,
                         "rq/%s/_action/get_resultRequest", action, false);
  cancel_reader = Reader(&action_msgs_srv_dds__CancelGoal_Response__desc,
                         "rr/%s/_action/cancel_goalReply", action, false);
  cancel_writer = Writer(&action_msgs_srv_dds__CancelGoal_Request__desc,
                         "rq/%s/_action/cancel_goalRequest", action, false);
  dds_get_instance_handle(goal_writer, &client);
  bool sent = false;
  const dds_time_t end = dds_time() + DDS_SECS(120);
  while (dds_time() < end && !rejected && (results < 3 || last_status < kSucceeded)) {
    if (!sent && Matched()) {
      GoalRequest request = {.client_id = client, .sequence_number = 1};
      memcpy(request.goal_id.uuid, kGoal, kIdSize);
      request.goal.order = atoi(argv[3]);
      dds_write(goal_writer, &request);
      sent = true;
    }
    dds_waitset_wait_until(waitset, NULL, 0, end);
    TAKE_ALL(goal_reader, OnGoalReply);
    if (accepted) TAKE_ALL(feedback_reader, OnFeedback);  // DDS orders no two topics
    TAKE_ALL(cancel_reader, OnCancelReply);
    TAKE_ALL(status_reader, OnStatuses);
    TAKE_ALL(result_reader, OnResult);
  }
  printf("last status %d\n", last_status);
  return rejected || results == 3 ? EXIT_SUCCESS : EXIT_FAILURE;
}
