#pragma once
// Ways out for a robot that has no path from where it stands: each is one short motion, polled in
// the steps of a skill. The gate before the base checks them as everything else.
//
//   leave     turns away from what its scan sees nearest, and goes 0.3 m
//   wait      stands for 3 s
//   back_up   0.4 m back
//   spin      once around, for a look at all sides
//
// One that is held by the gate, or makes no progress, ends after a few seconds. Frames and units of
// robot.hpp.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

enum class RecoveryKind : std::uint8_t { kLeave, kWait, kBackUp, kSpin };

class Recovery {
 public:
  // Of "leave, wait, back_up, spin", in any order and number; empty: none.
  static Result<std::vector<RecoveryKind>> Parse(const std::string& text);
  static std::string NameOf(RecoveryKind kind);

  explicit Recovery(Robot& robot) : robot_(robot) {}

  void Begin(RecoveryKind kind);
  // `around`: what the scan sees, in the frame of the body. True: it has ended, and the base
  // stands.
  bool Step(const std::vector<navigation::Point>& around, Duration step);

 private:
  navigation::Velocity Command(const std::vector<navigation::Point>& around) const;

  Robot& robot_;
  RecoveryKind kind_ = RecoveryKind::kWait;
  Duration passed_{};
  Duration held_{};
  std::optional<navigation::Pose> begin_;
  double turned_rad_ = 0;
  double last_yaw_rad_ = 0;
  bool turns_ = true;  // of kLeave: until it looks away
};

}  // namespace musher::skills
