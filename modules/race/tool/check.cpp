// musher-race check COURSE: reports every error of a course with its line, or what it has.

#include <CLI/CLI.hpp>
#include <iostream>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/tool/tool.hpp"

namespace musher::race::tool {

int Check(int argc, const char* const* argv) {
  CLI::App app("Reports every error of a course, or what it has.", "musher-race check");
  app.footer("Exit codes: 0 no errors; 2 errors, or usage.");
  std::string file;
  app.add_option("COURSE", file, "The course (TOML), as config/race/course.toml")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return EndOfParse(app, error, program::kUsageError);
  }
  const CourseReading reading = ReadCourseFile(file);
  program::PrintErrors(reading.diagnostics);
  if (!reading.course) return program::kUsageError;
  std::cout << file << ": " << Summary(*reading.course) << std::endl;
  return 0;
}

}  // namespace musher::race::tool
