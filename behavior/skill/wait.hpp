#pragma once
// The skill that does nothing for a time: a pause in a sequence.
//
//   registry.Add("wait", skill::Wait());      parameter duration_s, 0 or more; default 1
//
// State: WAITING. Progress: the share of the time that has passed.

#include "musher/behavior/skill/registry.hpp"

namespace musher::skill {

Factory Wait();

}  // namespace musher::skill
