#pragma once
// What the processes of a robot agree on before they exchange messages: which network they are on,
// whose message layouts they use, and which clock the behaviour of modules follows.

#include <cstdint>

namespace musher {

enum class TransportProfile {
  kLocal,  // one host, loopback, many processes
  kLan,    // several hosts, links that lose packets
};

// The ROS 2 distributions whose message layouts are known, oldest first.
enum class RosDistro : std::uint8_t { kGalactic, kHumble, kIron, kJazzy, kKilted };

// The clock for the behaviour of modules and the times of the policy. Deadlines, leases and
// restarts always use the steady clock.
enum class ClockSource {
  kSteady,
  kTopic,  // /clock: the time of a simulated world
};

}  // namespace musher
