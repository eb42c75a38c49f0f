#pragma once
// Where the course looks at lines, and what is said from beside there: whether a correction leads
// to the place, or away from it.
//
// Frame: that of the scene, metres. Threads: one at a time.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/test/modules/race/drive/course_drive.hpp"

namespace musher::race::testing {

enum class Aside : std::uint8_t { kAhead, kLeft, kTurned };  // how a body is beside its place

struct CheckPlace {
  std::string state;  // of the course
  std::string check;
  world::Pose2 at;
  Aside aside = Aside::kAhead;
};

// Of config/race/course.toml in that hall, in the order of its states.
std::vector<CheckPlace> CheckPlaces(const Hall& hall, const SCurve& s);

enum class Saying : std::uint8_t {
  kRight,   // a correction to the place, or none at it
  kUnsure,  // nothing, or a doubt
  kAway,    // a correction away from the place
  kNone,    // that it is at its place, and it is far beside it
};

// By the picture from so far beside the place: metres, or radians.
Saying SaidFrom(CourseDrive& drive, const CheckPlace& place, double off);

}  // namespace musher::race::testing
