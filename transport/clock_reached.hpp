#pragma once
// How far the processes that use /clock have come: a simulated world whose time runs in lockstep
// with them waits for it. Each Clock::FromTopic() publishes the time of a sample of /clock once its
// timers have run, while there is a subscriber; rosgraph_msgs/Clock, whatever the namespace.

#include "musher/transport/node.hpp"

namespace musher::transport {

inline constexpr const char* kClockReachedTopic = "clock/reached";
// The subscriber keeps a sample of each of many publishers, since the topic has no key.
inline constexpr Qos kClockReachedQos{Qos::Reliability::kReliable, Qos::Durability::kVolatile, 100};

}  // namespace musher::transport
