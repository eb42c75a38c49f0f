#pragma once
// Which of its parts an actuator's fault is about, for those that stand for several. Pure.
//
// CyberDog's modules add the codes of their parts up; ours give that of the worst and name all in
// the message. Both are understood.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "musher/lifecycle/result.hpp"

namespace musher::cyberdog {

struct Part {
  std::string_view name;
  std::int32_t code = 0;  // when its self-check fails
  bool own_key = true;    // in the description of `self_check_status`
};

// Empty for an actuator that is one thing.
std::span<const Part> PartsOf(std::string_view actuator);

// The codes of the parts that failed, in their order; a code that is of none of them is alone.
std::vector<std::int32_t> FailedCodes(std::span<const Part> parts, const Error& fault);

}  // namespace musher::cyberdog
