#pragma once
// Reads a course (course.hpp) from a TOML file, and reports every error at once with its line:
// unknown names with a suggestion, counts, and states that get stuck. The head of
// config/race/course.toml explains the keys.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/modules/race/course.hpp"

namespace musher::race {

struct CourseReading {
  std::optional<Course> course;         // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
};

// Never throws; an unreadable file is a diagnostic.
CourseReading ReadCourseFile(const std::string& path);

// The same for a text; `path` is what diagnostics refer to.
CourseReading ReadCourseText(std::string_view text, const std::string& path);

// What the course has, in a few lines.
std::string Summary(const Course& course);

}  // namespace musher::race
