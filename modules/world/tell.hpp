#pragma once
// A hand in a running world: `musher-world tell battery 18` and the like, for people and scripts
// without ROS.
//
// Threads: those of the caller; Tell() blocks until it is done or its time is over.

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/modules/world/scene.hpp"

namespace musher::world {

struct Fault {
  std::string text;  // "lifted", "motor 3"
};
struct PowerKey {
  bool down = true;
};
struct Speech {  // of a person beside the robot
  std::string text;
};
struct Pause {
  bool on = true;
};
struct DrawNow {};
using Telling =
    std::variant<ChargeTo, Cable, Touch, PowerKey, Speech, Fault, Carry, Speed, Pause, DrawNow>;

// What can be told, a line each.
extern const char* const kTellings;

// The words after `tell`; an Error says which ones were expected.
Result<Telling> ReadTelling(const std::vector<std::string>& words);

// Tells the world of that namespace. Gives its answer: the picture's file, mostly nothing. An Error
// when there is no world within `timeout`, or when it refuses.
Result<std::string> Tell(const Telling& telling, const std::string& name_space, Duration timeout);

}  // namespace musher::world
