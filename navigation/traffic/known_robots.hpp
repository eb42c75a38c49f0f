#pragma once
// What other robots have said of themselves lately.
//
// - A sample is as old as the time since it came: clocks of others need not agree with ours. What
//   is older than `stale` is forgotten.
// - A sample whose stamp is not newer than the last one of its robot is a copy, or late: a bridge
//   sends such. It changes nothing, and keeps nothing alive.
// - What has the own name is an echo of what this robot has said.
//
// Pure; one thread.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/navigation/traffic/right_of_way.hpp"

namespace musher::navigation {

class KnownRobots {
 public:
  static constexpr Duration kStale = std::chrono::seconds(2);
  static constexpr std::size_t kMost = 200;           // robots; of more, the oldest is forgotten
  static constexpr std::size_t kMostPoints = 10'000;  // of a path

  // `own`: the name of this robot; empty: it knows all.
  explicit KnownRobots(std::string own = {}) : own_(std::move(own)) {}

  // `stamp`: of the sample, since the zero of its clock. An error: it cannot be used, and why.
  Result<> Take(RobotIntent intent, Duration stamp, Time now);

  std::vector<RobotIntent> At(Time now) const;
  void Forget() { known_.clear(); }

 private:
  struct Known {
    RobotIntent intent;
    Duration stamp{};
    Time at{};
  };

  const std::string own_;
  std::map<std::string, Known> known_;  // also what is forgotten, for its stamp
};

}  // namespace musher::navigation
