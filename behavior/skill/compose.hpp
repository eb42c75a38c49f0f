#pragma once
// Skills that run skills:
//
//   in order          each begins when the one before has completed; the first failure fails it
//   in parallel       all at once; completes with the last; the first failure cancels the others
//                     and fails it
//   first to finish   all at once; the first that completes cancels the others and completes it; it
//                     fails when all have failed
//
//   registry.Add("survey", skill::Compose(skill::Order::kInOrder, registry,
//                                         {{"take_off", {{"altitude", 2.0}}}, {"take_photo"}}));
//
// States: RUNNING → STOPPING, while the others cancel themselves → the end. A cancellation cancels
// every skill inside and ends with the last of them. One that was cancelled by itself counts as a
// failed one. The limits are those of the skills inside: it has none of its own, except in a
// config.
//
// A config file composes them, too: toml/skills_toml.hpp.
//
// A parameter that is not given here is a parameter of the whole, "take_off.altitude"; of a skill
// that is in it several times, "take_off.altitude" for the first and "take_off_2.altitude" for the
// second.

#include <vector>

#include "musher/behavior/skill/registry.hpp"

namespace musher::skill {

// The factory of such a skill, for Registry::Add(), which reports its errors: an unknown skill,
// with the nearest name; none at all; one that would run twice at once, and two at once that use
// the same part of the robot. `registry` is used now only.
Factory Compose(Order order, const Registry& registry, const std::vector<Part>& parts);

}  // namespace musher::skill
