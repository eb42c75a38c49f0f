// What the two peers of actions share: ROS 2's names and QoS in plain C, idlc's types on Cyclone,
// none of Musher's code.
#ifndef MUSHER_TEST_CONTRACT_ACTION_PEER_H
#define MUSHER_TEST_CONTRACT_ACTION_PEER_H

#include <dds/dds.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "musher_idl.h"

typedef example_interfaces_action_dds__Fibonacci_SendGoal_Request_ GoalRequest;
typedef example_interfaces_action_dds__Fibonacci_SendGoal_Response_ GoalReply;
typedef example_interfaces_action_dds__Fibonacci_GetResult_Request_ ResultRequest;
typedef example_interfaces_action_dds__Fibonacci_GetResult_Response_ ResultReply;
typedef example_interfaces_action_dds__Fibonacci_FeedbackMessage_ Feedback;
typedef action_msgs_srv_dds__CancelGoal_Request_ CancelRequest;
typedef action_msgs_srv_dds__CancelGoal_Response_ CancelReply;
typedef action_msgs_msg_dds__GoalStatusArray_ Statuses;

enum { kUnknown, kAccepted, kExecuting, kCanceling, kSucceeded, kCanceled, kAborted };
enum { kIdSize = 16, kNameSize = 256 };

static dds_entity_t self;
static dds_entity_t waitset;

static inline bool OpenParticipant(const char* domain) {
  static const char kLoopback[] =
      "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" "
      "multicast=\"true\"/></Interfaces></General></Domain></CycloneDDS>";
  const dds_domainid_t id = (dds_domainid_t)atoi(domain);
  if (dds_create_domain(id, kLoopback) < 0) return false;
  // With a name as that of a command line of Musher.
  char user_data[kNameSize] = "enclave=/;";
  const char* name = getenv("PEER_NAME");
  if (name != NULL) snprintf(user_data, sizeof(user_data), "enclave=/;musher=%s;", name);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_userdata(qos, user_data, strlen(user_data));
  self = dds_create_participant(id, qos, NULL);
  dds_delete_qos(qos);
  waitset = dds_create_waitset(self);
  return self > 0;
}

static inline dds_qos_t* NewQos(bool latched) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, latched ? 1 : 10);
  dds_qset_durability(qos, latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_writer_data_lifecycle(qos, false);
  return qos;
}

// The topic of `format` with the name of the action in it.
static inline dds_entity_t Topic(const dds_topic_descriptor_t* type, const char* format,
                                 const char* action) {
  char name[kNameSize];
  snprintf(name, sizeof(name), format, action);
  return dds_create_topic(self, type, name, NULL, NULL);
}
static inline dds_entity_t Writer(const dds_topic_descriptor_t* type, const char* format,
                                  const char* action, bool latched) {
  dds_qos_t* qos = NewQos(latched);
  const dds_entity_t writer = dds_create_writer(self, Topic(type, format, action), qos, NULL);
  dds_delete_qos(qos);
  dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS);
  dds_waitset_attach(waitset, writer, 0);
  return writer;
}
static inline dds_entity_t Reader(const dds_topic_descriptor_t* type, const char* format,
                                  const char* action, bool latched) {
  dds_qos_t* qos = NewQos(latched);
  const dds_entity_t reader = dds_create_reader(self, Topic(type, format, action), qos, NULL);
  dds_delete_qos(qos);
  dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS);
  dds_waitset_attach(waitset, reader, 0);
  return reader;
}

static inline bool WriterMatched(dds_entity_t writer) {
  dds_publication_matched_status_t status;
  return dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK &&
         status.current_count > 0;
}
static inline bool ReaderMatched(dds_entity_t reader) {
  dds_subscription_matched_status_t status;
  return dds_get_subscription_matched_status(reader, &status) == DDS_RETCODE_OK &&
         status.current_count > 0;
}

// Calls `on_sample` with each sample of `reader`.
#define TAKE_ALL(reader, on_sample)                     \
  do {                                                  \
    void* loan = NULL;                                  \
    dds_sample_info_t info;                             \
    while (dds_take(reader, &loan, &info, 1, 1) == 1) { \
      if (info.valid_data) on_sample(loan);             \
      dds_return_loan(reader, &loan, 1);                \
      loan = NULL;                                      \
    }                                                   \
  } while (0)

#endif
