#pragma once
// Who commands a motion, as the wire numbers them.

#include <cstdint>
#include <map>
#include <string>

namespace musher::motion {

inline constexpr std::int32_t kFromMachine = -2;  // FSM: the motion manager's own state callbacks
inline constexpr std::int32_t kFromDebug = -1;    // a keyboard
inline constexpr std::int32_t kFromApp = 0;
inline constexpr std::int32_t kFromAudio = 1;
inline constexpr std::int32_t kFromVision = 2;
inline constexpr std::int32_t kFromBluetooth = 3;
inline constexpr std::int32_t kFromAlgorithm = 4;

// Whoever has the smaller number, or the same one, may take the body from another.
using Priorities = std::map<std::int32_t, std::int32_t>;

inline Priorities DefaultPriorities() {
  return {{kFromDebug, -1}, {kFromApp, 0},       {kFromAudio, 1},
          {kFromVision, 2}, {kFromBluetooth, 3}, {kFromAlgorithm, 4}};
}

// "App"; "source 7" for one that nobody knows.
std::string SourceName(std::int32_t source);

}  // namespace musher::motion
