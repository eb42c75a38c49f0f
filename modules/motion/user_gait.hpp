#pragma once
// Gaits of users: the contacts of the feet, section by section, and the steps of the body. A motion
// board that takes them (MotionBackend::TakesGaits) gets both as texts, and executes them as a
// motion with gait 110.
//
// Pure functions; nothing here is trusted: a gait that is not complete, too long or not finite is
// an error, which names the section or step.
//
// Threads: any.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/protocol/motion_sequence.hpp"
#include "musher/modules/motion/motion_table.hpp"

namespace musher::motion {

inline constexpr std::size_t kLongestGaitText = 60'000;  // bytes of one text: it is one datagram

struct UserGait {
  std::string sections;          // TOML, begins with "# Gait Def"
  std::string steps;             // TOML, begins with "# Gait Params"
  std::int64_t duration_ms = 0;  // of all steps
  SpeedLimit fastest{};          // that a step has, in each direction

  friend bool operator==(const UserGait&, const UserGait&) = default;
};

// Whether motion executes the gait of a user.
bool PlaysUserGait(const Motion& motion);

// Why it does not fit the motion that plays it: too fast, or too long.
Result<> CheckGait(const Motion& motion, const UserGait& gait);

// Of two TOML texts: [[section]] with `contact` (four times 0 or 1: front right, front left, rear
// right, rear left) and `duration`; [[step]] as README.md lists its keys, or with the fields of a
// command, as a board takes it.
Result<UserGait> ReadUserGait(const std::string& sections, const std::string& steps);

// Whether the sequence needs a board that takes gaits: it has feet, or paces that do more than
// walk.
bool HasUserGait(const msg::MotionSequenceShow::Request& sequence);
// Feet and paces each as texts, or as a list if there are none.
Result<UserGait> UserGaitOf(const msg::MotionSequenceShow::Request& sequence);

// rad/s: angular z, or linear z as CyberDog's own programs have it.
double YawRateOf(const msg::Twist& twist);
// Whether the pace only walks, by speed and duration.
bool IsWalk(const msg::MotionSequencePace& pace);

}  // namespace musher::motion
