// musher-race replay FILE COURSE: replays a recording and prints the first difference.

#include "musher/behavior/fsm/replay.hpp"

#include <CLI/CLI.hpp>
#include <iomanip>
#include <iostream>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/race.hpp"
#include "musher/modules/race/tool/tool.hpp"

namespace musher::race::tool {
namespace {

enum Exit : int { kSame = 0, kOther = 1, kUsage = 2 };

// Recordings are larger than configs: an hour has some 30 MiB.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

// There is no robot: outputs are ignored.
class NoOutputs : public RaceOutputs {
 public:
  void Walk(const ServoFrame& /*frame*/) override {}
  void Move(std::int32_t /*motion_id*/, std::uint64_t /*number*/) override {}
  void CommandWalker(const LaneWalk& /*walk*/, bool /*start*/) override {}
  void Watch(const std::vector<bool>& /*detectors*/) override {}
  void Say(const std::string& /*text*/, std::uint64_t /*number*/) override {}
  void ShowState(int /*number*/) override {}
  void Log(const std::string& line) override { std::cerr << "musher-race: " << line << "\n"; }
};

class Printer : public fsm::Listener {
 public:
  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override {
    const auto name = [&](fsm::StateId id) {
      return id == fsm::kNoState ? std::string_view("-") : machine.Name(id);
    };
    const std::chrono::duration<double> at = change.at;
    std::cout << std::fixed << std::setprecision(3) << std::setw(10) << at.count() << " s  "
              << name(change.from) << " -> " << name(change.to) << "  " << fsm::Name(change.cause);
    if (change.command != fsm::kNoEvent) std::cout << " by " << machine.Name(change.command);
    std::cout << "\n";
  }
};

int Fail(const std::string& message) {
  std::cerr << message << std::endl;
  return kUsage;
}

int Play(const std::string& file, const Course& course) {
  const Result<std::string> text = config_toml::ReadTextFile(file, kMostBytes);
  if (!text) return Fail(file + ": error: " + text.error().message);
  const Result<fsm::Recording> recording = fsm::ReadRecording(text.value(), file);
  if (!recording) return Fail(recording.error().message);
  NoOutputs outputs;
  fsm::Machine machine({.name = recording.value().machine});
  Race race(course, outputs);
  if (const Result<> built = race.Build(machine); !built) return Fail(built.error().message);
  Printer printer;
  machine.Listen(&printer);
  race.Resume({});
  const Result<fsm::Replayed> replayed = fsm::Replay(
      recording.value(), machine,
      [&](std::string_view input, std::string_view words) { return race.Apply(input, words); });
  machine.Forget(&printer);
  if (!replayed) return Fail(replayed.error().message);
  std::cout << replayed.value().ticks << " ticks, " << replayed.value().changes << " changes: ";
  if (!replayed.value().difference) {
    std::cout << "identical" << std::endl;
    return kSame;
  }
  std::cout << "different\n" << *replayed.value().difference << std::endl;
  return kOther;
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
    return app.exit(error) == 0 ? kSame : kUsage;
  }
  const CourseReading reading = ReadCourseFile(course_file);
  program::PrintErrors(reading.diagnostics);
  return reading.course ? Play(file, *reading.course) : kUsage;
}

}  // namespace musher::race::tool
