#pragma once
// The QoS of readers that match whatever writers a topic has. Pure.

#include <vector>

#include "musher/transport/dds/topic_watch.hpp"
#include "musher/transport/endpoint.hpp"

namespace musher::view {

// What discovery knows of the QoS of a writer or reader; of its partition only whether it is empty.
transport::Qos QosOf(const transport::DiscoveredEndpoint& endpoint);

// The QoS of a reader that matches all of these writers.
transport::Qos QosMatchingAll(const std::vector<transport::Qos>& offered);

// The same where there is a reader already, whose latched samples were received: it only becomes
// less demanding.
transport::Qos QosMatchingAll(const std::vector<transport::Qos>& offered,
                              const transport::Qos& present);

}  // namespace musher::view
