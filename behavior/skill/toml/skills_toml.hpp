#pragma once
// Which skills a kind of robot has, and their limits, as a TOML text:
//
//   [group.drone]
//   robots = ["cf2x", "drone_autel"]     # kinds of robots; without the key: all
//   skills = ["take_off", "wait"]
//
//   [skill.take_off]
//   time_limit_ms = 40000                # of a run; 0: none
//   cancel_limit_ms = 5000               # of its own cancellation; 0: none
//   retries = 3                          # of a run, 0 to 1000
//   state_limits_ms = { EXECUTING = 30000 }      # 0: none
//   parameters = { altitude = 2.0 }              # defaults
//
//   [skill.survey]                       # a composition, with all keys of a skill
//   in_order = [{ skill = "take_off", altitude = 2.0 }, { skill = "photos" }]
//   [skill.photos]
//   parallel = [{ skill = "hover" }, { skill = "take_photo", save_path = "a.png" }]
//
// A composition has one of the keys in_order, parallel and first_to_finish (see compose.hpp), each
// with a table for every skill: its name, and the parameters that are given. The others are
// parameters of the whole ("photos.hover.duration"). A skill that runs itself is refused, and one
// that is composed of more than 256 skills.
//
// All keys are optional; what is not there is as the skill declares it. All errors are reported at
// once, as "file:line:column: error: …", an unknown name with the nearest one.

#include <string>
#include <string_view>

#include "musher/base/toml/parsed.hpp"
#include "musher/behavior/skill/registry.hpp"

namespace musher::skill {

// `registry` has the skills, states and parameters that may be named.
Parsed<Config> ReadConfig(std::string_view text, const std::string& file, const Registry& registry);
Parsed<Config> ReadConfigFile(const std::string& path, const Registry& registry);

}  // namespace musher::skill
