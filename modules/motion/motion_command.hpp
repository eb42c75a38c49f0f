#pragma once
// What is requested of the body, what is sent to it and what it reports: plain values. And the
// rules that check a request by itself, whatever the body does at the moment.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/modules/motion/motion_table.hpp"

namespace musher::motion {

// As they come over the wire, not checked yet. Units: m/s, rad/s, rad, m, ms.
struct MotionArguments {
  std::vector<float> vel_des;
  std::vector<float> rpy_des;
  std::vector<float> pos_des;
  std::vector<float> acc_des;
  std::vector<float> ctrl_point;
  std::vector<float> foot_pose;
  std::vector<float> step_height;
  std::int32_t value = 0;
  std::int32_t contact = 0;
  std::int32_t duration_ms = 0;

  friend bool operator==(const MotionArguments&, const MotionArguments&) = default;
};

struct MotionRequest {
  std::int32_t id = 0;
  MotionArguments arguments;

  friend bool operator==(const MotionRequest&, const MotionRequest&) = default;
};

// One frame for the board.
struct BodyCommand {
  std::int32_t id = 0;  // of the table, for messages; the board uses mode and gait
  std::int8_t mode = 0;
  std::int8_t gait = 0;
  std::int8_t contact = 0;
  std::int8_t life_count = 0;  // differs for each new command; the board echoes it
  std::array<float, 3> vel{};
  std::array<float, 3> rpy{};
  std::array<float, 3> pos{};
  std::array<float, 6> acc{};
  std::array<float, 3> ctrl_point{};
  std::array<float, 6> foot_pose{};
  std::array<float, 2> step_height{};
  std::int32_t value = 0;
  std::int32_t duration_ms = 0;

  friend bool operator==(const BodyCommand&, const BodyCommand&) = default;
};

struct BodyReport {
  std::int8_t mode = 0;
  std::int8_t gait = 0;
  std::int8_t contact = 0;
  std::int8_t bar = 0;  // % of the motion done
  std::int8_t switch_status = 0;
  std::int8_t ori_error = 0;
  std::int16_t footpos_error = 0;
  std::array<std::int32_t, 12> motor_error{};
  std::array<float, 12> motor_temperature{};  // degrees Celsius
  std::int8_t life_count = 0;                 // of the last command taken
  // The motion before that command had its mode and gait, and may be the reported one.
  bool ambiguous = false;
  // By another program, directly: whatever its mode, the board ignores commands and stops.
  bool motors_taken = false;

  friend bool operator==(const BodyReport&, const BodyReport&) = default;
};

// Whether all values are finite: no NaN, no infinity.
bool AllFinite(const MotionArguments& arguments);

// The first array that is neither empty nor of its length, "vel_des has 2 values instead of 3";
// nothing when all are right.
std::optional<std::string> WrongLength(const MotionArguments& arguments);

// Why the duration is wrong, or the contact flags (0 to 15); nothing when they are right.
std::optional<std::string> WrongDuration(const Motion& motion, std::int32_t duration_ms);
std::optional<std::string> WrongContact(std::int32_t contact);

// The frame for a request. An array of a wrong length becomes zeros; a missing step height becomes
// 5 cm, contact 0 all four feet. Speeds are limited to those of the motion, angles, heights of the
// body and of a step to what a board takes. In a gait of a user these numbers have another meaning.
BodyCommand MakeCommand(const Motion& motion, const MotionArguments& arguments);
// The arrays of which MakeCommand() limits a number, "vel_des, step_height"; "": none.
std::string LimitedArrays(const Motion& motion, const MotionArguments& arguments);

// How long the motion may take from the end of the transition.
Duration ExecutionTime(const Motion& motion, std::int32_t duration_ms);

}  // namespace musher::motion
