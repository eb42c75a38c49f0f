#pragma once
// Two ROS 2 programs in plain C: idlc's types on Cyclone, ROS 2's names and QoS, without Musher's
// code. PlainLifecycleClient sends the requests of `ros2 lifecycle`; PlainNav2Manager brings nodes
// up and down like nav2's lifecycle manager, with or without a bond, and records the errors that
// nav2 would log.
//
// Threads: each object is used on one thread.

#include <dds/dds.h>
#include <musher_idl.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace musher::testing {

// The setting of a ROS 2 process that communicates with a machine of the profile `local`.
inline constexpr const char* kLoopback =
    "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" "
    "multicast=\"true\"/></Interfaces></General></Domain></CycloneDDS>";

// Takes all samples; `on_sample` receives each one while it is on loan.
template <class T>
void TakeAll(dds_entity_t reader, const std::function<void(const T&)>& on_sample) {
  void* loan = nullptr;
  dds_sample_info_t info;
  while (dds_take(reader, &loan, &info, 1, 1) == 1) {
    if (info.valid_data) on_sample(*static_cast<const T*>(loan));
    dds_return_loan(reader, &loan, 1);
    loan = nullptr;
  }
}

// A participant with its readers and timers. It has one waitset and never polls.
class PlainParticipant {
 public:
  explicit PlainParticipant(int domain);
  ~PlainParticipant();
  PlainParticipant(const PlainParticipant&) = delete;
  PlainParticipant& operator=(const PlainParticipant&) = delete;

  dds_entity_t Writer(const dds_topic_descriptor_t& type, const std::string& topic) const;
  // `on_data` runs in Spin() when there are samples to take.
  dds_entity_t Reader(const dds_topic_descriptor_t& type, const std::string& topic,
                      std::function<void()> on_data);
  // The same with a reader made by the caller, whose matches `on_data` reads, too.
  void Attach(dds_entity_t reader, std::function<void()> on_data);
  dds_entity_t entity() const { return participant_; }
  // The same; `on_sample` receives each sample while it is on loan.
  template <class T>
  void Read(const dds_topic_descriptor_t& type, const std::string& topic,
            std::function<void(const T&)> on_sample) {
    auto reader = std::make_shared<dds_entity_t>();
    *reader = Reader(type, topic, [reader, on_sample = std::move(on_sample)] {
      TakeAll<T>(*reader, on_sample);
    });
  }
  // Runs `work` in Spin() with this period.
  void Every(std::int64_t ms, std::function<void()> work);
  // Waits until `done`; false after a timeout of `ms`.
  bool Spin(const std::function<bool()>& done, std::int64_t ms = 120'000);
  // Waits until the writer and the reader are matched.
  bool SpinUntilMatched(dds_entity_t writer, dds_entity_t reader);

 private:
  dds_entity_t Topic(const dds_topic_descriptor_t& type, const std::string& topic) const;

  dds_entity_t domain_;  // negative: it already existed in this process
  dds_entity_t participant_;
  dds_entity_t waitset_;
  dds_qos_t* qos_;
  std::vector<std::function<void()>> on_data_;
  struct Timer {
    dds_time_t next;
    dds_duration_t period;
    std::function<void()> work;
  };
  std::vector<Timer> timers_;
};

// The five services of one node, and its events.
class PlainLifecycleClient {
 public:
  // `node` with its namespace, "dog1/arm".
  PlainLifecycleClient(PlainParticipant& participant, const std::string& node);

  bool WaitForServices();
  // By id, or, as with `ros2 service call`, by label only. nullopt: no answer.
  std::optional<bool> ChangeState(std::uint8_t id, const std::string& label = "");
  // "inactive [2]"; empty without an answer.
  std::string GetState();
  std::vector<std::string> GetAvailableStates();  // "unknown [0]"
  // "configure [1] unconfigured -> configuring"
  std::vector<std::string> GetAvailableTransitions();
  std::vector<std::string> GetTransitionGraph();
  // "configure: unconfigured -> configuring", in the order of arrival.
  std::vector<std::string> events;

  dds_entity_t change_state_writer() const { return change_state_.writer; }
  // Sends a request and does not wait for the answer.
  void ChangeStateWithoutWaiting(std::uint8_t id);
  std::uint64_t answers() const { return answers_; }

 private:
  template <class Response>
  struct Service {
    dds_entity_t writer = 0;
    dds_entity_t reader = 0;
    std::function<void(const Response&)> on_reply;
  };
  template <class Response>
  void Open(Service<Response>& service, const std::string& name,
            const dds_topic_descriptor_t& request, const dds_topic_descriptor_t& response);
  template <class Response, class Request>
  bool Call(Service<Response>& service, Request request,
            const std::function<void(const Response&)>& on_reply);
  std::vector<std::string> Transitions(
      Service<lifecycle_msgs_srv_dds__GetAvailableTransitions_Response_>& service);

  PlainParticipant& participant_;
  const std::string node_;
  std::uint64_t id_;
  std::int64_t sequence_ = 0;
  std::uint64_t answers_ = 0;
  dds_entity_t event_reader_ = 0;
  Service<lifecycle_msgs_srv_dds__ChangeState_Response_> change_state_;
  Service<lifecycle_msgs_srv_dds__GetState_Response_> get_state_;
  Service<lifecycle_msgs_srv_dds__GetAvailableStates_Response_> get_states_;
  Service<lifecycle_msgs_srv_dds__GetAvailableTransitions_Response_> get_transitions_;
  Service<lifecycle_msgs_srv_dds__GetAvailableTransitions_Response_> get_graph_;
};

// The nodes of a process on `ros_discovery_info`, as rmw_cyclonedds publishes them: each with its
// writers. Returns once every process that reads the topic has them, and there is one.
bool PublishNodes(PlainParticipant& participant,
                  const std::map<std::string, std::vector<dds_entity_t>>& nodes);
// The same in the layout of Humble and before.
bool PublishNodesOfHumble(PlainParticipant& participant,
                          const std::map<std::string, std::vector<dds_entity_t>>& nodes);

// One side of a bond, like bondcpp's.
class PlainBond {
 public:
  PlainBond(PlainParticipant& participant, const std::string& name_space, std::string id,
            double heartbeat_timeout_s);

  bool formed() const { return received_ > 0; }
  bool broken() const { return broken_; }
  int received() const { return received_; }  // heartbeats of the other side
  // Ends it and waits 100 ms for the other side's end, like bondcpp's destructor.
  bool Break();

 private:
  void Publish(bool active);
  void OnData();

  PlainParticipant& participant_;
  const std::string id_;
  const std::string instance_;
  const double timeout_s_;
  dds_entity_t writer_;
  dds_entity_t reader_;
  bool ended_ = false;
  bool broken_ = false;
  int received_ = 0;
  dds_time_t last_ = 0;
};

class PlainNav2Manager {
 public:
  // Of the nodes in `name_space`, which may be empty. Forms no bonds without `bond_timeout_s`.
  PlainNav2Manager(int domain, std::string name_space, std::vector<std::string> nodes,
                   std::optional<double> bond_timeout_s = std::nullopt);

  bool Startup();   // configure and activate one after the other
  bool Pause();     // deactivate, in reverse order
  bool Resume();    // activate
  bool Reset();     // deactivate and cleanup
  bool Shutdown();  // deactivate, cleanup, shutdown

  PlainParticipant& participant() { return participant_; }
  PlainLifecycleClient& client(const std::string& node) { return *clients_.at(node); }
  PlainBond* bond(const std::string& node) { return bonds_[node].get(); }
  // The errors that nav2 would log.
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  bool Change(const std::string& node, std::uint8_t transition);
  bool ChangeAll(std::uint8_t transition, bool reversed);
  bool FormBond(const std::string& node);

  PlainParticipant participant_;
  const std::string name_space_;
  const std::vector<std::string> nodes_;
  const std::optional<double> bond_timeout_s_;
  std::map<std::string, std::unique_ptr<PlainLifecycleClient>> clients_;
  std::map<std::string, std::shared_ptr<PlainBond>> bonds_;
  std::vector<std::shared_ptr<PlainBond>> ended_bonds_;  // their timers still exist
  std::vector<std::string> errors_;
};

}  // namespace musher::testing
