#pragma once
// One side of a ROS 2 bond: two sides exchange heartbeats on a topic, and each detects the loss of
// the other. nav2's manager waits until the bond with a node is formed before it continues with the
// next node. Pure: heartbeats and the time go in, the heartbeats to publish come out.
//
//           Start            a heartbeat of the other side
//   (off) ────────▶ waiting ───────────────────────────────▶ formed
//     ▲                │ Stop           it ends the bond, or │  │ Stop
//     │                ▼                is silent too long   ▼  ▼
//     └──────────── (off) ◀── ended by both, or 2 s ───── broken, ending
//
// The next heartbeat forms a broken bond again: a restarted manager bonds with its node again.
//
// Threads: none; a plain value.

#include <cstdint>
#include <optional>
#include <string>

#include "musher/base/time.hpp"

namespace musher {

// A heartbeat of the other side.
struct BondHeartbeat {
  std::string instance;  // of that side
  bool active = false;   // false: that side ends the bond
  Duration timeout{};    // after this time without a heartbeat the bond is broken
};

class Bond {
 public:
  // Below the shortest timeout of a bond with which nav2 is used.
  static constexpr Duration kPeriod = Milliseconds(100);
  // The timeout that this side publishes.
  static constexpr Duration kTimeout = Milliseconds(4000);

  enum class Phase : std::uint8_t { kOff, kWaiting, kFormed, kBroken, kEnding };

  // Each returns whether to publish a heartbeat now; its `active` field is active().
  bool Start(Time now);
  bool Stop(Time now);
  bool OnHeartbeat(const BondHeartbeat& heartbeat, Time now);
  // A reader was matched, or time has passed.
  bool OnReaders(Time now);
  bool OnTime(Time now);

  Phase phase() const { return phase_; }
  // Whether this side keeps the bond.
  bool active() const { return phase_ == Phase::kWaiting || phase_ == Phase::kFormed; }
  // When to call OnTime() next; nullopt: never.
  std::optional<Time> next() const;

  friend bool operator==(const Bond&, const Bond&) = default;

 private:
  bool Publish(Time now);

  Phase phase_ = Phase::kOff;
  std::string other_;    // instance of the other side, while formed
  Time heartbeat_by_{};  // while formed: broken without a heartbeat until then
  Time ended_by_{};      // while ending: ends then, also without the other side
  Time publish_at_{};    // the next heartbeat of this side
};

}  // namespace musher
