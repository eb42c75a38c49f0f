// musher-race course HALL COURSE: a course for the measures of another hall.

#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>
#include <string>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/modules/race/course_for_hall.hpp"
#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/tool/tool.hpp"

namespace musher::race::tool {
namespace {

struct Files {
  std::string hall;
  std::string course;
  std::string vision;
  std::string walker;
};

// Nothing after a message.
std::optional<std::string> TextOf(const std::string& file) {
  const Result<std::string> text = config_toml::ReadModuleText(file);
  if (text) return text.value();
  program::PrintErrors({Diagnostic{file, 0, 0, Severity::kError, text.error().message}});
  return std::nullopt;
}

int Write(const Files& files) {
  const CourseReading base = ReadCourseFile(files.course);
  program::PrintErrors(base.diagnostics);
  if (!base.course) return program::kUsageError;
  const HallReading hall = ReadHallFile(files.hall, base.course->hall);
  program::PrintErrors(hall.diagnostics);
  if (!hall.hall) return program::kUsageError;
  const std::string& file = !files.vision.empty()   ? files.vision
                            : !files.walker.empty() ? files.walker
                                                    : files.course;
  const auto text = TextOf(file);
  if (!text) return program::kUsageError;
  const AdaptedFile adapted =
      !files.vision.empty()   ? VisionForHall(*hall.hall, base.course->hall, *text)
      : !files.walker.empty() ? WalkerForHall(*hall.hall, *text)
                              : CourseForHall(*hall.hall, *base.course, *text);
  std::cout << adapted.text << std::flush;
  for (const std::string& change : adapted.changes) std::cerr << change << "\n";
  for (const std::string& open : adapted.open) std::cerr << "not derived: " << open << "\n";
  std::cerr << std::flush;
  return adapted.open.empty() ? 0 : 1;
}

}  // namespace

int WriteCourse(int argc, const char* const* argv) {
  CLI::App app("Prints a course for the measures of another hall.", "musher-race course");
  app.footer(
      "Only numbers change. What changes, and what the measures do not give, is on stderr.\n"
      "Exit codes: 0 printed; 1 printed, but something is to be set by hand; 2 errors, or usage.");
  Files files;
  app.add_option("HALL", files.hall, "The measures (TOML): keys of [hall] of a course")->required();
  app.add_option("COURSE", files.course, "The course that is changed, with the [hall] it is for")
      ->required();
  auto* vision = app.add_option("--vision", files.vision,
                                "Prints this config of the vision module instead, changed");
  app.add_option("--walker", files.walker, "Prints this config of the line walker instead, changed")
      ->excludes(vision);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : program::kUsageError;
  }
  return Write(files);
}

}  // namespace musher::race::tool
