#pragma once
// A bridge that echoes, such as one between two DDS domains: a second writer of the topics of
// actuators and controllers, which repeats old statuses and heartbeats of all of them, and leaves.
//
// Threads: the one of the network.

#include <deque>
#include <memory>

#include "musher/lifecycle/config/config.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

class Bridge {
 public:
  // The network must outlive it. Dropping the bridge ends its writers.
  Bridge(transport::sim::Network& network, const MachineConfig& config, std::uint64_t seed);

 private:
  template <class M>
  struct Topic {
    std::deque<M> samples;  // of others
    std::unique_ptr<transport::Publisher<M>> publisher;
    std::unique_ptr<transport::Subscription> subscription;
  };
  template <class M>
  void Open(Topic<M>& topic, const std::string& name, const transport::Qos& written,
            const transport::Qos& read);
  template <class M>
  void Repeat(Topic<M>& topic);

  transport::sim::Random random_;
  std::unique_ptr<transport::Node> node_;
  transport::ParticipantId participant_ = 0;
  Topic<msg::ActuatorStatus> statuses_;
  Topic<msg::ActuatorHeartbeat> heartbeats_;
  Topic<msg::MachineStatus> machines_;
  Topic<msg::ControllerHeartbeat> controllers_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::simulation
