// musher-race: the race course. See README.md in this folder.

#include <string_view>

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/race_robot.hpp"
#include "musher/modules/race/tool/tool.hpp"

namespace {

int Run(const musher::program::Options& options) {
  const musher::race::CourseReading reading = musher::race::ReadCourseFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.course) return musher::program::kUsageError;
  musher::race::RaceRobot robot(options.actuator, *reading.course);
  return musher::program::RunToEnd(robot, options.state_config);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view command = argc > 1 ? argv[1] : "";
  if (command == "check") return musher::race::tool::Check(argc - 1, argv + 1);
  if (command == "course") return musher::race::tool::WriteCourse(argc - 1, argv + 1);
  if (command == "replay") return musher::race::tool::Replay(argc - 1, argv + 1);
  if (command == "send") return musher::race::tool::PublishCommand(argc - 1, argv + 1);
  return musher::program::Main(
      argc, argv,
      {"musher-race", "The race course, as the actuator race.",
       "`musher-race check COURSE` reports the errors of a course, `musher-race course COURSE "
       "--lane 0.9`\n"
       "prints it for the measures of another hall, `musher-race send START` publishes a command "
       "of a running\n"
       "race, "
       "`musher-race replay FILE COURSE` replays a recorded one; see their --help.\n\n"
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or course."},
      Run);
}
