#pragma once
// The sources of motion commands, as the wire numbers them.

#include <cstdint>
#include <map>
#include <string>

#include "musher/messages/protocol/motion.hpp"

namespace musher::motion {

inline constexpr std::int32_t kFromMachine = msg::MotionSource::kFsm;  // our own state callbacks
inline constexpr std::int32_t kFromDebug = msg::MotionSource::kDebug;  // a keyboard
inline constexpr std::int32_t kFromApp = msg::MotionSource::kApp;
inline constexpr std::int32_t kFromAudio = msg::MotionSource::kAudio;
inline constexpr std::int32_t kFromVision = msg::MotionSource::kVis;
inline constexpr std::int32_t kFromBluetooth = msg::MotionSource::kBluTele;
inline constexpr std::int32_t kFromAlgorithm = msg::MotionSource::kAlgo;

// A source may take control of the body from another one with an equal or a larger number.
using Priorities = std::map<std::int32_t, std::int32_t>;

inline Priorities DefaultPriorities() {
  return {{kFromDebug, -1}, {kFromApp, 0},       {kFromAudio, 1},
          {kFromVision, 2}, {kFromBluetooth, 3}, {kFromAlgorithm, 4}};
}

// "App"; "source 7" for an unknown one.
std::string SourceName(std::int32_t source);

}  // namespace musher::motion
