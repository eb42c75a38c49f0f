// musher-race replay FILE COURSE: replays a recording and prints the first difference.

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "musher/actuator/program/module_main.hpp"
#include "musher/application/fsm_replay_file.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/race.hpp"
#include "musher/modules/race/tool/tool.hpp"

namespace musher::race::tool {
namespace {

// There is no robot: outputs are ignored.
class NoOutputs : public RaceOutputs {
 public:
  void Walk(const ServoFrame& /*frame*/) override {}
  void Move(std::int32_t /*motion_id*/, std::uint64_t /*number*/) override {}
  void CommandWalker(const LaneWalk& /*walk*/, bool /*start*/) override {}
  void Watch(const std::vector<bool>& /*detectors*/) override {}
  void Speak(const std::string& /*text*/, std::uint64_t /*number*/) override {}
  void ShowState(int /*number*/) override {}
  void Log(const std::string& line) override { std::cerr << "musher-race: " << line << "\n"; }
};

ReplayExit Play(const std::string& file, const Course& course) {
  NoOutputs outputs;
  const auto make = [&](fsm::Machine& machine) -> Result<ReplayedInput> {
    const auto race = std::make_shared<Race>(course, outputs);
    if (const Result<> built = race->Build(machine); !built) return built.error();
    race->Resume({});
    return ReplayedInput(
        [race](std::string_view input, std::string_view text) { return race->Apply(input, text); });
  };
  return ReplayFile(file, make, std::cout, std::cerr);
}

}  // namespace

int Replay(int argc, const char* const* argv) {
  CLI::App app("Replays a recording of a race, without a robot and as fast as possible.",
               "musher-race replay");
  app.footer("Exit codes: 0 identical; 1 different; 2 usage, or no recording.");
  std::string file;
  std::string course_file;
  app.add_option("FILE", file, "The recording, from robot.record of the course")->required();
  app.add_option("COURSE", course_file, "The course that it was recorded with")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return EndOfParse(app, error, program::kUsageError);
  }
  const CourseReading reading = ReadCourseFile(course_file);
  program::PrintErrors(reading.diagnostics);
  if (!reading.course) return program::kUsageError;
  return static_cast<int>(Play(file, *reading.course));
}

}  // namespace musher::race::tool
