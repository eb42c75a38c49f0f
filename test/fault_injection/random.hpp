#pragma once
// A random generator with the same numbers on every machine for the same seed (splitmix64);
// <random> does not guarantee that.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace musher::fault_injection {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t Next() {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t mixed = state_;
    mixed = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9U;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBU;
    return mixed ^ (mixed >> 31U);
  }
  // From `low` to `high`, both included.
  std::int64_t Between(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(Next() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool Bernoulli(int percent) { return Between(1, 100) <= percent; }

  template <class T>
  const T& Pick(const std::vector<T>& from) {
    return from[Next() % from.size()];
  }
  template <class T>
  void Shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[Next() % i]);
  }

 private:
  std::uint64_t state_;
};

}  // namespace musher::fault_injection
