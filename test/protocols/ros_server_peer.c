// A ROS 2 managed node as far as driving it goes: `~/change_state` and `~/get_state`, whose
// callbacks succeed at once. In plain C, without any of our code, with Cyclone as its environment
// says: it has no settings of its own.
//
//   ros_server_peer <node>      with its namespace, without a leading '/', in the domain of
//                               ROS_DOMAIN_ID
//
// Like rclcpp it sends a reply only when the reader of the client is matched; it waits 100 ms for
// it.

#include <dds/dds.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "musher_idl.h"

typedef lifecycle_msgs_srv_dds__ChangeState_Request_ ChangeRequest;
typedef lifecycle_msgs_srv_dds__ChangeState_Response_ ChangeResponse;
typedef lifecycle_msgs_srv_dds__GetState_Request_ GetRequest;
typedef lifecycle_msgs_srv_dds__GetState_Response_ GetResponse;

enum { kName = 256 };

// The states of lifecycle_msgs/msg/State.
enum { kUnconfigured = 1, kInactive = 2, kActive = 3, kFinalized = 4 };

static const char* const kLabels[] = {"unknown", "unconfigured", "inactive", "active", "finalized"};

typedef struct {
  dds_entity_t requests;
  dds_entity_t replies;
} Service;

static int state = kUnconfigured;

static Service Serve(dds_entity_t self, const char* node, const char* name,
                     const dds_topic_descriptor_t* request,
                     const dds_topic_descriptor_t* response) {
  char topic[kName], user_data[kName];
  snprintf(user_data, kName, "serviceid=%d.%s;", (int)self, name);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  dds_qset_writer_data_lifecycle(qos, false);
  dds_qset_userdata(qos, user_data, strlen(user_data));
  Service service;
  snprintf(topic, kName, "rr/%s/%sReply", node, name);
  service.replies =
      dds_create_writer(self, dds_create_topic(self, response, topic, NULL, NULL), qos, NULL);
  snprintf(topic, kName, "rq/%s/%sRequest", node, name);
  service.requests =
      dds_create_reader(self, dds_create_topic(self, request, topic, NULL, NULL), qos, NULL);
  dds_delete_qos(qos);
  return service;
}

static void AwaitClient(dds_entity_t replies) {
  const dds_time_t end = dds_time() + DDS_MSECS(100);
  const dds_entity_t waitset = dds_create_waitset(dds_get_participant(replies));
  dds_set_status_mask(replies, DDS_PUBLICATION_MATCHED_STATUS);
  dds_waitset_attach(waitset, replies, 0);
  dds_publication_matched_status_t matched;
  while (dds_get_publication_matched_status(replies, &matched) == DDS_RETCODE_OK &&
         matched.current_count == 0 && dds_time() < end) {
    dds_waitset_wait(waitset, NULL, 0, DDS_MSECS(10));
  }
  dds_delete(waitset);
}

static bool Change(int transition) {
  static const struct {
    int transition, from, to;
  } kAllowed[] = {{1, kUnconfigured, kInactive},  {2, kInactive, kUnconfigured},
                  {3, kInactive, kActive},        {4, kActive, kInactive},
                  {5, kUnconfigured, kFinalized}, {6, kInactive, kFinalized},
                  {7, kActive, kFinalized}};
  for (size_t i = 0; i < sizeof(kAllowed) / sizeof(kAllowed[0]); ++i) {
    if (kAllowed[i].transition != transition || kAllowed[i].from != state) continue;
    state = kAllowed[i].to;
    return true;
  }
  return false;
}

static bool AnswerChange(const Service* service) {
  void* sample = NULL;
  dds_sample_info_t info;
  if (dds_take(service->requests, &sample, &info, 1, 1) != 1) return false;
  if (info.valid_data) {
    const ChangeRequest* request = sample;
    ChangeResponse response = {.client_id = request->client_id,
                               .sequence_number = request->sequence_number,
                               .success = Change(request->transition.id)};
    AwaitClient(service->replies);
    dds_write(service->replies, &response);
  }
  dds_return_loan(service->requests, &sample, 1);
  return true;
}

static bool AnswerGet(const Service* service) {
  void* sample = NULL;
  dds_sample_info_t info;
  if (dds_take(service->requests, &sample, &info, 1, 1) != 1) return false;
  if (info.valid_data) {
    const GetRequest* request = sample;
    GetResponse response = {.client_id = request->client_id,
                            .sequence_number = request->sequence_number};
    response.current_state.id = (uint8_t)state;
    response.current_state.label = (char*)kLabels[state];
    AwaitClient(service->replies);
    dds_write(service->replies, &response);
  }
  dds_return_loan(service->requests, &sample, 1);
  return true;
}

int main(int argc, char** argv) {
  if (argc < 2) return EXIT_FAILURE;
  const char* domain = getenv("ROS_DOMAIN_ID");
  const char* rmw = getenv("RMW_IMPLEMENTATION");
  if (rmw == NULL || strcmp(rmw, "rmw_cyclonedds_cpp") != 0) {
    fprintf(stderr, "RMW_IMPLEMENTATION is not rmw_cyclonedds_cpp: this would run on Fast DDS\n");
    return EXIT_FAILURE;
  }
  dds_qos_t* qos = dds_create_qos();
  dds_qset_userdata(qos, "enclave=/;", 10);
  const dds_entity_t self =
      dds_create_participant(domain == NULL ? 0 : (dds_domainid_t)atoi(domain), qos, NULL);
  dds_delete_qos(qos);
  if (self < 0) return EXIT_FAILURE;
  const Service change =
      Serve(self, argv[1], "change_state", &lifecycle_msgs_srv_dds__ChangeState_Request__desc,
            &lifecycle_msgs_srv_dds__ChangeState_Response__desc);
  const Service get =
      Serve(self, argv[1], "get_state", &lifecycle_msgs_srv_dds__GetState_Request__desc,
            &lifecycle_msgs_srv_dds__GetState_Response__desc);
  const dds_entity_t waitset = dds_create_waitset(self);
  dds_set_status_mask(change.requests, DDS_DATA_AVAILABLE_STATUS);
  dds_set_status_mask(get.requests, DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(waitset, change.requests, 0);
  dds_waitset_attach(waitset, get.requests, 1);
  for (;;) {  // until it is killed
    dds_waitset_wait(waitset, NULL, 0, DDS_SECS(1));
    while (AnswerChange(&change) || AnswerGet(&get)) {
    }
  }
}
