#include "musher/test/contract/plain_lifecycle_manager.hpp"

#include <humble.h>

#include <algorithm>
#include <utility>

namespace musher::testing {
namespace {

constexpr std::uint8_t kConfigure = 1;
constexpr std::uint8_t kCleanup = 2;
constexpr std::uint8_t kActivate = 3;
constexpr std::uint8_t kDeactivate = 4;
constexpr std::uint8_t kUnconfiguredShutdown = 5;

std::string Resolve(const std::string& name_space, const std::string& name) {
  return name_space.empty() ? name : name_space + "/" + name;
}

std::string Text(const lifecycle_msgs_msg_dds__State_& state) {
  return std::string(state.label) + " [" + std::to_string(state.id) + "]";
}

}  // namespace

PlainParticipant::PlainParticipant(int domain)
    : domain_(dds_create_domain(static_cast<dds_domainid_t>(domain), kLoopback)),
      participant_(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr)),
      waitset_(dds_create_waitset(participant_)),
      qos_(dds_create_qos()) {
  dds_qset_reliability(qos_, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos_, DDS_HISTORY_KEEP_LAST, 10);
  dds_qset_writer_data_lifecycle(qos_, false);
}

PlainParticipant::~PlainParticipant() {
  dds_delete_qos(qos_);
  dds_delete(participant_);
  if (domain_ > 0) dds_delete(domain_);
}

dds_entity_t PlainParticipant::Topic(const dds_topic_descriptor_t& type,
                                     const std::string& topic) const {
  return dds_create_topic(participant_, &type, topic.c_str(), nullptr, nullptr);
}

dds_entity_t PlainParticipant::Writer(const dds_topic_descriptor_t& type,
                                      const std::string& topic) const {
  const dds_entity_t writer = dds_create_writer(participant_, Topic(type, topic), qos_, nullptr);
  dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS);
  dds_waitset_attach(waitset_, writer, -1);
  return writer;
}

dds_entity_t PlainParticipant::Reader(const dds_topic_descriptor_t& type, const std::string& topic,
                                      std::function<void()> on_data) {
  const dds_entity_t reader = dds_create_reader(participant_, Topic(type, topic), qos_, nullptr);
  dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS);
  Attach(reader, std::move(on_data));
  return reader;
}

void PlainParticipant::Attach(dds_entity_t reader, std::function<void()> on_data) {
  dds_waitset_attach(waitset_, reader, static_cast<dds_attach_t>(on_data_.size()));
  on_data_.push_back(std::move(on_data));
}

void PlainParticipant::Every(std::int64_t ms, std::function<void()> work) {
  timers_.push_back({dds_time() + DDS_MSECS(ms), DDS_MSECS(ms), std::move(work)});
}

bool PlainParticipant::Spin(const std::function<bool()>& done, std::int64_t ms) {
  const dds_time_t end = dds_time() + DDS_MSECS(ms);
  const auto read = [this] {
    for (std::size_t i = 0; i < on_data_.size(); ++i) on_data_[i]();
  };
  read();  // what has arrived since the last call: a timer must not take it for silence
  while (!done()) {
    dds_time_t until = end;
    for (Timer& timer : timers_) {
      if (dds_time() >= timer.next) {
        timer.next = dds_time() + timer.period;
        timer.work();
      }
      until = std::min(until, timer.next);
    }
    if (dds_time() >= end) return done();
    dds_waitset_wait_until(waitset_, nullptr, 0, until);
    read();
  }
  return true;
}

bool PlainParticipant::SpinUntilMatched(dds_entity_t writer, dds_entity_t reader) {
  return Spin([&] {
    dds_publication_matched_status_t there{};
    dds_subscription_matched_status_t back{};
    dds_get_publication_matched_status(writer, &there);
    dds_get_subscription_matched_status(reader, &back);
    return there.current_count > 0 && back.current_count > 0;
  });
}

template <class Response>
void PlainLifecycleClient::Open(Service<Response>& service, const std::string& name,
                                const dds_topic_descriptor_t& request,
                                const dds_topic_descriptor_t& response) {
  service.writer = participant_.Writer(request, "rq/" + node_ + "/" + name + "Request");
  service.reader =
      participant_.Reader(response, "rr/" + node_ + "/" + name + "Reply", [this, &service] {
        TakeAll<Response>(service.reader, [&](const Response& reply) {
          if (reply.client_id != id_) return;
          ++answers_;
          if (reply.sequence_number == sequence_ && service.on_reply) service.on_reply(reply);
        });
      });
}

PlainLifecycleClient::PlainLifecycleClient(PlainParticipant& participant, const std::string& node)
    : participant_(participant), node_(node) {
  Open(change_state_, "change_state", lifecycle_msgs_srv_dds__ChangeState_Request__desc,
       lifecycle_msgs_srv_dds__ChangeState_Response__desc);
  Open(get_state_, "get_state", lifecycle_msgs_srv_dds__GetState_Request__desc,
       lifecycle_msgs_srv_dds__GetState_Response__desc);
  Open(get_states_, "get_available_states",
       lifecycle_msgs_srv_dds__GetAvailableStates_Request__desc,
       lifecycle_msgs_srv_dds__GetAvailableStates_Response__desc);
  Open(get_transitions_, "get_available_transitions",
       lifecycle_msgs_srv_dds__GetAvailableTransitions_Request__desc,
       lifecycle_msgs_srv_dds__GetAvailableTransitions_Response__desc);
  Open(get_graph_, "get_transition_graph",
       lifecycle_msgs_srv_dds__GetAvailableTransitions_Request__desc,
       lifecycle_msgs_srv_dds__GetAvailableTransitions_Response__desc);
  dds_get_instance_handle(change_state_.writer, &id_);
  event_reader_ = participant_.Reader(
      lifecycle_msgs_msg_dds__TransitionEvent__desc, "rt/" + node_ + "/transition_event", [this] {
        using Event = lifecycle_msgs_msg_dds__TransitionEvent_;
        TakeAll<Event>(event_reader_, [this](const Event& event) {
          events.push_back(std::string(event.transition.label) + ": " + event.start_state.label +
                           " -> " + event.goal_state.label);
        });
      });
}

bool PlainLifecycleClient::WaitForServices() {
  return participant_.SpinUntilMatched(change_state_.writer, change_state_.reader) &&
         participant_.SpinUntilMatched(get_state_.writer, get_state_.reader);
}

template <class Response, class Request>
bool PlainLifecycleClient::Call(Service<Response>& service, Request request,
                                const std::function<void(const Response&)>& on_reply) {
  if (!participant_.SpinUntilMatched(service.writer, service.reader)) return false;
  request.client_id = id_;
  request.sequence_number = ++sequence_;
  bool answered = false;
  service.on_reply = [&](const Response& reply) {
    on_reply(reply);
    answered = true;
  };
  dds_write(service.writer, &request);
  const bool done = participant_.Spin([&] { return answered; });
  service.on_reply = nullptr;
  return done;
}

std::optional<bool> PlainLifecycleClient::ChangeState(std::uint8_t id, const std::string& label) {
  std::string text = label;
  lifecycle_msgs_srv_dds__ChangeState_Request_ request{};
  request.transition.id = id;
  request.transition.label = text.data();
  std::optional<bool> success;
  Call<lifecycle_msgs_srv_dds__ChangeState_Response_>(
      change_state_, request, [&](const auto& reply) { success = reply.success; });
  return success;
}

void PlainLifecycleClient::ChangeStateWithoutWaiting(std::uint8_t id) {
  std::string none;
  lifecycle_msgs_srv_dds__ChangeState_Request_ request{};
  request.client_id = id_;
  request.sequence_number = ++sequence_;
  request.transition.id = id;
  request.transition.label = none.data();
  dds_write(change_state_.writer, &request);
}

std::string PlainLifecycleClient::GetState() {
  std::string state;
  Call<lifecycle_msgs_srv_dds__GetState_Response_>(
      get_state_, lifecycle_msgs_srv_dds__GetState_Request_{},
      [&](const auto& reply) { state = Text(reply.current_state); });
  return state;
}

std::vector<std::string> PlainLifecycleClient::GetAvailableStates() {
  std::vector<std::string> states;
  Call<lifecycle_msgs_srv_dds__GetAvailableStates_Response_>(
      get_states_, lifecycle_msgs_srv_dds__GetAvailableStates_Request_{}, [&](const auto& reply) {
        for (std::uint32_t i = 0; i < reply.available_states._length; ++i) {
          states.push_back(Text(reply.available_states._buffer[i]));
        }
      });
  return states;
}

std::vector<std::string> PlainLifecycleClient::Transitions(
    Service<lifecycle_msgs_srv_dds__GetAvailableTransitions_Response_>& service) {
  std::vector<std::string> transitions;
  Call<lifecycle_msgs_srv_dds__GetAvailableTransitions_Response_>(
      service, lifecycle_msgs_srv_dds__GetAvailableTransitions_Request_{}, [&](const auto& reply) {
        for (std::uint32_t i = 0; i < reply.available_transitions._length; ++i) {
          const auto& one = reply.available_transitions._buffer[i];
          transitions.push_back(std::string(one.transition.label) + " [" +
                                std::to_string(one.transition.id) + "] " + one.start_state.label +
                                " -> " + one.goal_state.label);
        }
      });
  return transitions;
}

std::vector<std::string> PlainLifecycleClient::GetAvailableTransitions() {
  return Transitions(get_transitions_);
}

std::vector<std::string> PlainLifecycleClient::GetTransitionGraph() {
  return Transitions(get_graph_);
}

namespace {

struct SinceIron {
  using Gid = rmw_dds_common_msg_dds__Gid_;
  using Node = rmw_dds_common_msg_dds__NodeEntitiesInfo_;
  using Info = rmw_dds_common_msg_dds__ParticipantEntitiesInfo_;
};

struct UpToHumble {
  using Gid = humble_msg_dds__Gid_;
  using Node = humble_msg_dds__NodeEntitiesInfo_;
  using Info = humble_msg_dds__ParticipantEntitiesInfo_;
};

// The topic's writer, once a reader is matched; 0: none is.
dds_entity_t AdvertiseNodes(PlainParticipant& participant, const dds_topic_descriptor_t& type) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
  const dds_entity_t topic =
      dds_create_topic(participant.entity(), &type, "ros_discovery_info", nullptr, nullptr);
  const dds_entity_t writer = dds_create_writer(participant.entity(), topic, qos, nullptr);
  dds_delete_qos(qos);
  dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS);
  participant.Attach(writer, [writer] {
    std::uint32_t status = 0;
    dds_take_status(writer, &status, DDS_PUBLICATION_MATCHED_STATUS);
  });
  const bool matched = participant.Spin([&] {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer, &status);
    return status.current_count > 0;
  });
  return matched ? writer : 0;
}

template <class Layout>
bool PublishNodesAs(PlainParticipant& participant, const dds_topic_descriptor_t& type,
                    const std::map<std::string, std::vector<dds_entity_t>>& nodes) {
  const dds_entity_t writer = AdvertiseNodes(participant, type);
  const auto fill = [](dds_entity_t entity, typename Layout::Gid& gid) {
    dds_guid_t guid{};
    dds_get_guid(entity, &guid);
    std::copy(std::begin(guid.v), std::end(guid.v), gid.data);
  };
  typename Layout::Info info{};
  fill(participant.entity(), info.gid);
  std::vector<std::string> names;
  std::vector<std::vector<typename Layout::Gid>> gids;
  for (const auto& [name, writers] : nodes) {
    names.push_back(name);
    std::vector<typename Layout::Gid>& all = gids.emplace_back(writers.size());
    for (std::size_t i = 0; i < writers.size(); ++i) fill(writers[i], all[i]);
  }
  std::vector<typename Layout::Node> entities(nodes.size());
  for (std::size_t i = 0; i < entities.size(); ++i) {
    const auto count = static_cast<std::uint32_t>(gids[i].size());
    entities[i].node_namespace[0] = '/';
    std::copy(names[i].begin(), names[i].end(), entities[i].node_name);
    entities[i].writer_gid_seq = {count, count, gids[i].data(), false};
  }
  const auto count = static_cast<std::uint32_t>(entities.size());
  info.node_entities_info_seq = {count, count, entities.data(), false};
  return writer > 0 && dds_write(writer, &info) == DDS_RETCODE_OK &&
         dds_wait_for_acks(writer, DDS_SECS(120)) == DDS_RETCODE_OK;
}

}  // namespace

bool PublishNodes(PlainParticipant& participant,
                  const std::map<std::string, std::vector<dds_entity_t>>& nodes) {
  return PublishNodesAs<SinceIron>(participant,
                                   rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc, nodes);
}

bool PublishNodesOfHumble(PlainParticipant& participant,
                          const std::map<std::string, std::vector<dds_entity_t>>& nodes) {
  dds_topic_descriptor_t type = humble_msg_dds__ParticipantEntitiesInfo__desc;
  type.m_typename = rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc.m_typename;
  return PublishNodesAs<UpToHumble>(participant, type, nodes);
}

PlainBond::PlainBond(PlainParticipant& participant, const std::string& name_space, std::string id,
                     double heartbeat_timeout_s)
    : participant_(participant),
      id_(std::move(id)),
      instance_("6f1c1f0e-plain-" + std::to_string(dds_time())),
      timeout_s_(heartbeat_timeout_s),
      writer_(participant.Writer(bond_msg_dds__Status__desc, "rt/" + Resolve(name_space, "bond"))),
      reader_(participant.Reader(bond_msg_dds__Status__desc, "rt/" + Resolve(name_space, "bond"),
                                 [this] { OnData(); })) {
  // bondcpp's first heartbeat comes one period after its start.
  participant_.Every(100, [this] {
    if (!ended_ && !broken_) Publish(true);
    const bool silent = dds_time() - last_ > static_cast<dds_duration_t>(timeout_s_ * 1e9);
    if (formed() && !ended_ && silent) broken_ = true;
  });
}

void PlainBond::Publish(bool active) {
  std::string none;
  std::string id = id_;
  std::string instance = instance_;
  bond_msg_dds__Status_ status{};
  status.header.frame_id = none.data();
  status.id = id.data();
  status.instance_id = instance.data();
  status.active = active;
  status.heartbeat_timeout = static_cast<float>(timeout_s_);
  status.heartbeat_period = 0.1F;
  dds_write(writer_, &status);
}

void PlainBond::OnData() {
  TakeAll<bond_msg_dds__Status_>(reader_, [this](const bond_msg_dds__Status_& status) {
    if (status.id != id_ || status.instance_id == instance_) return;
    if (status.active) {
      ++received_;
      last_ = dds_time();
    } else {
      broken_ = true;
      if (!ended_) Publish(false);
    }
  });
}

bool PlainBond::Break() {
  ended_ = true;  // from now on it does not answer
  if (broken_) return true;
  Publish(false);
  return participant_.Spin([this] { return broken_; }, 100);
}

PlainNav2Manager::PlainNav2Manager(int domain, std::string name_space,
                                   std::vector<std::string> nodes,
                                   std::optional<double> bond_timeout_s)
    : participant_(domain),
      name_space_(std::move(name_space)),
      nodes_(std::move(nodes)),
      bond_timeout_s_(bond_timeout_s) {
  for (const std::string& node : nodes_) {
    clients_[node] =
        std::make_unique<PlainLifecycleClient>(participant_, Resolve(name_space_, node));
  }
}

bool PlainNav2Manager::Change(const std::string& node, std::uint8_t transition) {
  static const std::map<std::uint8_t, std::string> expected = {
      {kConfigure, "inactive [2]"},
      {kCleanup, "unconfigured [1]"},
      {kActivate, "active [3]"},
      {kDeactivate, "inactive [2]"},
      {kUnconfiguredShutdown, "finalized [4]"}};
  PlainLifecycleClient& client = *clients_[node];
  if (!client.WaitForServices()) {
    errors_.push_back("waiting for the services of " + node);
    return false;
  }
  if (!client.ChangeState(transition).value_or(false) ||
      client.GetState() != expected.at(transition)) {
    errors_.push_back("Failed to change state for node: " + node);
    return false;
  }
  if (transition == kActivate) return FormBond(node);
  if (transition == kDeactivate && bonds_[node]) {
    bonds_[node]->Break();
    ended_bonds_.push_back(std::move(bonds_[node]));
  }
  return true;
}

bool PlainNav2Manager::FormBond(const std::string& node) {
  if (!bond_timeout_s_) return true;
  bonds_[node] = std::make_shared<PlainBond>(participant_, name_space_, node, *bond_timeout_s_);
  PlainBond& bond = *bonds_[node];
  if (participant_.Spin([&] { return bond.formed(); },
                        static_cast<std::int64_t>(*bond_timeout_s_ * 500))) {
    return true;
  }
  errors_.push_back("Server " + node + " was unable to be reached after " +
                    std::to_string(*bond_timeout_s_) +
                    "s by bond. This server may be misconfigured.");
  return false;
}

bool PlainNav2Manager::ChangeAll(std::uint8_t transition, bool reversed) {
  std::vector<std::string> nodes = nodes_;
  if (reversed) std::reverse(nodes.begin(), nodes.end());
  return std::all_of(nodes.begin(), nodes.end(),
                     [&](const std::string& node) { return Change(node, transition); });
}

bool PlainNav2Manager::Startup() {
  return ChangeAll(kConfigure, false) && ChangeAll(kActivate, false);
}

bool PlainNav2Manager::Pause() {
  return ChangeAll(kDeactivate, true);
}

bool PlainNav2Manager::Resume() {
  return ChangeAll(kActivate, false);
}

bool PlainNav2Manager::Reset() {
  return ChangeAll(kDeactivate, true) && ChangeAll(kCleanup, true);
}

bool PlainNav2Manager::Shutdown() {
  return ChangeAll(kDeactivate, true) && ChangeAll(kCleanup, true) &&
         ChangeAll(kUnconfiguredShutdown, true);
}

}  // namespace musher::testing
