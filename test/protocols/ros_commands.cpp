#include "musher/test/protocols/ros_commands.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>

namespace musher::testing {
namespace {

int DomainOfRos() {
  const char* domain = std::getenv("ROS_DOMAIN_ID");
  return domain == nullptr ? 0 : std::atoi(domain);
}

// A part of it begins with "_".
bool IsHidden(const std::string& name) {
  return name.find("/_") != std::string::npos;
}

// "a/srv/B_Request" as "a/srv/B".
std::string WithoutPart(std::string type) {
  for (const char* part : {"_Request", "_Response"}) {
    if (type.ends_with(part)) type.resize(type.size() - std::string(part).size());
  }
  return type;
}

std::string Join(const std::set<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// Names of a request; they live as long as this does.
class Names {
 public:
  explicit Names(const std::vector<std::string>& names) {
    for (const std::string& name : names) texts_.push_back(strdup(name.c_str()));
    sequence_ = {static_cast<std::uint32_t>(texts_.size()),
                 static_cast<std::uint32_t>(texts_.size()), texts_.data(), false};
  }
  Names(const Names&) = delete;
  Names& operator=(const Names&) = delete;
  ~Names() {
    for (char* text : texts_) std::free(text);
  }
  const dds_sequence_string& sequence() const { return sequence_; }

 private:
  std::vector<char*> texts_;
  dds_sequence_string sequence_{};
};

constexpr std::uint8_t kBool = 1;
constexpr std::uint8_t kInteger = 2;
constexpr std::uint8_t kString = 4;

std::string Text(const rcl_interfaces_msg_dds__ParameterValue_& value) {
  if (value.type == kBool) return value.bool_value ? "True" : "False";
  return value.type == kString ? value.string_value : "a value of another type";
}

}  // namespace

RosCommands::RosCommands() : participant_(DomainOfRos()) {}

bool RosCommands::AwaitNode(const std::string& node, const std::string& endpoint) {
  return graph_.Sees(
      [&](const RosGraph& graph) { return graph.Has(node, endpoint) && graph.unknown.empty(); });
}

std::string RosCommands::NodeList() const {
  std::set<std::string> names;
  for (const auto& [node, endpoints] : graph().nodes) {
    if (!IsHidden(node)) names.insert(node);
  }
  return Join(names);
}

std::string RosCommands::NodeInfo(const std::string& node) const {
  if (!graph().Has(node)) return "Unable to find node '" + node + "'\n";
  const auto list = [&](const std::string& kind, bool actions) {
    std::set<std::string> lines;
    for (const std::string& endpoint : graph().nodes.at(node)) {
      if (!endpoint.starts_with(kind + " ")) continue;
      std::string name = endpoint.substr(kind.size() + 1);
      std::string type = WithoutPart(graph().types.at(node + " " + endpoint));
      const std::string goal = "/_action/send_goal";
      const bool action = name.ends_with(goal);
      if (actions != action || (IsHidden(name) && !action)) continue;
      if (action) {
        name.resize(name.size() - goal.size());
        type.resize(type.size() - std::string("_SendGoal").size());
      }
      lines.insert("    " + name + ": " + type);
    }
    return Join(lines);
  };
  return node + "\n  Subscribers:\n" + list("subscription", false) + "  Publishers:\n" +
         list("publisher", false) + "  Service Servers:\n" + list("service", false) +
         "  Service Clients:\n" + list("client", false) + "  Action Servers:\n" +
         list("service", true) + "  Action Clients:\n" + list("client", true);
}

std::string RosCommands::TopicList() const {
  std::set<std::string> lines;
  for (const auto& [node, endpoints] : graph().nodes) {
    for (const std::string& endpoint : endpoints) {
      const std::string kind = endpoint.substr(0, endpoint.find(' '));
      const std::string name = endpoint.substr(kind.size() + 1);
      if ((kind != "publisher" && kind != "subscription") || IsHidden(name)) continue;
      lines.insert(name + " [" + graph().types.at(node + " " + endpoint) + "]");
    }
  }
  return Join(lines);
}

std::string RosCommands::TopicInfo(const std::string& topic) const {
  std::string type;
  std::array<std::string, 2> texts;  // of publishers, of subscriptions
  std::array<int, 2> counts{};
  for (const auto& [node, endpoints] : graph().nodes) {
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      const std::string endpoint = (side == 0 ? "publisher " : "subscription ") + topic;
      if (!endpoints.contains(endpoint)) continue;
      const std::string key = node + " " + endpoint;
      type = graph().types.at(key);
      ++counts.at(side);
      const std::size_t slash = node.rfind('/');
      const std::string& qos = graph().qos.at(key);
      const std::size_t first = qos.find(' ');
      const std::size_t second = qos.rfind(' ');
      std::string lifespan = qos.substr(second + 1);
      std::ranges::replace(lifespan, '_', ' ');
      texts.at(side) += "Node name: " + node.substr(slash + 1) +
                        "\nNode namespace: " + (slash == 0 ? "/" : node.substr(0, slash)) +
                        "\nTopic type: " + type + "\nTopic type hash: " + graph().hashes.at(type) +
                        "\nEndpoint type: " + (side == 0 ? "PUBLISHER" : "SUBSCRIPTION") +
                        "\nQoS profile:\n  Reliability: " + qos.substr(0, first) +
                        "\n  History (Depth): UNKNOWN\n  Durability: " +
                        qos.substr(first + 1, second - first - 1) + "\n  Lifespan: " + lifespan +
                        "\n\n";
    }
  }
  if (type.empty()) return "Unknown topic '" + topic + "'\n";
  return "Type: " + type + "\n\nPublisher count: " + std::to_string(counts[0]) + "\n\n" + texts[0] +
         "Subscription count: " + std::to_string(counts[1]) + "\n\n" + texts[1];
}

std::string RosCommands::ServiceType(const std::string& service) const {
  for (const auto& [node, endpoints] : graph().nodes) {
    const auto found = graph().types.find(node + " service " + service);
    if (found != graph().types.end()) return WithoutPart(found->second) + "\n";
  }
  return "";
}

// By the topic of the feedback, as rcl_action does it.
std::string RosCommands::ActionList() const {
  std::set<std::string> lines;
  for (const auto& [endpoint, type] : graph().types) {
    const std::string suffix = "/_action/feedback";
    const std::string part = "_FeedbackMessage";
    if (!endpoint.ends_with(suffix) || !type.ends_with(part)) continue;
    const std::size_t slash = endpoint.find('/', endpoint.rfind(' '));
    lines.insert(endpoint.substr(slash, endpoint.size() - slash - suffix.size()) + " [" +
                 type.substr(0, type.size() - part.size()) + "]");
  }
  return Join(lines);
}

// --- lifecycle ---

std::string RosCommands::LifecycleNodes() const {
  std::set<std::string> names;
  for (const auto& [node, endpoints] : graph().nodes) {
    const auto type = graph().types.find(node + " service " + node + "/get_state");
    if (type == graph().types.end() || IsHidden(node)) continue;
    if (WithoutPart(type->second) == "lifecycle_msgs/srv/GetState") names.insert(node);
  }
  return Join(names);
}

std::string RosCommands::LifecycleGet(const std::string& node) {
  PlainLifecycleClient client(participant_, node.substr(1));
  return client.GetState() + "\n";
}

std::string RosCommands::LifecycleList(const std::string& node) {
  PlainLifecycleClient client(participant_, node.substr(1));
  std::string text;
  for (const std::string& each : client.GetAvailableTransitions()) {
    const std::size_t bracket = each.find(']');
    const std::size_t arrow = each.find(" -> ");
    text += "- " + each.substr(0, bracket + 1) +
            "\n\tStart: " + each.substr(bracket + 2, arrow - bracket - 2) +
            "\n\tGoal: " + each.substr(arrow + 4) + "\n";
  }
  return text;
}

std::string RosCommands::LifecycleSet(const std::string& node, const std::string& transition) {
  PlainLifecycleClient client(participant_, node.substr(1));
  std::string available;
  for (const std::string& each : client.GetAvailableTransitions()) {
    const std::string label = each.substr(0, each.find(' '));
    const std::string id = each.substr(label.size() + 2, each.find(']') - label.size() - 2);
    available += "- " + label + " [" + id + "]\n";
    if (transition != label && transition != id) continue;
    const auto done = client.ChangeState(static_cast<std::uint8_t>(std::stoi(id)), label);
    if (!done) return "no answer\n";
    return *done ? "Transitioning successful\n" : "Transitioning failed\n";
  }
  return "Unknown transition requested, available ones are:\n" + available;
}

// --- parameters ---

template <class Response, class Request>
bool RosCommands::Call(const std::string& service, const dds_topic_descriptor_t& request_type,
                       const dds_topic_descriptor_t& response_type, Request request,
                       const std::function<void(const Response&)>& on_reply) {
  PlainParticipant tool(DomainOfRos());
  const dds_entity_t writer = tool.Writer(request_type, "rq" + service + "Request");
  bool answered = false;
  dds_entity_t reader = 0;
  reader = tool.Reader(response_type, "rr" + service + "Reply", [&] {
    TakeAll<Response>(reader, [&](const Response& response) {
      if (response.client_id != request.client_id) return;
      on_reply(response);
      answered = true;
    });
  });
  dds_get_instance_handle(writer, &request.client_id);
  request.sequence_number = 1;
  return tool.SpinUntilMatched(writer, reader) && dds_write(writer, &request) == DDS_RETCODE_OK &&
         tool.Spin([&] { return answered; });
}

std::vector<std::string> RosCommands::ParamNames(const std::string& node) {
  std::vector<std::string> names;
  Call<rcl_interfaces_srv_dds__ListParameters_Response_>(
      node + "/list_parameters", rcl_interfaces_srv_dds__ListParameters_Request__desc,
      rcl_interfaces_srv_dds__ListParameters_Response__desc,
      rcl_interfaces_srv_dds__ListParameters_Request_{}, [&](const auto& response) {
        for (std::uint32_t i = 0; i < response.result.names._length; ++i) {
          names.emplace_back(response.result.names._buffer[i]);
        }
      });
  std::ranges::sort(names);
  return names;
}

std::vector<std::string> RosCommands::ParamValues(const std::string& node,
                                                  const std::vector<std::string>& names) {
  const Names wanted(names);
  rcl_interfaces_srv_dds__GetParameters_Request_ request{};
  request.names = wanted.sequence();
  std::vector<std::string> values;
  Call<rcl_interfaces_srv_dds__GetParameters_Response_>(
      node + "/get_parameters", rcl_interfaces_srv_dds__GetParameters_Request__desc,
      rcl_interfaces_srv_dds__GetParameters_Response__desc, request, [&](const auto& response) {
        for (std::uint32_t i = 0; i < response.values._length; ++i) {
          const auto& value = response.values._buffer[i];
          values.push_back((value.type == kBool ? "Boolean value is: " : "String value is: ") +
                           Text(value));
        }
      });
  return values;
}

std::string RosCommands::ParamList() {
  std::string text;
  for (const auto& [node, endpoints] : graph().nodes) {
    if (IsHidden(node) || !graph().Has(node, "service " + node + "/list_parameters")) continue;
    text += node + ":\n";
    for (const std::string& name : ParamNames(node)) text += "  " + name + "\n";
  }
  return text;
}

std::string RosCommands::ParamGet(const std::string& node, const std::string& name) {
  const std::vector<std::string> values = ParamValues(node, {name});
  return values.empty() ? "Parameter not set.\n" : values.front() + "\n";
}

std::string RosCommands::ParamDump(const std::string& node) {
  std::string text = node + ":\n  ros__parameters:\n";
  const std::vector<std::string> names = ParamNames(node);
  const std::vector<std::string> values = ParamValues(node, names);
  for (std::size_t i = 0; i < names.size() && i < values.size(); ++i) {
    text += "    " + names[i] + ": " + values[i].substr(values[i].find(": ") + 2) + "\n";
  }
  return text;
}

std::string RosCommands::ParamDescribe(const std::string& node, const std::string& name) {
  const Names wanted({name});
  rcl_interfaces_srv_dds__DescribeParameters_Request_ request{};
  request.names = wanted.sequence();
  std::string text;
  Call<rcl_interfaces_srv_dds__DescribeParameters_Response_>(
      node + "/describe_parameters", rcl_interfaces_srv_dds__DescribeParameters_Request__desc,
      rcl_interfaces_srv_dds__DescribeParameters_Response__desc, request,
      [&](const auto& response) {
        for (std::uint32_t i = 0; i < response.descriptors._length; ++i) {
          const auto& each = response.descriptors._buffer[i];
          text += std::string("Parameter name: ") + each.name +
                  "\n  Type: " + (each.type == kBool ? "boolean" : "string") +
                  "\n  Description: " + each.description + "\n  Constraints:\n" +
                  (each.read_only ? "    Read only: true\n" : "");
        }
      });
  return text;
}

std::string RosCommands::ParamSet(const std::string& node, const std::string& name,
                                  const std::string& value) {
  char* end = nullptr;
  const std::int64_t number = std::strtoll(value.c_str(), &end, 10);
  const bool is_number = !value.empty() && *end == '\0';
  const Names texts({name, is_number ? "" : value});
  rcl_interfaces_msg_dds__Parameter_ parameter{};
  parameter.name = texts.sequence()._buffer[0];
  parameter.value.type = is_number ? kInteger : kString;
  parameter.value.integer_value = is_number ? number : 0;
  parameter.value.string_value = texts.sequence()._buffer[1];
  rcl_interfaces_srv_dds__SetParameters_Request_ request{};
  request.parameters = {1, 1, &parameter, false};
  std::string text;
  Call<rcl_interfaces_srv_dds__SetParameters_Response_>(
      node + "/set_parameters", rcl_interfaces_srv_dds__SetParameters_Request__desc,
      rcl_interfaces_srv_dds__SetParameters_Response__desc, request, [&](const auto& response) {
        for (std::uint32_t i = 0; i < response.results._length; ++i) {
          const auto& result = response.results._buffer[i];
          const std::string reason = result.reason;
          text += result.successful ? "Set parameter successful" : "Setting parameter failed";
          text += (reason.empty() ? "" : ": " + reason) + "\n";
        }
      });
  return text;
}

}  // namespace musher::testing
