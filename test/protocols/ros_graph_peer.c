// The graph of a ROS 2 (Jazzy) process, and what it logs about the others: reads the builtin
// topics and `ros_discovery_info` as rmw_cyclonedds_cpp does. In plain C, without any of our code.
//
//   ros_graph_peer      in the domain of ROS_DOMAIN_ID, until its standard input ends
//
// At each change it prints all that it knows:
//
//   samples 3              of `ros_discovery_info`, so far
//   node /dog1/arm         as `ros2 node list`; then, as `ros2 node info`:
//   publisher /dog1/chat std_msgs/msg/String RIHS01_…
//                          and subscription, service, client in the same form
//   unknown rt/dog1/chat   an endpoint that no node lists (_NODE_NAME_UNKNOWN_)
//   bytes 12 1044          the number of endpoints, and the bytes of their USER_DATA
//   log [WARN] …           what rclcpp logs
//   end

#include <ctype.h>
#include <dds/dds.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "musher_idl.h"

typedef rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ Info;
typedef rmw_dds_common_msg_dds__NodeEntitiesInfo_ NodeInfo;

enum { kMost = 2048, kName = 256, kGid = 16, kBatch = 64 };

typedef struct {
  bool used;
  uint8_t gid[kGid];
  uint8_t participant[kGid];
  bool reader;
  char topic[kName];
  char type[kName];
  char hash[80];
  size_t user_data_size;
} Endpoint;

typedef struct {
  bool used;
  uint8_t gid[kGid];
  bool has_enclave;
} Participant;

static Endpoint endpoints[kMost];
static Participant participants[kMost];
static Info* infos[kMost];
static char* warnings[kMost];
static int info_count;
static int warning_count;
static int sample_count;

// rmw's parse_key_value(): "key=value;key=value;" with alphanumeric keys, ";;" for a ';'. The value
// of `key`, or false; `valid`: whether the whole is well formed.
static bool FindValue(const char* data, size_t size, const char* key, char* value, size_t room,
                      bool* valid) {
  bool found = false;
  size_t at = 0;
  *valid = size > 0;
  while (at < size) {
    char name[kName] = "";
    size_t length = 0;
    while (at < size && isalnum((unsigned char)data[at]) && length + 1 < sizeof(name)) {
      name[length++] = data[at++];
    }
    name[length] = '\0';
    if (length == 0 || at == size || data[at++] != '=') break;
    char text[kName] = "";
    length = 0;
    while (at < size && (data[at] != ';' || (at + 1 < size && data[at + 1] == ';'))) {
      if (data[at] == ';') ++at;
      if (length + 1 < sizeof(text)) text[length++] = data[at];
      ++at;
    }
    text[length] = '\0';
    if (length == 0 || at == size) break;
    ++at;  // the ';'
    if (strcmp(name, key) == 0 && length < room) {
      memcpy(value, text, length + 1);
      found = true;
    }
    if (at == size) return found;
  }
  *valid = false;
  return false;
}

static bool IsTypeHash(const char* text) {
  if (strncmp(text, "RIHS01_", 7) != 0 || strlen(text) != 7 + 64) return false;
  for (const char* c = text + 7; *c != '\0'; ++c) {
    if (!isxdigit((unsigned char)*c)) return false;
  }
  return true;
}

static void Warn(const char* topic, const char* type, const char* data, size_t size) {
  char line[1024];
  snprintf(line, sizeof(line),
           "[WARN] [rmw_cyclonedds_cpp]: Failed to parse type hash for topic '%s' with type '%s' "
           "from USER_DATA '%.*s'.",
           topic, type, data == NULL ? 6 : (int)size, data == NULL ? "(null)" : data);
  if (warning_count < kMost) warnings[warning_count++] = strdup(line);
}

// As rmw_cyclonedds_cpp's handle_builtintopic_endpoint().
static void NoteEndpoint(const dds_builtintopic_endpoint_t* sample, bool alive, bool reader) {
  Endpoint* slot = NULL;
  for (int i = 0; i < kMost; ++i) {
    Endpoint* each = &endpoints[i];
    if (each->used && memcmp(each->gid, sample->key.v, kGid) == 0) {
      if (!alive) each->used = false;
      return;
    }
    if (!each->used && slot == NULL) slot = each;
  }
  if (!alive || slot == NULL || strncmp(sample->topic_name, "DCPS", 4) == 0) return;
  memset(slot, 0, sizeof(*slot));
  slot->used = true;
  slot->reader = reader;
  memcpy(slot->gid, sample->key.v, kGid);
  memcpy(slot->participant, sample->participant_key.v, kGid);
  snprintf(slot->topic, kName, "%s", sample->topic_name);
  snprintf(slot->type, kName, "%s", sample->type_name);
  void* data = NULL;
  size_t size = 0;
  if (!dds_qget_userdata(sample->qos, &data, &size)) return;
  bool valid = false;
  const bool found = FindValue(data, size, "typehash", slot->hash, sizeof(slot->hash), &valid);
  if (data == NULL || (found && !IsTypeHash(slot->hash))) {
    Warn(slot->topic, slot->type, data, size);
  }
  slot->user_data_size = size;
  dds_free(data);
}

static void NoteParticipant(const dds_builtintopic_participant_t* sample, bool alive) {
  Participant* slot = NULL;
  for (int i = 0; i < kMost; ++i) {
    Participant* each = &participants[i];
    if (each->used && memcmp(each->gid, sample->key.v, kGid) == 0) {
      if (!alive) each->used = false;
      return;
    }
    if (!each->used && slot == NULL) slot = each;
  }
  if (!alive || slot == NULL) return;
  slot->used = true;
  memcpy(slot->gid, sample->key.v, kGid);
  void* data = NULL;
  size_t size = 0;
  char enclave[kName];
  bool valid = false;
  dds_qget_userdata(sample->qos, &data, &size);
  slot->has_enclave = FindValue(data, size, "enclave", enclave, sizeof(enclave), &valid);
  dds_free(data);
}

static bool TakeBuiltin(dds_entity_t reader, int kind) {
  void* samples[kBatch] = {NULL};
  dds_sample_info_t about[kBatch];
  const dds_return_t count = dds_take(reader, samples, about, kBatch, kBatch);
  for (int i = 0; i < count; ++i) {
    const bool alive = about[i].instance_state == DDS_IST_ALIVE;
    if (alive && !about[i].valid_data) continue;
    if (kind == 0) {
      NoteParticipant(samples[i], alive);
    } else {
      NoteEndpoint(samples[i], alive, kind == 2);
    }
  }
  if (count > 0) dds_return_loan(reader, samples, count);
  return count > 0;
}

// The latest sample of a participant replaces the one before.
static bool TakeInfo(dds_entity_t reader) {
  void* sample = NULL;
  dds_sample_info_t about;
  if (dds_take(reader, &sample, &about, 1, 1) != 1) return false;
  if (about.valid_data) {
    ++sample_count;
    const Info* info = sample;
    int at = 0;
    while (at < info_count && memcmp(infos[at]->gid.data, info->gid.data, kGid) != 0) ++at;
    Info* copy = dds_alloc(sizeof(Info));
    copy->gid = info->gid;
    copy->node_entities_info_seq._length = info->node_entities_info_seq._length;
    copy->node_entities_info_seq._release = true;
    copy->node_entities_info_seq._buffer =
        dds_alloc(info->node_entities_info_seq._length * sizeof(NodeInfo) + 1);
    for (uint32_t i = 0; i < copy->node_entities_info_seq._length; ++i) {
      const NodeInfo* from = &info->node_entities_info_seq._buffer[i];
      NodeInfo* to = &copy->node_entities_info_seq._buffer[i];
      *to = *from;
      const size_t gid = sizeof(from->reader_gid_seq._buffer[0]);
      to->reader_gid_seq._buffer = dds_alloc(from->reader_gid_seq._length * gid + 1);
      memcpy(to->reader_gid_seq._buffer, from->reader_gid_seq._buffer,
             from->reader_gid_seq._length * gid);
      to->writer_gid_seq._buffer = dds_alloc(from->writer_gid_seq._length * gid + 1);
      memcpy(to->writer_gid_seq._buffer, from->writer_gid_seq._buffer,
             from->writer_gid_seq._length * gid);
    }
    infos[at] = copy;  // the older one is left to the end of the process
    if (at == info_count) ++info_count;
  }
  dds_return_loan(reader, &sample, 1);
  return true;
}

static bool HasEnclave(const uint8_t* gid) {
  for (int i = 0; i < kMost; ++i) {
    if (participants[i].used && memcmp(participants[i].gid, gid, kGid) == 0) {
      return participants[i].has_enclave;
    }
  }
  return false;
}

// "a::msg::dds_::B_" as "a/msg/B".
static void PrintType(const char* type) {
  const char* dds = strstr(type, "::dds_::");
  if (dds == NULL) {
    printf(" %s", type);
    return;
  }
  putchar(' ');
  for (const char* c = type; c < dds; ++c) {
    if (*c == ':') ++c;
    putchar(*c == ':' ? '/' : *c);
  }
  printf("/%.*s", (int)strlen(dds + 8) - 1, dds + 8);
}

static void PrintEndpoint(const Endpoint* each) {
  const size_t length = strlen(each->topic);
  const char* name = each->topic + 2;
  const bool request = strncmp(each->topic, "rq/", 3) == 0;
  if (strncmp(each->topic, "rt/", 3) == 0) {
    printf("%s %s", each->reader ? "subscription" : "publisher", name);
  } else if (request) {  // the reply's endpoint is not shown
    printf("%s %.*s", each->reader ? "service" : "client", (int)length - 2 - 7, name);
  } else {
    printf("%s %s", each->reader ? "replies-to" : "replies-of", name);
  }
  PrintType(each->type);
  printf(" %s\n", each->hash[0] != '\0' ? each->hash : "-");
}

static void PrintListed(const uint8_t* gids, uint32_t count, size_t stride, bool* listed) {
  for (uint32_t g = 0; g < count; ++g) {
    for (int i = 0; i < kMost; ++i) {
      if (!endpoints[i].used || memcmp(endpoints[i].gid, gids + g * stride, kGid) != 0) continue;
      listed[i] = true;
      PrintEndpoint(&endpoints[i]);
    }
  }
}

static void PrintAll(const uint8_t* self) {
  static bool listed[kMost];
  memset(listed, 0, sizeof(listed));
  printf("samples %d\n", sample_count);
  for (int p = 0; p < info_count; ++p) {
    if (!HasEnclave(infos[p]->gid.data)) continue;  // exited, or no ROS 2 process
    for (uint32_t n = 0; n < infos[p]->node_entities_info_seq._length; ++n) {
      const NodeInfo* node = &infos[p]->node_entities_info_seq._buffer[n];
      const bool root = strcmp(node->node_namespace, "/") == 0;
      printf("node %s/%s\n", root ? "" : node->node_namespace, node->node_name);
      PrintListed((const uint8_t*)node->reader_gid_seq._buffer, node->reader_gid_seq._length,
                  sizeof(node->reader_gid_seq._buffer[0]), listed);
      PrintListed((const uint8_t*)node->writer_gid_seq._buffer, node->writer_gid_seq._length,
                  sizeof(node->writer_gid_seq._buffer[0]), listed);
    }
  }
  int count = 0;
  size_t bytes = 0;
  for (int i = 0; i < kMost; ++i) {
    if (!endpoints[i].used || memcmp(endpoints[i].participant, self, kGid) == 0) continue;
    ++count;
    bytes += endpoints[i].user_data_size;
    const bool shown = endpoints[i].topic[0] == 'r' && endpoints[i].topic[2] == '/';
    if (shown && !listed[i]) printf("unknown %s\n", endpoints[i].topic);
  }
  printf("bytes %d %zu\n", count, bytes);
  for (int i = 0; i < warning_count; ++i) printf("log %s\n", warnings[i]);
  printf("end\n");
  fflush(stdout);
}

int main(void) {
  const char* domain = getenv("ROS_DOMAIN_ID");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_userdata(qos, "enclave=/;", 10);
  const dds_entity_t self =
      dds_create_participant(domain == NULL ? 0 : (dds_domainid_t)atoi(domain), qos, NULL);
  dds_delete_qos(qos);
  if (self < 0) return EXIT_FAILURE;
  dds_guid_t guid;
  dds_get_guid(self, &guid);

  const char* own_type =
      "typehash=RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e;";
  qos = dds_create_qos();
  dds_qset_userdata(qos, own_type, strlen(own_type));
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
  const dds_entity_t topic =
      dds_create_topic(self, &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
                       "ros_discovery_info", NULL, NULL);
  const dds_entity_t readers[] = {
      dds_create_reader(self, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, NULL, NULL),
      dds_create_reader(self, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL),
      dds_create_reader(self, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, NULL, NULL),
      dds_create_reader(self, topic, qos, NULL)};
  dds_delete_qos(qos);
  const dds_entity_t waitset = dds_create_waitset(self);
  for (int i = 0; i < 4; ++i) {
    if (readers[i] < 0) return EXIT_FAILURE;
    dds_set_status_mask(readers[i], DDS_DATA_AVAILABLE_STATUS);
    dds_waitset_attach(waitset, readers[i], i);
  }
  struct pollfd input = {.fd = 0, .events = POLLIN};
  while (poll(&input, 1, 0) == 0) {  // a test closes its end after its last command
    dds_waitset_wait(waitset, NULL, 0, DDS_MSECS(100));
    bool changed = false;
    for (int i = 0; i < 3; ++i) {
      while (TakeBuiltin(readers[i], i)) changed = true;
    }
    while (TakeInfo(readers[3])) changed = true;
    if (changed) PrintAll(guid.v);
  }
  dds_delete(self);
  return EXIT_SUCCESS;
}
