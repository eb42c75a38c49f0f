#pragma once
// What the kernel reports of a process that is being started, for the reason why it is late.

#include <array>
#include <string_view>

#include "musher/lifecycle/field.hpp"

namespace musher {

// How far a process has come that has not announced itself as the actuator that it was started for.
enum class StartProgress {
  kUnknown,
  kNamed,  // it holds the name of the actuator: it is its module
  kBusy,   // it runs, or waits for the disk
  kIdle,   // it sleeps
};

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 4> kValueNames<StartProgress> = {"unknown", "named",
                                                                               "busy", "idle"};
static_assert(EndsWith(StartProgress::kIdle));

}  // namespace musher::fields
