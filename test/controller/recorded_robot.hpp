#pragma once
// What the controllers of a robot recorded in a short life: a start, some switches, a crash of a
// critical actuator, a second controller.

#include <string>
#include <vector>

#include "musher/controller/journal/journal.hpp"

namespace musher {

// The robot's config; `on_lost` is where it goes without its legs.
std::string RobotToml(const std::string& on_lost = "Protected");

std::vector<JournalItem> RecordedLife();

}  // namespace musher
