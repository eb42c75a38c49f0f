#pragma once
// musher-vision look --detector: what a detector of a course finds in pictures and films. For
// tuning its parameters.
//
// Each picture file is processed by a detector of its own; a film is processed by one detector,
// picture by picture, as the robot's pictures are.

#include <ostream>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/vision/course/course_config.hpp"
#include "musher/modules/vision/tool/look.hpp"

namespace musher::vision::tool {

// The detector of that name; else an Error that lists the known ones.
Result<CourseEntry> DetectorOf(const VisionConfig& config, const std::string& name);

// Prints the results for each picture. Fails with the first file that cannot be read or written.
Result<> LookAtCourse(const CourseEntry& entry, const LookOptions& options, std::ostream& out);

// The lines that are printed of one picture: its words and numbers.
std::string SightText(const CourseSight& sight);

}  // namespace musher::vision::tool
