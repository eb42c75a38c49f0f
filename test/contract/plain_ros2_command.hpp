#pragma once
// The command `ros2` of Jazzy in plain C: idlc's types on Cyclone, without Musher's code. It reads
// the graph and calls the services that ros2cli's sources read and call, and prints what they
// print, to the word. What they print to stderr is part of the text.
//
//   PlainRos2Command ros2(domain);
//   EXPECT_EQ(ros2.Await("active [3]\n", [&] { return ros2.LifecycleGet("/musher"); }), …);
//
// Threads: each object is used on one thread.

#include <array>
#include <compare>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "musher/test/contract/plain_lifecycle_manager.hpp"

namespace musher::testing {

class PlainRos2Command {
 public:
  explicit PlainRos2Command(int domain);

  // Runs `command` until it prints `text`, because discovery takes its time; at most 20 s. Returns
  // what it has printed last.
  std::string Await(const std::string& text, const std::function<std::string()>& command);

  // Names have a leading '/'. The lists of topics, services and actions are with types (-t).
  std::string NodeList(bool all = false) const;
  std::string NodeInfo(const std::string& node) const;
  std::string TopicList() const;
  std::string TopicInfo(const std::string& topic) const;  // --verbose
  std::string ServiceList() const;
  std::string ActionList() const;
  std::string ActionInfo(const std::string& action) const;
  // `ros2 action send_goal --feedback`, of example_interfaces/action/Fibonacci. The real one prints
  // feedback when it comes; here it is before the result.
  std::string SendGoal(const std::string& action, int order);
  std::string LifecycleNodes() const;
  std::string LifecycleGet(const std::string& node);
  std::string LifecycleList(const std::string& node, bool all = false);
  std::string LifecycleSet(const std::string& node, const std::string& transition);
  std::string ParamList();  // of all nodes
  std::string ParamGet(const std::string& node, const std::string& name);
  // `value`: a string, as its parser of YAML has found.
  std::string ParamSet(const std::string& node, const std::string& name, const std::string& value);
  // The findings of `ros2 doctor` about topics: pairs whose QoS does not fit.
  std::string DoctorQos() const;
  // Its warnings about topics that only have writers, or only readers.
  std::string DoctorTopics() const;

  // The QoS by which `ros2 topic echo` and `ros2 bag record` subscribe: that of the publishers.
  dds_qos_t* QosOfPublishers(const std::string& topic) const;
  // `ros2 topic echo`: `count` samples, each as `print` makes it, with "---" after each.
  template <class T>
  std::string Echo(const dds_topic_descriptor_t& type, const std::string& topic, int count,
                   const std::function<std::string(const T&)>& print) {
    std::string text;
    dds_qos_t* qos = AwaitPublisher(topic) ? QosOfPublishers(topic) : dds_create_qos();
    Receive(type, topic, qos, count,
            [&](const void* sample) { text += print(*static_cast<const T*>(sample)) + "\n---\n"; });
    return text;
  }
  // `ros2 bag record --all`: a line for each topic that it subscribes to, once its subscription has
  // matched all publishers; else the line says how many.
  std::string BagRecord();
  // `ros2 bag play` of one sample that was recorded of a publisher with this QoS. Returns once
  // every subscriber has it, and there is one.
  bool BagPlay(const dds_topic_descriptor_t& type, const std::string& topic, dds_qos_t* recorded,
               const void* sample);
  // `ros2 topic hz`: the average rate of `count` samples, which it takes best effort.
  double Hz(const dds_topic_descriptor_t& type, const std::string& topic, int count);
  // `ros2 service call`: waits for the service, calls, and calls `on_reply`. False: no reply.
  template <class Response, class Request>
  bool Call(const std::string& service, const dds_topic_descriptor_t& request_type,
            const dds_topic_descriptor_t& response_type, Request request,
            const std::function<void(const Response&)>& on_reply) {
    Client& client = ClientOf(service, request_type, response_type);
    if (!AwaitService(client)) return false;
    request.client_id = client.id;
    request.sequence_number = ++client.sequence;
    if (dds_write(client.writer, &request) != DDS_RETCODE_OK) return false;
    bool answered = false;
    return participant_.Spin([&] {
      TakeAll<Response>(client.reader, [&](const Response& reply) {
        if (reply.client_id != client.id || reply.sequence_number != client.sequence) return;
        answered = true;
        on_reply(reply);
      });
      return answered;
    });
  }

  PlainParticipant& participant() { return participant_; }

 private:
  using Gid = std::array<std::uint8_t, 16>;
  struct Endpoint {
    bool reader = false;
    Gid participant{};
    std::string topic, type, hash;  // on DDS
    bool reliable = false;
    bool latched = false;
    dds_duration_t lifespan = DDS_INFINITY;
    dds_duration_t deadline = DDS_INFINITY;
    dds_duration_t lease = DDS_INFINITY;
  };
  struct Node {
    std::string name_space, name;
    std::set<Gid> endpoints;

    std::string full_name() const { return (name_space == "/" ? "" : name_space) + "/" + name; }
  };
  // A client of a service; it is kept.
  struct Client {
    dds_entity_t writer = 0;
    dds_entity_t reader = 0;
    std::uint64_t id = 0;
    std::int64_t sequence = 0;
  };
  using NamesAndTypes = std::map<std::string, std::set<std::string>>;

  void TakeEndpoints(dds_entity_t reader, bool of_readers);
  void TakeParticipants(dds_entity_t reader);
  std::vector<Node> Nodes() const;  // those of ROS 2 processes that exist, by name
  const Node* NodeOf(const Gid& endpoint) const;
  // The names and types of the endpoints that `kind` gives a name.
  NamesAndTypes Names(const Node* node, std::string (*kind)(const Endpoint&)) const;
  std::vector<std::pair<Gid, Endpoint>> EndpointsOf(const std::string& topic, bool readers) const;
  std::string Describe(const Gid& gid, const Endpoint& endpoint) const;
  Client& ClientOf(const std::string& service, const dds_topic_descriptor_t& request,
                   const dds_topic_descriptor_t& response);
  bool AwaitService(Client& client);
  bool AwaitMatches(dds_entity_t reader, std::size_t publishers);
  bool AwaitPublisher(const std::string& topic);
  // Deletes `qos`.
  void Receive(const dds_topic_descriptor_t& type, const std::string& topic, dds_qos_t* qos,
               int count, const std::function<void(const void*)>& on_sample);
  std::vector<std::string> Transitions(const std::string& node, const std::string& service,
                                       std::map<std::string, std::uint8_t>* ids);

  static std::string TopicName(const Endpoint& endpoint);
  static std::string ServiceName(const Endpoint& endpoint);
  static std::string ServerName(const Endpoint& endpoint);
  static std::string ClientName(const Endpoint& endpoint);
  static std::string PublisherName(const Endpoint& endpoint);
  static std::string SubscriberName(const Endpoint& endpoint);
  static std::string ActionName(const Endpoint& endpoint);
  static std::string ActionServerName(const Endpoint& endpoint);
  static std::string ActionClientName(const Endpoint& endpoint);

  PlainParticipant participant_;
  Gid self_{};
  std::map<Gid, Endpoint> endpoints_;
  std::set<Gid> processes_;                 // participants with an enclave
  std::map<Gid, std::vector<Node>> nodes_;  // the latest of each participant
  std::map<std::string, Client> clients_;
};

}  // namespace musher::testing
