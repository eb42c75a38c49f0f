#pragma once
// The table `parameters` of a detector of a course: ranges are checked, errors are located.

#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/vision/course/course_config.hpp"

namespace musher::vision {

// Reads the parameters of that kind of detector, and returns what makes the detector with them. The
// caller refuses other keys.
CourseDetectorMaker ReadCourseParameters(CourseKind kind, config_toml::TableReader& reader);

}  // namespace musher::vision
