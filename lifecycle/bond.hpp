#pragma once
// One side of a ROS 2 bond: two sides exchange heartbeats on a topic and each notices when the
// other one is gone. nav2's manager waits until the bond with a node is formed before it touches
// the next node. Pure: heartbeats and the time go in, what to publish comes out.
//
//           Start            a heartbeat of the other side
//   (off) ────────▶ waiting ───────────────────────────────▶ formed
//     ▲                │ Stop           it ends the bond, or │  │ Stop
//     │                ▼                is silent too long   ▼  ▼
//     └──────────── (off) ◀── ended by both, or 2 s ───── broken, ending
//
// A broken bond is formed again by the next heartbeat: a manager that was restarted finds its node.
//
// Threads: none; a plain value.

#include <cstdint>
#include <optional>
#include <string>

#include "musher/lifecycle/time.hpp"

namespace musher {

// A heartbeat of the other side.
struct BondHeartbeat {
  std::string instance;  // of that side
  bool active = false;   // false: it ends the bond
  Duration timeout{};    // without a heartbeat for so long, the bond is broken
};

class Bond {
 public:
  // Often enough for the shortest timeout that nav2 is used with.
  static constexpr Duration kPeriod = Milliseconds(100);
  // What this side tells of itself.
  static constexpr Duration kTimeout = Milliseconds(4000);

  enum class Phase : std::uint8_t { kOff, kWaiting, kFormed, kBroken, kEnding };

  // Each says whether to publish a heartbeat now; active() is what it carries.
  bool Start(Time now);
  bool Stop(Time now);
  bool OnHeartbeat(const BondHeartbeat& heartbeat, Time now);
  // The other side may have come, or time has passed.
  bool OnReaders(Time now);
  bool OnTime(Time now);

  Phase phase() const { return phase_; }
  // Whether this side keeps the bond.
  bool active() const { return phase_ == Phase::kWaiting || phase_ == Phase::kFormed; }
  // When to call OnTime() next; nothing: never.
  std::optional<Time> next() const;

  friend bool operator==(const Bond&, const Bond&) = default;

 private:
  bool Publish(Time now);

  Phase phase_ = Phase::kOff;
  std::string other_;    // instance of the other side, while formed
  Time heartbeat_by_{};  // while formed: broken without a heartbeat until then
  Time ended_by_{};      // while ending: over then, whatever the other side says
  Time publish_at_{};    // the next heartbeat of this side
};

}  // namespace musher
