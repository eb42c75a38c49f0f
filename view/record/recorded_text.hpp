#pragma once
// How much was recorded, for people. Pure; threads: any.

#include <cstdint>
#include <string>

namespace musher::view {

// "12.3 MB in 10.2 s, 1.2 MB/s"; `rate`: bytes per second.
std::string RecordedText(std::uint64_t bytes, double seconds, double rate);

}  // namespace musher::view
