#pragma once
// The keys of a state config, as docs/reference.md explains them: its rows are compiled into the
// program. Pure; threads: any.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::cli {

struct KeyReference {
  std::string table;  // "[policy.battery]", "[actuator.<name>]"
  std::string key;    // "topic"; empty: of the table itself
  std::string type;
  std::string otherwise;  // its default
  std::string meaning;
};

// In the order of the reference.
const std::vector<KeyReference>& AllKeys();

// Those that a person means by "topic", "policy.battery.topic", "[policy.battery] topic",
// "actuator.audio.restart" or "policy.battery" (the whole table). The Error suggests what was
// meant.
Result<std::vector<KeyReference>> FindKeys(std::string_view words);

}  // namespace musher::cli
