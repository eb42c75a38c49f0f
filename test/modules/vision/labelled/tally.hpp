#pragma once
// Whether a detector has found what a labelled picture shows.
//
// A board, bar, sign or light counts as found when its word is right and the box is over it.
// A detector of lines is evaluated in each of its columns: its edge is found when it is within 3
// pixels or 2 cm of the lowest place of a line in that column, and false when it is farther than 4
// cm from all lines.
// Only lines within 2 m of the body's middle count: the walker uses no others.

#include <vector>

#include "musher/modules/vision/course/course_config.hpp"
#include "musher/test/modules/vision/labelled/labelled_course.hpp"

namespace musher::vision {

// Of pictures; of lines, of columns. What is found at another place is missed, and false.
struct Tally {
  int shown = 0;  // in which the thing is there
  int found = 0;
  int absent = 0;  // in which it is not there
  int false_finds = 0;
  std::vector<double> errors;  // of the distance, a share of it; of lines metres on the ground

  int missed() const { return shown - found; }
  void Add(const Tally& other);
};

Tally TallyOf(const CourseSight& sight, const LabelledPicture& picture);

// One for each range of the distance from the body's middle, see kLineRangesM.
inline constexpr std::array<double, 6> kLineRangesM{0.3, 0.5, 0.7, 1.0, 1.5, 2.0};
using LineTallies = std::array<Tally, kLineRangesM.size() - 1>;
LineTallies TallyOfLines(const msg::YellowLines& lines, const LinesParameters& parameters,
                         const LabelledPicture& picture);

// The tables [[detectors]] of config/vision/course.toml.
std::vector<CourseEntry> ShippedDetectors();
// Of that kind; of lines, the one that the walker has on that camera.
const CourseEntry& DetectorOf(const std::vector<CourseEntry>& entries, CourseKind kind,
                              std::size_t camera);

}  // namespace musher::vision
