#pragma once
// What a node of a behaviour tree reports.

#include <cstdint>
#include <string_view>

namespace musher::tree {

enum class Status : std::uint8_t {
  kIdle,     // not ticked, or reset since; never the result of a tick
  kRunning,  // needs further ticks
  kSuccess,
  kFailure,
  kSkipped,  // a condition kept it from running; the node itself stays idle
};

constexpr bool IsCompleted(Status status) {
  return status == Status::kSuccess || status == Status::kFailure;
}

std::string_view Name(Status status);  // "SUCCESS", as in XML

}  // namespace musher::tree
