#pragma once
// The files of a race for a hall with other measures: only their numbers change. Pure.
//
// A count changes by what its way is longer or shorter than in the base's hall, in whole steps of
// the robot: 0.2 s at the speed of the movement, as odometry shows it (Movement::odometry_share).
// What is tuned in the base stays so, and the base for its own hall is the base itself.
//
// Threads: any.

#include <string>
#include <string_view>
#include <vector>

#include "musher/modules/race/course.hpp"
#include "musher/modules/race/hall.hpp"

namespace musher::race {

struct AdaptedFile {
  std::string text;
  std::vector<std::string> changes;  // "state.QRA_TO_A1: forward 23 -> 25 (0.17 m more)"
  std::vector<std::string> open;     // what the measures do not give, and a person has to set
};

// `text` is that of `base`.
AdaptedFile CourseForHall(const Hall& hall, const Course& base, std::string_view text);

// The config of the vision module, as config/vision/course.toml: the lane's width, and where a line
// beside or ahead has to be seen. `base` is the hall that the text is for.
AdaptedFile VisionForHall(const Hall& hall, const Hall& base, std::string_view text);

// The config of the line walker.
AdaptedFile WalkerForHall(const Hall& hall, std::string_view text);

}  // namespace musher::race
