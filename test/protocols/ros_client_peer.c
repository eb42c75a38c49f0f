// A ROS 2 process that calls one service as soon as it is available, as rclcpp does: waits until
// a server is matched in both directions, sends one request, and waits for the reply. In plain C,
// without any of our code.
//
//   ros_client_peer <service>      of type musher_msgs/srv/SetState, without a leading '/', in the
//                                  domain of ROS_DOMAIN_ID
//
// Prints "available <ms> reply <ms>": from its start until the service is there, and from the
// request to the reply. Exit code 1 where either has not come within 10 s.

#include <dds/dds.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "musher_idl.h"

typedef musher_msgs_srv_dds__SetState_Request_ Request;
typedef musher_msgs_srv_dds__SetState_Response_ Response;

enum { kName = 256, kMost = 64, kOthers = 8 };

static const dds_duration_t kLongest = DDS_SECS(120);

static dds_qos_t* ServiceQos(const char* user_data) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  dds_qset_writer_data_lifecycle(qos, false);
  dds_qset_userdata(qos, user_data, strlen(user_data));
  return qos;
}

// The "serviceid=…;" of a matched endpoint; false where it has none.
static bool ServiceId(dds_builtintopic_endpoint_t* endpoint, char* id) {
  if (endpoint == NULL) return false;
  void* data = NULL;
  size_t size = 0;
  bool found = false;
  if (dds_qget_userdata(endpoint->qos, &data, &size) && data != NULL && size < kName) {
    char text[kName];
    memcpy(text, data, size);
    text[size] = '\0';
    const char* begin = strstr(text, "serviceid=");
    if (begin != NULL) {
      snprintf(id, kName, "%.*s", (int)strcspn(begin, ";"), begin);
      found = true;
    }
  }
  dds_free(data);
  dds_builtintopic_free_endpoint(endpoint);
  return found;
}

// As rmw_cyclonedds_cpp's check_for_service_reader_writer().
static bool IsAvailable(dds_entity_t requests, dds_entity_t replies) {
  dds_instance_handle_t readers[kMost], writers[kMost];
  const dds_return_t reader_count = dds_get_matched_subscriptions(requests, readers, kMost);
  const dds_return_t writer_count = dds_get_matched_publications(replies, writers, kMost);
  for (int r = 0; r < reader_count; ++r) {
    char reads[kName];
    if (!ServiceId(dds_get_matched_subscription_data(requests, readers[r]), reads)) continue;
    for (int w = 0; w < writer_count; ++w) {
      char writes[kName];
      if (ServiceId(dds_get_matched_publication_data(replies, writers[w]), writes) &&
          strcmp(reads, writes) == 0) {
        return true;
      }
    }
  }
  return false;
}

// What every rclcpp node has before its own first endpoint: services for its parameters and their
// types, `/parameter_events` and `/rosout`. All of it is announced before the client is.
static void MakeOtherEndpoints(dds_entity_t self) {
  dds_qos_t* qos = ServiceQos("typehash=RIHS01_0;");
  for (int i = 0; i < kOthers; ++i) {
    char name[kName];
    snprintf(name, kName, "rr/%d_%d_other", (int)self, i);
    const dds_entity_t topic =
        dds_create_topic(self, &musher_msgs_srv_dds__SetState_Response__desc, name, NULL, NULL);
    dds_create_writer(self, topic, qos, NULL);
    dds_create_reader(self, topic, qos, NULL);
  }
  dds_delete_qos(qos);
}

int main(int argc, char** argv) {
  if (argc != 2) return EXIT_FAILURE;
  const dds_time_t begin = dds_time();
  const char* domain = getenv("ROS_DOMAIN_ID");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_userdata(qos, "enclave=/;", 10);
  const dds_entity_t self =
      dds_create_participant(domain == NULL ? 0 : (dds_domainid_t)atoi(domain), qos, NULL);
  dds_delete_qos(qos);
  if (self < 0) return EXIT_FAILURE;

  MakeOtherEndpoints(self);
  dds_guid_t guid;
  dds_get_guid(self, &guid);
  char user_data[kName] = "clientid=";
  for (int i = 0; i < 16; ++i) {
    char part[8];
    snprintf(part, sizeof(part), i == 0 ? "%02x" : ".%x", guid.v[i]);
    strcat(user_data, part);
  }
  strcat(user_data, ".1.2.3.4.5.6.7.8;");
  char request_topic[kName], reply_topic[kName];
  snprintf(request_topic, kName, "rq/%sRequest", argv[1]);
  snprintf(reply_topic, kName, "rr/%sReply", argv[1]);
  qos = ServiceQos(user_data);
  const dds_entity_t requests =
      dds_create_writer(self,
                        dds_create_topic(self, &musher_msgs_srv_dds__SetState_Request__desc,
                                         request_topic, NULL, NULL),
                        qos, NULL);
  const dds_entity_t replies =
      dds_create_reader(self,
                        dds_create_topic(self, &musher_msgs_srv_dds__SetState_Response__desc,
                                         reply_topic, NULL, NULL),
                        qos, NULL);
  dds_delete_qos(qos);
  if (requests < 0 || replies < 0) return EXIT_FAILURE;

  const dds_entity_t waitset = dds_create_waitset(self);
  dds_set_status_mask(requests, DDS_PUBLICATION_MATCHED_STATUS);
  dds_set_status_mask(replies, DDS_SUBSCRIPTION_MATCHED_STATUS | DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(waitset, requests, 0);
  dds_waitset_attach(waitset, replies, 1);
  while (!IsAvailable(requests, replies)) {
    if (dds_time() - begin > kLongest) return EXIT_FAILURE;
    dds_waitset_wait(waitset, NULL, 0, DDS_MSECS(1));
    uint32_t status = 0;
    dds_take_status(requests, &status, DDS_PUBLICATION_MATCHED_STATUS);
    dds_take_status(replies, &status, DDS_SUBSCRIPTION_MATCHED_STATUS);
  }
  const dds_time_t available = dds_time();

  Request request = {.target = "Active", .actuator = "", .sequence_number = 1};
  dds_get_instance_handle(requests, &request.client_id);
  if (dds_write(requests, &request) != DDS_RETCODE_OK) return EXIT_FAILURE;
  for (;;) {
    if (dds_time() - available > kLongest) return EXIT_FAILURE;
    dds_waitset_wait(waitset, NULL, 0, DDS_MSECS(100));
    void* sample = NULL;
    dds_sample_info_t info;
    if (dds_take(replies, &sample, &info, 1, 1) != 1) continue;
    const bool mine = info.valid_data && ((const Response*)sample)->client_id == request.client_id;
    dds_return_loan(replies, &sample, 1);
    if (mine) break;
  }
  printf("available %.1f reply %.1f\n", (double)(available - begin) / 1e6,
         (double)(dds_time() - available) / 1e6);
  dds_delete(self);
  return EXIT_SUCCESS;
}
