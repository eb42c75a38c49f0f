#include "musher/wire/security/permissions.hpp"

#include <utility>

#include "musher/base/date_text.hpp"
#include "musher/transport/service_names.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::transport::keys {
namespace {

using Topics = std::vector<std::string>;

std::string Element(const std::string& name, const std::string& value) {
  return "<" + name + ">" + value + "</" + name + ">\n";
}

// In the namespace "" and in every other; '*' matches slashes, too.
Topics InEveryNamespace(const std::string& topic) {
  return {topic, topic.substr(0, 3) + "*/" + topic.substr(3)};
}

// DDS topics of ROS 2 topics, of service requests and of service replies.
struct Names {
  Topics topics;
  Topics services;
};

Topics Mangled(const Topics& names, const std::string& before, const std::string& after) {
  Topics topics;
  for (const std::string& name : names) {
    for (const std::string& topic : InEveryNamespace(before + name + after)) {
      topics.push_back(topic);
    }
  }
  return topics;
}

Topics DataTopics(const Topics& names) {
  return Mangled(names, "rt/", "");
}
Topics Requests(const Topics& services) {
  return Mangled(services, "rq/", "Request");
}
Topics Replies(const Topics& services) {
  return Mangled(services, "rr/", "Reply");
}

// The services of an actuator, "*" for all actuators: Musher's, CyberDog's and ROS 2's.
Topics ServicesOf(const std::string& actuator) {
  return {CommandService("", actuator), actuator + "machine_service", actuator + "/change_state",
          actuator + "/get_state"};
}

// The services of a machine that change nothing, and all its services, for operators only.
Topics Queries() {
  return {MachineService("", "get_status"), MachineService("", "get_plan"),
          MachineService("", "get_capabilities"), MachineService("", "get_history"),
          MachineService("", "get_switch")};
}
const std::string kAllMachineServices = "musher/*";

// The state of an application's state machine, and the skills of an actuator with their runs. Open
// to all identities that may exchange data.
const Topics kBehaviorQueries = {"*/get_behavior", "*/get_skill"};
const Topics kBehaviorPublishes = {"*/behavior_state", "skills", "skill_feedback"};

Topics operator+(Topics one, const Topics& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

Topics AllServicesOf(const ExtensionInterfaces& extension) {
  return extension.queries + extension.services + extension.operator_services;
}

Topics AllTopicsOf(const ExtensionInterfaces& extension) {
  const Topics services = AllServicesOf(extension);
  return DataTopics(extension.published + extension.subscribed + extension.operator_topics) +
         Requests(services) + Replies(services);
}

// All topics of Musher itself and of the extension: none is open to all.
Topics Reserved(const ExtensionInterfaces& extension) {
  Topics topics;
  for (const std::string& name :
       {std::string("musher/*"), std::string("*/musher_command*"), std::string("*machine_service*"),
        std::string("*/change_state*"), std::string("*/get_state*")}) {
    for (const char* kind : {"rt/", "rq/", "rr/"}) {
      for (const std::string& topic : InEveryNamespace(kind + name)) topics.push_back(topic);
    }
  }
  return topics + AllTopicsOf(extension);
}

// One direction of a rule. `partition`: only in this one; nullopt: in every partition.
struct Criteria {
  const char* direction;  // "publish" or "subscribe"
  Topics topics;
  std::optional<std::string> partition = std::nullopt;
};

std::string Xml(const Criteria& criteria) {
  std::string topics;
  for (const std::string& topic : criteria.topics) topics += Element("topic", topic);
  // "*" matches every partition including the default one; without it only the default one matches.
  const std::string partition = Element("partition", criteria.partition.value_or("*"));
  return Element(criteria.direction, Element("topics", topics) + Element("partitions", partition));
}

// Cyclone's parser accepts none above 230.
const std::string kAllDomains =
    "<domains><id_range><min>0</min><max>230</max></id_range></domains>\n";

std::string Rule(const char* kind, const std::vector<Criteria>& all) {
  std::string text = kAllDomains;
  for (const Criteria& criteria : all) {
    if (!criteria.topics.empty()) text += Xml(criteria);
  }
  return Element(kind, text);
}

const Topics kStatuses = DataTopics({ActuatorStatusTopic(""), ActuatorHeartbeatTopic("")});
const Topics kStops = DataTopics({EmergencyStopTopic("")});
const Topics kPermits = DataTopics({PermitTopic("")});
const Topics kAnnouncements = DataTopics({ControllerHeartbeatTopic("")});
// Which nodes a process has (`ros2 node list`); of the others it is among what is not reserved.
const Topics kNodeGraph = {"ros_discovery_info"};
const Topics kMachine =
    DataTopics({MachineStatusTopic(""), CapabilitiesTopic(""), std::string(kMachinesTopic)});

std::vector<Criteria> OfController(const ExtensionInterfaces& extension) {
  const Topics published =
      kAnnouncements + kMachine + kStops +
      DataTopics(extension.published + Topics{MachineService("", "transition_event")});
  const Topics answered = Replies({kAllMachineServices}) + Replies(AllServicesOf(extension));
  return {{"publish", published + answered + Requests(ServicesOf("*"))}, {"subscribe", {"*"}}};
}

std::vector<Criteria> OfActuator(const std::string& name, const ExtensionInterfaces& extension) {
  const Topics called = extension.queries + extension.services;
  return {{"publish", kStatuses, name},
          {"publish", kStops + Replies(ServicesOf(name)) + DataTopics(extension.subscribed) +
                          Requests(called)},
          {"subscribe", kAnnouncements + kStops + kPermits + kMachine + Requests(ServicesOf(name)) +
                            DataTopics(extension.published) + Replies(called)}};
}

std::vector<Criteria> OfOperator(const ExtensionInterfaces& extension) {
  const Topics called = AllServicesOf(extension);
  return {{"publish", kStops + kPermits + Requests({kAllMachineServices}) + Requests(called) +
                          DataTopics(extension.subscribed + extension.operator_topics)},
          {"subscribe", kMachine + kStatuses + kStops + kAnnouncements +
                            Replies({kAllMachineServices}) + Replies(called) +
                            DataTopics(extension.published)}};
}

std::vector<Criteria> OfObserver(const ExtensionInterfaces& extension) {
  const Topics called = Queries() + extension.queries + kBehaviorQueries;
  return {{"publish", Requests(called) + kNodeGraph},
          {"subscribe", kMachine + kStatuses + Replies(called) +
                            DataTopics(extension.published + kBehaviorPublishes)}};
}

std::vector<Criteria> Of(const Grant& grant, const ExtensionInterfaces& extension) {
  switch (grant.role) {
    case Role::kController:
      return OfController(extension);
    case Role::kActuator:
      return OfActuator(grant.name, extension);
    case Role::kOperator:
      return OfOperator(extension);
    case Role::kObserver:
      break;
  }
  return OfObserver(extension);
}

std::string Document(const std::string& body) {
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<dds>\n" + body + "</dds>\n";
}

}  // namespace

// Each writer's samples are protected with a key of its own, which only permitted readers get: a
// reader of one topic cannot impersonate a writer of another.
std::string GovernanceXml(Protection protection) {
  const std::string kind = protection == Protection::kSigned ? "SIGN" : "ENCRYPT";
  const std::string topic_rule = Element(
      "topic_rule",
      Element("topic_expression", "*") + Element("enable_discovery_protection", "true") +
          Element("enable_liveliness_protection", "true") +
          Element("enable_read_access_control", "true") +
          Element("enable_write_access_control", "true") +
          Element("metadata_protection_kind", kind) + Element("data_protection_kind", "NONE"));
  return Document(Element(
      "domain_access_rules",
      Element("domain_rule", kAllDomains + Element("allow_unauthenticated_participants", "false") +
                                 Element("enable_join_access_control", "true") +
                                 Element("discovery_protection_kind", kind) +
                                 Element("liveliness_protection_kind", kind) +
                                 Element("rtps_protection_kind", "NONE") +
                                 Element("topic_access_rules", topic_rule))));
}

std::string PermissionsXml(const Grant& grant, const ExtensionInterfaces& extension) {
  std::string rules = Rule("allow_rule", Of(grant, extension));
  if (grant.role != Role::kObserver) {
    const Topics reserved = Reserved(extension);
    rules += Rule("deny_rule", {{"publish", reserved}, {"subscribe", reserved}});
    rules += Rule("allow_rule", {{"publish", {"*"}}, {"subscribe", {"*"}}});
  }
  return Document(Element(
      "permissions", "<grant name=\"" + grant.name + "\">\n" +
                         Element("subject_name", grant.subject) +
                         Element("validity", Element("not_before", FormatUtc(grant.not_before)) +
                                                 Element("not_after", FormatUtc(grant.not_after))) +
                         rules + Element("default", "DENY") + "</grant>\n"));
}

}  // namespace musher::transport::keys
