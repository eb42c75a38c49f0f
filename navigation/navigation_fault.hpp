#pragma once
// Why a navigation is refused or ends without arrival: module Navigation (5300) and own keys from
// 21 on. The message of the error has the place and what was expected.

#include <string>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"

namespace musher::navigation {

enum class Fault : std::int32_t {
  kInput = 5310,         // a number that is not finite, a parameter out of range
  kMap = 5321,           // no map, or one that cannot be used
  kStartBlocked = 5322,  // the body does not fit where it is
  kGoalBlocked = 5323,   // the body does not fit at the goal
  kOutside = 5324,       // start or goal are not on the map
  kWalledIn = 5325,      // no path from start to goal for a body of this radius
  kTimeLimit = 5326,     // the search was stopped before its end
  kLate = 5327,          // the body did not arrive in time
  kObstacle = 5328,      // an obstacle stayed in the way
  kFrame = 5329,         // a pose or map in another frame than the map's
  kOdometry = 5330,      // no recent odometry
  kScan = 5331,          // no recent scan
  kIdentifier = 5332,    // a planner or controller that the server does not have
  kGoalOutside = 5333,   // the goal is not on the map, or above the ceiling
  kJump = 5334,          // the pose has jumped farther than the body can have moved
  kStuck = 5335,         // the body is commanded and does not move
  kPushed = 5336,        // the body moves without a command
};

inline Error MakeError(Fault fault, std::string message) {
  return {static_cast<std::int32_t>(fault), std::move(message)};
}

inline bool Is(const Error& error, Fault fault) {
  return error.code == static_cast<std::int32_t>(fault);
}

}  // namespace musher::navigation
