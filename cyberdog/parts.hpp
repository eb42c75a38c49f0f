#pragma once
// The failed parts in an actuator's fault, for actuators that consist of several parts. Pure.
//
// CyberDog's modules report the sum of their parts' codes; Musher's report the worst code and list
// all in the message. Both are supported.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::cyberdog {

struct Part {
  std::string_view name;
  std::int32_t code = 0;  // when its self-check fails
  bool own_key = true;    // in the description of `self_check_status`
};

// Empty for an actuator without parts.
std::span<const Part> PartsOf(std::string_view actuator);

// The codes of the failed parts, in their order; a code of no part is returned alone.
std::vector<std::int32_t> FailedCodes(std::span<const Part> parts, const Error& fault);

}  // namespace musher::cyberdog
