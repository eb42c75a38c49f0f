#pragma once
// What the nodes of a program do with the robot: they start a call, look at each tick whether it
// has ended, and forget it when they are halted. Nothing blocks.
//
// Threads: the loop.

#include <cstdint>
#include <optional>
#include <string>

#include "musher/base/result.hpp"

namespace musher::vp_engine {

struct MotionOrder {
  std::int32_t id = 0;           // of the motion table
  std::int32_t duration_ms = 0;  // 0: the motion has its own
  float forwards_mps = 0;
  float left_mps = 0;
  float turn_radps = 0;  // left positive
};

struct LightOrder {
  std::uint8_t target = 1;  // 1 head, 2 tail, 3 mini
  std::uint8_t effect = 1;  // of the user's colour
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  bool on = true;  // false: the light is released
};

class Robot {
 public:
  using Call = std::uint64_t;

  virtual ~Robot() = default;

  // Each ends when the robot has done it, or with the reason why it has not.
  virtual Call Speak(const std::string& text) = 0;
  virtual Call Move(const MotionOrder& order) = 0;
  virtual Call Light(const LightOrder& order) = 0;

  // Nothing: it goes on.
  virtual std::optional<Result<>> EndOf(Call call) = 0;
  // The end of that call is of no interest any more. What the robot does goes on to its end.
  virtual void Forget(Call call) = 0;
};

}  // namespace musher::vp_engine
