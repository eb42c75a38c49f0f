#include "musher/simulation/bridge.hpp"

#include "musher/wire/lifecycle_wire.hpp"

namespace musher::simulation {
namespace {

constexpr std::size_t kKept = 64;
constexpr Duration kPeriod = Milliseconds(200);

}  // namespace

Bridge::Bridge(transport::sim::Network& network, const MachineConfig& config, std::uint64_t seed)
    : random_(seed),
      node_(network.MakeNode("bridge")),
      participant_(network.ParticipantOf(*node_)) {
  Open(statuses_, transport::ActuatorStatusTopic(config.name_space), transport::kLatchedQos,
       transport::kLatchedFromManyQos);
  Open(heartbeats_, transport::ActuatorHeartbeatTopic(config.name_space), transport::kHeartbeatQos,
       transport::kHeartbeatQos);
  Open(machines_, transport::MachineStatusTopic(config.name_space), transport::kLatchedQos,
       transport::kLatchedFromManyQos);
  Open(controllers_, transport::ControllerHeartbeatTopic(config.name_space), transport::kLatchedQos,
       transport::kLatchedFromManyQos);
  timer_ = node_->loop().Every(kPeriod, [this] {
    Repeat(statuses_);
    Repeat(heartbeats_);
    Repeat(machines_);
    Repeat(controllers_);
  });
}

template <class M>
void Bridge::Open(Topic<M>& topic, const std::string& name, const transport::Qos& written,
                  const transport::Qos& read) {
  topic.publisher = transport::MakePublisher<M>(*node_, name, written).value();
  topic.subscription = transport::MakeSubscription<M>(
                           *node_, name,
                           [this, &topic](const M& sample, const transport::SampleInfo& info) {
                             if (info.participant == participant_) return;
                             topic.samples.push_back(sample);
                             if (topic.samples.size() > kKept) topic.samples.pop_front();
                           },
                           read)
                           .value();
}

template <class M>
void Bridge::Repeat(Topic<M>& topic) {
  if (topic.samples.empty()) return;
  static_cast<void>(topic.publisher->Publish(topic.samples[random_.Next() % topic.samples.size()]));
}

}  // namespace musher::simulation
