#pragma once
// The number of samples that the readers of this process have lost: overwritten, or dropped by the
// network, before they could be taken. For diagnostics only; no decision depends on it.
//
// Threads: any.

#include <atomic>
#include <cstdint>

namespace musher::transport {

namespace internal {
inline std::atomic<std::uint64_t> lost_samples = 0;
}  // namespace internal

inline void CountLostSamples(std::uint64_t count) {
  internal::lost_samples.fetch_add(count, std::memory_order_relaxed);
}
inline std::uint64_t LostSamples() {
  return internal::lost_samples.load(std::memory_order_relaxed);
}

}  // namespace musher::transport
