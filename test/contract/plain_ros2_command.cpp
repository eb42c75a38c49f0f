#include "musher/test/contract/plain_ros2_command.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string_view>
#include <utility>

namespace musher::testing {
namespace {

constexpr dds_duration_t kWaitForService = DDS_SECS(60);
constexpr int kBatch = 32;
constexpr const char* kUnknownNode = "_NODE_NAME_UNKNOWN_";

bool StartsWith(std::string_view text, std::string_view part) {
  return text.starts_with(part);
}

// ros2topic's topic_or_service_is_hidden(): a part of the name begins with '_'.
bool IsHidden(const std::string& name) {
  return name.find("/_") != std::string::npos;
}

// "a::msg::dds_::B_" as "a/msg/B".
std::string RosType(const std::string& dds_type) {
  const std::size_t at = dds_type.find("::dds_::");
  if (at == std::string::npos) return dds_type;
  std::string text = dds_type.substr(0, at);
  for (std::size_t colons; (colons = text.find("::")) != std::string::npos;) {
    text.replace(colons, 2, "/");
  }
  std::string name = dds_type.substr(at + 8);
  if (name.ends_with('_')) name.pop_back();
  return text + "/" + name;
}

std::string Without(std::string text, std::initializer_list<std::string_view> endings) {
  for (const std::string_view ending : endings) {
    if (text.ends_with(ending)) return text.substr(0, text.size() - ending.size());
  }
  return text;
}

// The value of a key in USER_DATA.
std::string ValueOf(const dds_qos_t* qos, const std::string& key) {
  void* data = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(qos, &data, &size) || data == nullptr) return "";
  const std::string text(static_cast<const char*>(data), size);
  dds_free(data);
  const std::size_t at = (";" + text).find(";" + key + "=");
  if (at == std::string::npos) return "";
  const std::size_t begin = at + key.size() + 1;
  return text.substr(begin, text.find(';', begin) - begin);
}

// rclpy's Duration as text.
std::string DurationText(dds_duration_t duration) {
  return duration == DDS_INFINITY ? "Infinite" : std::to_string(duration) + " nanoseconds";
}

std::string Joined(const std::set<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string TypeName(std::uint8_t type) {
  constexpr std::array kNames = {"not set", "boolean", "integer", "double", "string"};
  return type < kNames.size() ? kNames[type] : "another";
}

std::string ValueText(const rcl_interfaces_msg_dds__ParameterValue_& value) {
  if (value.type == 1)
    return std::string("Boolean value is: ") + (value.bool_value ? "True" : "False");
  if (value.type == 4) return std::string("String value is: ") + value.string_value;
  return "Unknown parameter type '" + TypeName(value.type) + "'";
}

}  // namespace

PlainRos2Command::PlainRos2Command(int domain) : participant_(domain) {
  dds_guid_t guid;
  dds_get_guid(participant_.entity(), &guid);
  std::copy(std::begin(guid.v), std::end(guid.v), self_.begin());
  const auto open = [this](dds_entity_t topic, const dds_qos_t* qos, auto take) {
    const dds_entity_t reader = dds_create_reader(participant_.entity(), topic, qos, nullptr);
    dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS);
    participant_.Attach(reader, [reader, take] { take(reader); });
  };
  open(DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr,
       [this](dds_entity_t reader) { TakeParticipants(reader); });
  open(DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr,
       [this](dds_entity_t reader) { TakeEndpoints(reader, false); });
  open(DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr,
       [this](dds_entity_t reader) { TakeEndpoints(reader, true); });
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
  using Info = rmw_dds_common_msg_dds__ParticipantEntitiesInfo_;
  open(dds_create_topic(participant_.entity(),
                        &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
                        "ros_discovery_info", nullptr, nullptr),
       qos, [this](dds_entity_t reader) {
         TakeAll<Info>(reader, [this](const Info& info) {
           Gid participant{};
           std::copy(std::begin(info.gid.data), std::end(info.gid.data), participant.begin());
           std::vector<Node>& nodes = nodes_[participant];
           nodes.clear();
           for (std::uint32_t i = 0; i < info.node_entities_info_seq._length; ++i) {
             const auto& from = info.node_entities_info_seq._buffer[i];
             Node node{from.node_namespace, from.node_name, {}};
             for (const auto& gids :
                  {std::pair(from.reader_gid_seq._buffer, from.reader_gid_seq._length),
                   std::pair(from.writer_gid_seq._buffer, from.writer_gid_seq._length)}) {
               for (std::uint32_t g = 0; g < gids.second; ++g) {
                 Gid gid{};
                 std::copy(std::begin(gids.first[g].data), std::end(gids.first[g].data),
                           gid.begin());
                 node.endpoints.insert(gid);
               }
             }
             nodes.push_back(std::move(node));
           }
         });
       });
  dds_delete_qos(qos);
}

void PlainRos2Command::TakeParticipants(dds_entity_t reader) {
  std::array<void*, kBatch> samples{};
  std::array<dds_sample_info_t, kBatch> infos{};
  int count = 0;
  while ((count = dds_take(reader, samples.data(), infos.data(), kBatch, kBatch)) > 0) {
    for (int i = 0; i < count; ++i) {
      const auto& sample = *static_cast<const dds_builtintopic_participant_t*>(samples[i]);
      Gid gid{};
      std::copy(std::begin(sample.key.v), std::end(sample.key.v), gid.begin());
      if (infos[i].instance_state != DDS_IST_ALIVE) {
        processes_.erase(gid);
      } else if (infos[i].valid_data && !ValueOf(sample.qos, "enclave").empty()) {
        processes_.insert(gid);
      }
    }
    dds_return_loan(reader, samples.data(), count);
    samples = {};
  }
}

void PlainRos2Command::TakeEndpoints(dds_entity_t reader, bool of_readers) {
  std::array<void*, kBatch> samples{};
  std::array<dds_sample_info_t, kBatch> infos{};
  int count = 0;
  while ((count = dds_take(reader, samples.data(), infos.data(), kBatch, kBatch)) > 0) {
    for (int i = 0; i < count; ++i) {
      const auto& sample = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
      Gid gid{};
      std::copy(std::begin(sample.key.v), std::end(sample.key.v), gid.begin());
      if (infos[i].instance_state != DDS_IST_ALIVE) {
        endpoints_.erase(gid);
        continue;
      }
      if (!infos[i].valid_data) continue;
      Endpoint endpoint;
      endpoint.reader = of_readers;
      std::copy(std::begin(sample.participant_key.v), std::end(sample.participant_key.v),
                endpoint.participant.begin());
      endpoint.topic = sample.topic_name;
      endpoint.type = sample.type_name;
      endpoint.hash = ValueOf(sample.qos, "typehash");
      dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
      dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
      dds_liveliness_kind_t liveliness = DDS_LIVELINESS_AUTOMATIC;
      dds_duration_t blocking = 0;
      dds_qget_reliability(sample.qos, &reliability, &blocking);
      dds_qget_durability(sample.qos, &durability);
      dds_qget_lifespan(sample.qos, &endpoint.lifespan);
      dds_qget_deadline(sample.qos, &endpoint.deadline);
      dds_qget_liveliness(sample.qos, &liveliness, &endpoint.lease);
      endpoint.reliable = reliability == DDS_RELIABILITY_RELIABLE;
      endpoint.latched = durability == DDS_DURABILITY_TRANSIENT_LOCAL;
      if (endpoint.participant != self_) endpoints_[gid] = std::move(endpoint);
    }
    dds_return_loan(reader, samples.data(), count);
    samples = {};
  }
}

std::string PlainRos2Command::Await(const std::string& text,
                                    const std::function<std::string()>& command) {
  std::string printed;
  participant_.Spin([&] {
    printed = command();
    return printed == text;
  });
  return printed;
}

std::vector<PlainRos2Command::Node> PlainRos2Command::Nodes() const {
  std::vector<Node> all;
  for (const auto& [participant, nodes] : nodes_) {
    if (processes_.contains(participant)) all.insert(all.end(), nodes.begin(), nodes.end());
  }
  std::ranges::sort(all, {}, &Node::full_name);
  return all;
}

const PlainRos2Command::Node* PlainRos2Command::NodeOf(const Gid& endpoint) const {
  for (const auto& [participant, nodes] : nodes_) {
    for (const Node& node : nodes) {
      if (node.endpoints.contains(endpoint)) return &node;
    }
  }
  return nullptr;
}

std::string PlainRos2Command::TopicName(const Endpoint& endpoint) {
  return StartsWith(endpoint.topic, "rt/") ? endpoint.topic.substr(2) : "";
}
std::string PlainRos2Command::PublisherName(const Endpoint& endpoint) {
  return endpoint.reader ? "" : TopicName(endpoint);
}
std::string PlainRos2Command::SubscriberName(const Endpoint& endpoint) {
  return endpoint.reader ? TopicName(endpoint) : "";
}
std::string PlainRos2Command::ServiceName(const Endpoint& endpoint) {
  const bool request = StartsWith(endpoint.topic, "rq/");
  if (!request && !StartsWith(endpoint.topic, "rr/")) return "";
  return Without(endpoint.topic.substr(2), {request ? "Request" : "Reply"});
}
std::string PlainRos2Command::ServerName(const Endpoint& endpoint) {
  return endpoint.reader && StartsWith(endpoint.topic, "rq/") ? ServiceName(endpoint) : "";
}
std::string PlainRos2Command::ClientName(const Endpoint& endpoint) {
  return endpoint.reader && StartsWith(endpoint.topic, "rr/") ? ServiceName(endpoint) : "";
}
// rcl_action's: the topic of feedback is the action.
std::string PlainRos2Command::ActionName(const Endpoint& endpoint) {
  const std::string topic = TopicName(endpoint);
  return topic.ends_with("/_action/feedback") ? Without(topic, {"/_action/feedback"}) : "";
}
std::string PlainRos2Command::ActionServerName(const Endpoint& endpoint) {
  return endpoint.reader ? "" : ActionName(endpoint);
}
std::string PlainRos2Command::ActionClientName(const Endpoint& endpoint) {
  return endpoint.reader ? ActionName(endpoint) : "";
}

PlainRos2Command::NamesAndTypes PlainRos2Command::Names(
    const Node* node, std::string (*kind)(const Endpoint&)) const {
  NamesAndTypes names;
  for (const auto& [gid, endpoint] : endpoints_) {
    if (node != nullptr && !node->endpoints.contains(gid)) continue;
    const std::string name = kind(endpoint);
    if (name.empty()) continue;
    const bool service = !StartsWith(endpoint.topic, "rt/");
    const bool action = name != endpoint.topic.substr(2) && !service;
    const std::string type = RosType(endpoint.type);
    names[name].insert(service  ? Without(type, {"_Request", "_Response"})
                       : action ? Without(type, {"_FeedbackMessage"})
                                : type);
  }
  return names;
}

std::string PlainRos2Command::NodeList(bool all) const {
  std::string text;
  std::string last;
  bool doubled = false;
  for (const Node& node : Nodes()) {
    if (!all && StartsWith(node.name, "_")) continue;
    doubled = doubled || node.full_name() == last;
    last = node.full_name();
    text += last + "\n";
  }
  return (doubled ? "WARNING: Be aware that there are nodes in the graph that share an exact name, "
                    "which can have unintended side effects.\n"
                  : "") +
         text;
}

std::string PlainRos2Command::NodeInfo(const std::string& name) const {
  const std::vector<Node> nodes = Nodes();
  const auto node = std::ranges::find(nodes, name, &Node::full_name);
  if (node == nodes.end()) return "Unable to find node '" + name + "'\n";
  std::string text = name + "\n";
  const auto print = [&](const std::string& title, std::string (*kind)(const Endpoint&)) {
    text += "  " + title + ":\n";
    std::string lines;
    for (const auto& [each, types] : Names(&*node, kind)) {
      if (!IsHidden(each)) lines += "    " + each + ": " + Joined(types) + "\n";
    }
    text += lines.empty() ? "\n" : lines;
  };
  print("Subscribers", SubscriberName);
  print("Publishers", PublisherName);
  print("Service Servers", ServerName);
  print("Service Clients", ClientName);
  print("Action Servers", ActionServerName);
  print("Action Clients", ActionClientName);
  return text;
}

namespace {

std::string ListOf(const std::map<std::string, std::set<std::string>>& names) {
  std::string text;
  for (const auto& [name, types] : names) {
    if (!IsHidden(name)) text += name + " [" + Joined(types) + "]\n";
  }
  return text;
}

}  // namespace

std::string PlainRos2Command::TopicList() const {
  return ListOf(Names(nullptr, TopicName));
}
std::string PlainRos2Command::ServiceList() const {
  return ListOf(Names(nullptr, ServiceName));
}
std::string PlainRos2Command::ActionList() const {
  return ListOf(Names(nullptr, ActionName));
}

std::string PlainRos2Command::ActionInfo(const std::string& action) const {
  std::string text = "Action: " + action + "\n";
  const auto print = [&](const std::string& title, std::string (*kind)(const Endpoint&)) {
    std::vector<std::string> names;
    for (const Node& node : Nodes()) {
      if (Names(&node, kind).contains(action)) names.push_back(node.full_name());
    }
    text += title + ": " + std::to_string(names.size()) + "\n";
    for (const std::string& name : names) text += "    " + name + "\n";
  };
  print("Action clients", ActionClientName);
  print("Action servers", ActionServerName);
  return text;
}

std::vector<std::pair<PlainRos2Command::Gid, PlainRos2Command::Endpoint>>
PlainRos2Command::EndpointsOf(const std::string& topic, bool readers) const {
  std::vector<std::pair<Gid, Endpoint>> found;
  for (const auto& [gid, endpoint] : endpoints_) {
    if (endpoint.reader == readers && TopicName(endpoint) == topic)
      found.emplace_back(gid, endpoint);
  }
  return found;
}

// rclpy's TopicEndpointInfo as text. Discovery has no history.
std::string PlainRos2Command::Describe(const Gid& gid, const Endpoint& endpoint) const {
  const Node* node = NodeOf(gid);
  std::string bytes;
  for (const std::uint8_t byte : gid) {
    std::array<char, 4> digits{};
    std::snprintf(digits.data(), digits.size(), "%02x", byte);
    bytes += (bytes.empty() ? "" : ".") + std::string(digits.data());
  }
  return "Node name: " + (node == nullptr ? kUnknownNode : node->name) +
         "\nNode namespace: " + (node == nullptr ? "_NODE_NAMESPACE_UNKNOWN_" : node->name_space) +
         "\nTopic type: " + RosType(endpoint.type) +
         "\nTopic type hash: " + (endpoint.hash.empty() ? "INVALID" : endpoint.hash) +
         "\nEndpoint type: " + (endpoint.reader ? "SUBSCRIPTION" : "PUBLISHER") +
         "\nGID: " + bytes +
         "\nQoS profile:\n  Reliability: " + (endpoint.reliable ? "RELIABLE" : "BEST_EFFORT") +
         "\n  History (Depth): UNKNOWN\n  Durability: " +
         (endpoint.latched ? "TRANSIENT_LOCAL" : "VOLATILE") +
         "\n  Lifespan: " + DurationText(endpoint.lifespan) +
         "\n  Deadline: " + DurationText(endpoint.deadline) +
         "\n  Liveliness: AUTOMATIC\n  Liveliness lease duration: " + DurationText(endpoint.lease);
}

std::string PlainRos2Command::TopicInfo(const std::string& topic) const {
  const NamesAndTypes all = Names(nullptr, TopicName);
  if (!all.contains(topic)) return "Unknown topic '" + topic + "'\n";
  std::string text = "Type: " + Joined(all.at(topic)) + "\n\n";
  for (const bool readers : {false, true}) {
    const auto endpoints = EndpointsOf(topic, readers);
    text += (readers ? "Subscription count: " : "Publisher count: ") +
            std::to_string(endpoints.size()) + "\n\n";
    for (const auto& [gid, endpoint] : endpoints) text += Describe(gid, endpoint) + "\n\n";
  }
  return text;
}

namespace {

using GoalId = std::array<std::uint8_t, 16>;
constexpr GoalId kGoal = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};

template <class Id>
void Fill(Id& id) {
  std::copy(kGoal.begin(), kGoal.end(), id.uuid);
}

// rosidl_runtime_py's message_to_yaml() of a message whose one field is a sequence.
std::string SequenceText(const dds_sequence_int32& numbers) {
  if (numbers._length == 0) return "sequence: []\n";
  std::string text = "sequence:\n";
  for (std::uint32_t i = 0; i < numbers._length; ++i) {
    text += "- " + std::to_string(numbers._buffer[i]) + "\n";
  }
  return text;
}

std::string StatusText(std::int8_t status) {
  constexpr std::array kNames = {"UNKNOWN",   "ACCEPTED", "EXECUTING", "CANCELING",
                                 "SUCCEEDED", "CANCELED", "ABORTED"};
  const auto at = static_cast<std::size_t>(status);
  return at < kNames.size() ? kNames[at] : "UNKNOWN";
}

}  // namespace

std::string PlainRos2Command::SendGoal(const std::string& action, int order) {
  using Feedback = example_interfaces_action_dds__Fibonacci_FeedbackMessage_;
  std::string feedbacks;
  const dds_entity_t feedback =
      participant_.Reader(example_interfaces_action_dds__Fibonacci_FeedbackMessage__desc,
                          "rt" + action + "/_action/feedback", [] {});
  std::string text = "Waiting for an action server to become available...\n";
  if (!AwaitMatches(feedback, 1)) return text;
  text += "Sending goal:\n     order: " + std::to_string(order) + "\n\n";
  example_interfaces_action_dds__Fibonacci_SendGoal_Request_ goal{};
  Fill(goal.goal_id);
  goal.goal.order = order;
  bool accepted = false;
  Call<example_interfaces_action_dds__Fibonacci_SendGoal_Response_>(
      action + "/_action/send_goal",
      example_interfaces_action_dds__Fibonacci_SendGoal_Request__desc,
      example_interfaces_action_dds__Fibonacci_SendGoal_Response__desc, goal,
      [&](const auto& reply) { accepted = reply.accepted; });
  if (!accepted) return text + "Goal was rejected.\n";
  text += "Goal accepted with ID: 0102030405060708090a0b0c0d0e0f10\n\n";
  participant_.Spin([&] {
    TakeAll<Feedback>(feedback, [&](const Feedback& sample) {
      feedbacks += "Feedback:\n    " + SequenceText(sample.feedback.sequence) + "\n";
    });
    return !feedbacks.empty();
  });
  example_interfaces_action_dds__Fibonacci_GetResult_Request_ request{};
  Fill(request.goal_id);
  Call<example_interfaces_action_dds__Fibonacci_GetResult_Response_>(
      action + "/_action/get_result",
      example_interfaces_action_dds__Fibonacci_GetResult_Request__desc,
      example_interfaces_action_dds__Fibonacci_GetResult_Response__desc, request,
      [&](const auto& reply) {
        text += feedbacks + "Result:\n    " + SequenceText(reply.result.sequence) +
                "\nGoal finished with status: " + StatusText(reply.status) + "\n";
      });
  return text;
}

std::string PlainRos2Command::LifecycleNodes() const {
  std::string text;
  for (const Node& node : Nodes()) {
    const NamesAndTypes services = Names(&node, ServerName);
    const auto get = services.find(node.full_name() + "/get_state");
    if (!StartsWith(node.name, "_") && get != services.end() &&
        get->second.contains("lifecycle_msgs/srv/GetState")) {
      text += node.full_name() + "\n";
    }
  }
  return text;
}

std::string PlainRos2Command::LifecycleGet(const std::string& node) {
  std::string text = "Node not found\n";
  Call<lifecycle_msgs_srv_dds__GetState_Response_>(
      node + "/get_state", lifecycle_msgs_srv_dds__GetState_Request__desc,
      lifecycle_msgs_srv_dds__GetState_Response__desc, lifecycle_msgs_srv_dds__GetState_Request_{},
      [&](const auto& reply) {
        text = std::string(reply.current_state.label) + " [" +
               std::to_string(reply.current_state.id) + "]\n";
      });
  return text;
}

std::vector<std::string> PlainRos2Command::Transitions(const std::string& node,
                                                       const std::string& service,
                                                       std::map<std::string, std::uint8_t>* ids) {
  std::vector<std::string> lines;
  Call<lifecycle_msgs_srv_dds__GetAvailableTransitions_Response_>(
      node + service, lifecycle_msgs_srv_dds__GetAvailableTransitions_Request__desc,
      lifecycle_msgs_srv_dds__GetAvailableTransitions_Response__desc,
      lifecycle_msgs_srv_dds__GetAvailableTransitions_Request_{}, [&](const auto& reply) {
        for (std::uint32_t i = 0; i < reply.available_transitions._length; ++i) {
          const auto& one = reply.available_transitions._buffer[i];
          if (ids != nullptr) ids->emplace(one.transition.label, one.transition.id);
          lines.push_back(
              std::string("- ") + one.transition.label + " [" + std::to_string(one.transition.id) +
              "]\n\tStart: " + one.start_state.label + "\n\tGoal: " + one.goal_state.label + "\n");
        }
      });
  return lines;
}

std::string PlainRos2Command::LifecycleList(const std::string& node, bool all) {
  std::string text;
  const char* service = all ? "/get_transition_graph" : "/get_available_transitions";
  for (const std::string& line : Transitions(node, service, nullptr)) text += line;
  return text;
}

std::string PlainRos2Command::LifecycleSet(const std::string& node, const std::string& transition) {
  std::map<std::string, std::uint8_t> ids;
  Transitions(node, "/get_available_transitions", &ids);
  if (!ids.contains(transition)) {
    std::string text = "Unknown transition requested, available ones are:";
    for (const auto& [label, id] : ids) text += "\n- " + label + " [" + std::to_string(id) + "]";
    return text + "\n";
  }
  std::string label = transition;
  lifecycle_msgs_srv_dds__ChangeState_Request_ request{};
  request.transition.id = ids[transition];
  request.transition.label = label.data();
  std::string text = "Exception while calling service of node '" + node + "'\n";
  Call<lifecycle_msgs_srv_dds__ChangeState_Response_>(
      node + "/change_state", lifecycle_msgs_srv_dds__ChangeState_Request__desc,
      lifecycle_msgs_srv_dds__ChangeState_Response__desc, request, [&](const auto& reply) {
        text = reply.success ? "Transitioning successful\n" : "Transitioning failed\n";
      });
  return text;
}

// It waits 5 s for the services of each node that has none.
std::string PlainRos2Command::ParamList() {
  std::string text;
  for (const Node& node : Nodes()) {
    if (StartsWith(node.name, "_")) continue;
    std::set<std::string> names;
    const bool answered = Call<rcl_interfaces_srv_dds__ListParameters_Response_>(
        node.full_name() + "/list_parameters", rcl_interfaces_srv_dds__ListParameters_Request__desc,
        rcl_interfaces_srv_dds__ListParameters_Response__desc,
        rcl_interfaces_srv_dds__ListParameters_Request_{}, [&](const auto& reply) {
          for (std::uint32_t i = 0; i < reply.result.names._length; ++i) {
            names.insert(reply.result.names._buffer[i]);
          }
        });
    if (!answered) {
      text += "Wait for service timed out waiting for parameter services for node " +
              node.full_name() + "\n";
      continue;
    }
    text += node.full_name() + ":\n";
    for (const std::string& name : names) text += "  " + name + "\n";
  }
  return text;
}

std::string PlainRos2Command::ParamGet(const std::string& node, const std::string& name) {
  std::string wanted = name;
  std::array<char*, 1> names = {wanted.data()};
  rcl_interfaces_srv_dds__GetParameters_Request_ request{};
  request.names = {1, 1, names.data(), false};
  std::string text = "Node not found\n";
  Call<rcl_interfaces_srv_dds__GetParameters_Response_>(
      node + "/get_parameters", rcl_interfaces_srv_dds__GetParameters_Request__desc,
      rcl_interfaces_srv_dds__GetParameters_Response__desc, request, [&](const auto& reply) {
        text = reply.values._length == 0 ? "Parameter not set\n"
                                         : ValueText(reply.values._buffer[0]) + "\n";
      });
  return text;
}

std::string PlainRos2Command::ParamSet(const std::string& node, const std::string& name,
                                       const std::string& value) {
  std::string wanted = name, text_value = value;
  rcl_interfaces_msg_dds__Parameter_ parameter{};
  parameter.name = wanted.data();
  parameter.value.type = 4;
  parameter.value.string_value = text_value.data();
  rcl_interfaces_srv_dds__SetParameters_Request_ request{};
  request.parameters = {1, 1, &parameter, false};
  std::string text = "Node not found\n";
  Call<rcl_interfaces_srv_dds__SetParameters_Response_>(
      node + "/set_parameters", rcl_interfaces_srv_dds__SetParameters_Request__desc,
      rcl_interfaces_srv_dds__SetParameters_Response__desc, request, [&](const auto& reply) {
        const auto& result = reply.results._buffer[0];
        text = result.successful ? "Set parameter successful" : "Setting parameter failed";
        if (*result.reason != '\0') text += std::string(": ") + result.reason;
        text += "\n";
      });
  return text;
}

// As rmw's qos_profile_check_compatible().
std::string PlainRos2Command::DoctorQos() const {
  std::string text;
  for (const auto& [topic, types] : Names(nullptr, TopicName)) {
    for (const auto& [offering, writer] : EndpointsOf(topic, false)) {
      for (const auto& [requesting, reader] : EndpointsOf(topic, true)) {
        std::string why;
        if (!writer.reliable && reader.reliable)
          why += " Best effort publisher and reliable subscription;";
        if (!writer.latched && reader.latched)
          why += " Volatile publisher and transient local subscription;";
        if (writer.deadline > reader.deadline) why += " Publisher's deadline is longer;";
        if (writer.lease > reader.lease) why += " Publisher's liveliness lease is longer;";
        if (why.empty()) continue;
        const Node* from = NodeOf(offering);
        const Node* to = NodeOf(requesting);
        text += topic + ": " + (from == nullptr ? kUnknownNode : from->full_name()) + ", " +
                (to == nullptr ? kUnknownNode : to->full_name()) + ": ERROR:" + why + "\n";
      }
    }
  }
  return text;
}

std::string PlainRos2Command::DoctorTopics() const {
  std::string text;
  for (const auto& [topic, types] : Names(nullptr, TopicName)) {
    if (IsHidden(topic)) continue;
    const bool writers = !EndpointsOf(topic, false).empty();
    const bool readers = !EndpointsOf(topic, true).empty();
    if (writers && !readers) text += "Publisher without subscriber detected on " + topic + ".\n";
    if (!writers && readers) text += "Subscriber without publisher detected on " + topic + ".\n";
  }
  return text;
}

dds_qos_t* PlainRos2Command::QosOfPublishers(const std::string& topic) const {
  const auto publishers = EndpointsOf(topic, false);
  const bool reliable =
      std::ranges::all_of(publishers, [](const auto& each) { return each.second.reliable; });
  const bool latched =
      std::ranges::all_of(publishers, [](const auto& each) { return each.second.latched; });
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_SECS(1));
  dds_qset_durability(qos, latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  return qos;
}

bool PlainRos2Command::AwaitMatches(dds_entity_t reader, std::size_t publishers) {
  return participant_.Spin([&] {
    dds_subscription_matched_status_t status{};
    dds_get_subscription_matched_status(reader, &status);
    return status.current_count >= publishers;
  });
}

// Samples are not taken, so that the type has to have the right name only.
std::string PlainRos2Command::BagRecord() {
  std::string text;
  for (const auto& [topic, types] : Names(nullptr, TopicName)) {
    const auto publishers = EndpointsOf(topic, false);
    if (IsHidden(topic) || publishers.empty()) continue;
    dds_topic_descriptor_t type = std_msgs_msg_dds__UInt8__desc;
    type.m_typename = publishers[0].second.type.c_str();
    const dds_entity_t named =
        dds_create_topic(participant_.entity(), &type, ("rt" + topic).c_str(), nullptr, nullptr);
    dds_qos_t* qos = QosOfPublishers(topic);
    const dds_entity_t reader = dds_create_reader(participant_.entity(), named, qos, nullptr);
    dds_delete_qos(qos);
    dds_set_status_mask(reader, DDS_SUBSCRIPTION_MATCHED_STATUS);
    participant_.Attach(reader, [reader] {
      std::uint32_t status = 0;
      dds_take_status(reader, &status, DDS_SUBSCRIPTION_MATCHED_STATUS);
    });
    text += "Subscribed to topic '" + topic + "'";
    if (!AwaitMatches(reader, publishers.size())) {
      text += ", but not to each of its " + std::to_string(publishers.size()) + " publishers";
    }
    text += "\n";
    dds_delete(reader);
    dds_delete(named);
  }
  return text;
}

bool PlainRos2Command::BagPlay(const dds_topic_descriptor_t& type, const std::string& topic,
                               dds_qos_t* recorded, const void* sample) {
  const dds_entity_t named =
      dds_create_topic(participant_.entity(), &type, ("rt" + topic).c_str(), nullptr, nullptr);
  const dds_entity_t writer = dds_create_writer(participant_.entity(), named, recorded, nullptr);
  dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS);
  participant_.Attach(writer, [writer] {
    std::uint32_t status = 0;
    dds_take_status(writer, &status, DDS_PUBLICATION_MATCHED_STATUS);
  });
  const bool matched = participant_.Spin([&] {
    const std::size_t readers = EndpointsOf(topic, true).size();
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer, &status);
    return readers > 0 && status.current_count >= readers;
  });
  return matched && dds_write(writer, sample) == DDS_RETCODE_OK &&
         dds_wait_for_acks(writer, DDS_SECS(120)) == DDS_RETCODE_OK;
}

bool PlainRos2Command::AwaitPublisher(const std::string& topic) {
  return participant_.Spin([&] { return !EndpointsOf(topic, false).empty(); });
}

double PlainRos2Command::Hz(const dds_topic_descriptor_t& type, const std::string& topic,
                            int count) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 5);
  std::vector<dds_time_t> times;
  Receive(type, topic, qos, count, [&](const void*) { times.push_back(dds_time()); });
  if (times.size() < 2) return 0;
  const dds_duration_t took = times.back() - times.front();
  return static_cast<double>(times.size() - 1) * DDS_NSECS_IN_SEC / static_cast<double>(took);
}

void PlainRos2Command::Receive(const dds_topic_descriptor_t& type, const std::string& topic,
                               dds_qos_t* qos, int count,
                               const std::function<void(const void*)>& on_sample) {
  const dds_entity_t named =
      dds_create_topic(participant_.entity(), &type, ("rt" + topic).c_str(), nullptr, nullptr);
  const dds_entity_t reader = dds_create_reader(participant_.entity(), named, qos, nullptr);
  dds_delete_qos(qos);
  dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS);
  int received = 0;
  const auto take = [&] {
    void* loan = nullptr;
    dds_sample_info_t info;
    while (received < count && dds_take(reader, &loan, &info, 1, 1) == 1) {
      if (info.valid_data) {
        on_sample(loan);
        ++received;
      }
      dds_return_loan(reader, &loan, 1);
      loan = nullptr;
    }
    return received == count;
  };
  participant_.Attach(reader, [] {});
  participant_.Spin(take);
  dds_delete(reader);
}

PlainRos2Command::Client& PlainRos2Command::ClientOf(const std::string& service,
                                                     const dds_topic_descriptor_t& request,
                                                     const dds_topic_descriptor_t& response) {
  const auto [found, is_new] = clients_.try_emplace(service);
  Client& client = found->second;
  if (!is_new) return client;
  std::string id = "clientid=";
  for (std::size_t i = 0; i < self_.size(); ++i) {
    std::array<char, 8> part{};
    std::snprintf(part.data(), part.size(), i == 0 ? "%02x" : ".%x", self_[i]);
    id += part.data();
  }
  id += ".0.0.0.0.0.0.0." + std::to_string(clients_.size()) + ";";
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  dds_qset_writer_data_lifecycle(qos, false);
  dds_qset_userdata(qos, id.data(), id.size());
  const auto topic = [this](const dds_topic_descriptor_t& type, const std::string& name) {
    return dds_create_topic(participant_.entity(), &type, name.c_str(), nullptr, nullptr);
  };
  client.writer = dds_create_writer(participant_.entity(),
                                    topic(request, "rq" + service + "Request"), qos, nullptr);
  client.reader = dds_create_reader(participant_.entity(),
                                    topic(response, "rr" + service + "Reply"), qos, nullptr);
  dds_delete_qos(qos);
  dds_get_instance_handle(client.writer, &client.id);
  dds_set_status_mask(client.writer, DDS_PUBLICATION_MATCHED_STATUS);
  dds_set_status_mask(client.reader, DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS);
  const auto read_matches = [writer = client.writer, reader = client.reader] {
    std::uint32_t status = 0;
    dds_take_status(writer, &status, DDS_PUBLICATION_MATCHED_STATUS);
    dds_take_status(reader, &status, DDS_SUBSCRIPTION_MATCHED_STATUS);
  };
  participant_.Attach(client.reader, read_matches);
  participant_.Attach(client.writer, [] {});
  return client;
}

// As rmw_cyclonedds_cpp's check_for_service_reader_writer(): two matched endpoints with one id.
bool PlainRos2Command::AwaitService(Client& client) {
  const auto ids = [](dds_entity_t entity, auto matched, auto data) {
    std::array<dds_instance_handle_t, kBatch> handles{};
    std::set<std::string> found;
    const dds_return_t count = matched(entity, handles.data(), handles.size());
    for (int i = 0; i < std::min<int>(count, kBatch); ++i) {
      dds_builtintopic_endpoint_t* endpoint = data(entity, handles[i]);
      if (endpoint == nullptr) continue;
      const std::string id = ValueOf(endpoint->qos, "serviceid");
      if (!id.empty()) found.insert(id);
      dds_builtintopic_free_endpoint(endpoint);
    }
    return found;
  };
  return participant_.Spin(
      [&] {
        const auto servers =
            ids(client.writer, dds_get_matched_subscriptions, dds_get_matched_subscription_data);
        const auto repliers =
            ids(client.reader, dds_get_matched_publications, dds_get_matched_publication_data);
        return std::ranges::any_of(servers, [&](const auto& id) { return repliers.contains(id); });
      },
      kWaitForService / DDS_NSECS_IN_MSEC);
}

}  // namespace musher::testing
