#pragma once
// The charge of the battery by which functions are permitted, from the samples of all its
// publishers: the lowest publisher counts. A lower charge counts at once, a higher one only when
// kConfirmingSamples samples in a row report it, over some time: a sensor that is wrong once
// permits nothing. The first sample counts at once. The ceiling of the machine has the same rule
// (policy/policy.hpp).
//
// Pure: time is an argument.

#include <cstdint>
#include <map>
#include <optional>

#include "musher/base/time.hpp"

namespace musher {

class BatteryReading {
 public:
  // `raise_after`: as in BatteryPolicy. A publisher that is silent for `silent` counts no longer.
  BatteryReading(Duration raise_after, Duration silent)
      : raise_after_(raise_after), silent_(silent) {}

  // A sample of a publisher. Returns the charge that counts.
  int Take(std::uint64_t publisher, int percent, Time now);
  // Nothing is known any more.
  void Forget();

 private:
  struct Publisher {
    int percent = 0;
    Time at{};
  };
  // Samples in a row above the charge that counts.
  struct Rise {
    int lowest = 0;  // that one of them has reported
    Time since{};
    int samples = 0;
  };

  const Duration raise_after_;
  const Duration silent_;
  std::map<std::uint64_t, Publisher> publishers_;
  std::optional<int> percent_;
  std::optional<Rise> rise_;
};

}  // namespace musher
