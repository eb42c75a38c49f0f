#pragma once
// Validation, timing and conversion of readings. Plain values, no IO.

#include <array>
#include <chrono>
#include <optional>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/messages/protocol/sensor.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/nav_sat_fix.hpp"

namespace musher::sensor {

// Each fails with what is impossible in the reading. Infinite distances are valid: nothing is
// near, or something is too near (REP 117).
Result<> Validate(const msg::LaserScan& scan);
Result<> Validate(const msg::Range& range);
Result<> Validate(const msg::SingleTofPayload& tof, std::uint8_t position);
Result<> Validate(const msg::NavSatFix& fix);

// Whether the stamps of one source are plausible: near to the present time, and never backwards.
class StampChecker {
 public:
  // How far a stamp may be off, either way; zero: any amount.
  explicit StampChecker(Duration tolerance) : tolerance_(tolerance) {}

  Result<> Take(std::chrono::nanoseconds stamp, std::chrono::nanoseconds now);
  // Time has jumped.
  void Forget() { last_.reset(); }

 private:
  Duration tolerance_;
  std::optional<std::chrono::nanoseconds> last_;
};

// Limits the rate of readings, by their stamps, without drifting from it.
class RateLimit {
 public:
  explicit RateLimit(Duration period) : period_(period) {}  // zero: no limit

  bool Take(std::chrono::nanoseconds stamp);
  void Forget() { due_.reset(); }

 private:
  Duration period_;
  std::optional<std::chrono::nanoseconds> due_;
};

// Two ToF sensors that are published in one message.
class TofPair {
 public:
  using Both = std::array<msg::SingleTofPayload, 2>;  // left, right

  // `left`: the tof_position of the left one; the right one has the next.
  explicit TofPair(std::uint8_t left) : left_(left) {}

  // Returns both when both have a new reading. One without a new reading when the other has its
  // next is published as not available.
  std::optional<Both> Take(msg::SingleTofPayload reading);
  void Forget() { new_ = {}; }

 private:
  Both TakeBoth();

  std::uint8_t left_;
  std::array<std::optional<msg::SingleTofPayload>, 2> new_;
};

// The satellites are not in a NavSatFix: num_sv stays 0.
msg::GpsPayload ToGpsPayload(const msg::NavSatFix& fix);

}  // namespace musher::sensor
