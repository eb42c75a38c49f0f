// A server of a Fibonacci action, as rclcpp has it on the wire, with one goal at a time.
//
//   action_server_peer <domain> <action>     until it is killed
//
// Rejects an order below 0. Ends a goal of an order up to 20 at once, with a feedback for each
// number; one of a larger order when it is cancelled.

#include "action_peer.h"

enum { kMostNumbers = 20 };

static dds_entity_t goal_writer, goal_reader, result_writer, result_reader, cancel_writer,
    cancel_reader, feedback_writer, status_writer;
static uint8_t goal_id[kIdSize];
static int32_t stamp;
static int state = kUnknown;
static int32_t numbers[kMostNumbers];
static uint32_t count;
static ResultRequest waiting[16];
static uint32_t waiting_count;

static dds_sequence_int32 Sequence(void) {
  return (dds_sequence_int32){
      ._maximum = count, ._length = count, ._buffer = numbers, ._release = false};
}

static void Enter(int new_state) {
  state = new_state;
  action_msgs_msg_dds__GoalStatus_ status = {.status = (int8_t)state};
  memcpy(status.goal_info.goal_id.uuid, goal_id, kIdSize);
  status.goal_info.stamp.sec = stamp;
  Statuses statuses;
  memset(&statuses, 0, sizeof(statuses));
  statuses.status_list._maximum = statuses.status_list._length = 1;
  statuses.status_list._buffer = &status;
  dds_write(status_writer, &statuses);
}

static void ReplyResult(const ResultRequest* request, int status) {
  ResultReply reply = {.client_id = request->client_id,
                       .sequence_number = request->sequence_number,
                       .status = (int8_t)status};
  if (status != kUnknown) reply.result.sequence = Sequence();
  dds_write(result_writer, &reply);
}

static void End(int new_state) {
  Enter(new_state);
  for (uint32_t i = 0; i < waiting_count; ++i) ReplyResult(&waiting[i], state);
  waiting_count = 0;
}

static void OnGoal(const GoalRequest* request) {
  const bool accepts = request->goal.order >= 0;
  GoalReply reply = {.client_id = request->client_id,
                     .sequence_number = request->sequence_number,
                     .accepted = accepts};
  reply.stamp.sec = ++stamp;
  if (accepts) {
    memcpy(goal_id, request->goal_id.uuid, kIdSize);
    count = 0;
  }
  dds_write(goal_writer, &reply);
  if (!accepts) return;
  Enter(kAccepted);
  Enter(kExecuting);
  const int order = request->goal.order;
  for (int i = 0; i < (order < kMostNumbers ? order : 1); ++i) {
    numbers[i] = i < 2 ? i : numbers[i - 1] + numbers[i - 2];
    count = (uint32_t)i + 1;
    Feedback feedback;
    memset(&feedback, 0, sizeof(feedback));
    memcpy(feedback.goal_id.uuid, goal_id, kIdSize);
    feedback.feedback.sequence = Sequence();
    dds_write(feedback_writer, &feedback);
  }
  if (order < kMostNumbers) End(kSucceeded);
}

static void OnResultRequest(const ResultRequest* request) {
  const bool known = state != kUnknown && memcmp(request->goal_id.uuid, goal_id, kIdSize) == 0;
  if (known && state < kSucceeded) {
    waiting[waiting_count++] = *request;
  } else {
    ReplyResult(request, known ? state : kUnknown);
  }
}

static void OnCancel(const CancelRequest* request) {
  CancelReply reply;
  memset(&reply, 0, sizeof(reply));
  reply.client_id = request->client_id;
  reply.sequence_number = request->sequence_number;
  action_msgs_msg_dds__GoalInfo_ info = request->goal_info;
  const bool known = memcmp(info.goal_id.uuid, goal_id, kIdSize) == 0;
  if (known && state == kExecuting) {
    reply.goals_canceling._maximum = reply.goals_canceling._length = 1;
    reply.goals_canceling._buffer = &info;
    Enter(kCanceling);
  } else {
    reply.return_code = known ? 3 : 2;
  }
  dds_write(cancel_writer, &reply);
  if (state == kCanceling) End(kCanceled);
}

int main(int argc, char** argv) {
  if (argc != 3 || !OpenParticipant(argv[1])) return EXIT_FAILURE;
  const char* action = argv[2];
  feedback_writer = Writer(&example_interfaces_action_dds__Fibonacci_FeedbackMessage__desc,
                           "rt/%s/_action/feedback", action, false);
  status_writer =
      Writer(&action_msgs_msg_dds__GoalStatusArray__desc, "rt/%s/_action/status", action, true);
  goal_writer = Writer(&example_interfaces_action_dds__Fibonacci_SendGoal_Response__desc,
                       "rr/%s/_action/send_goalReply", action, false);
  result_writer = Writer(&example_interfaces_action_dds__Fibonacci_GetResult_Response__desc,
                         "rr/%s/_action/get_resultReply", action, false);
  cancel_writer = Writer(&action_msgs_srv_dds__CancelGoal_Response__desc,
                         "rr/%s/_action/cancel_goalReply", action, false);
  goal_reader = Reader(&example_interfaces_action_dds__Fibonacci_SendGoal_Request__desc,
                       "rq/%s/_action/send_goalRequest", action, false);
  result_reader = Reader(&example_interfaces_action_dds__Fibonacci_GetResult_Request__desc,
                         "rq/%s/_action/get_resultRequest", action, false);
  cancel_reader = Reader(&action_msgs_srv_dds__CancelGoal_Request__desc,
                         "rq/%s/_action/cancel_goalRequest", action, false);
  for (;;) {
    dds_waitset_wait(waitset, NULL, 0, DDS_SECS(1));
    if (!WriterMatched(goal_writer) || !WriterMatched(feedback_writer)) continue;
    TAKE_ALL(goal_reader, OnGoal);
    TAKE_ALL(result_reader, OnResultRequest);
    TAKE_ALL(cancel_reader, OnCancel);
  }
}
