// musher-wedding replay FILE [--config SHOW]: replays a recording and prints the first difference.

#include "musher/behavior/fsm/replay.hpp"

#include <CLI/CLI.hpp>
#include <iomanip>
#include <iostream>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/modules/wedding/show.hpp"
#include "musher/modules/wedding/tool/tool.hpp"

namespace musher::wedding::tool {
namespace {

enum Exit : int { kSame = 0, kOther = 1, kUsage = 2 };

// Recordings are larger than configs: an hour has some 10 MiB.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

// There is no robot: outputs are ignored.
class NoOutputs : public ShowOutputs {
 public:
  void TakePose(std::string_view /*pose*/) override {}
  void LookAt(Gaze /*gaze*/) override {}
  void Play(std::string_view /*sound*/) override {}
  void TakePhoto() override {}
  void RecordVideo(bool /*on*/) override {}
  void SetMotion(std::string_view /*motion*/) override {}
  void ShowState(std::string_view /*state*/) override {}
  void Log(const std::string& line) override { std::cerr << "musher-wedding: " << line << "\n"; }
};

class Printer : public fsm::Listener {
 public:
  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override {
    const auto name = [&](fsm::StateId id) { return machine.Name(id); };
    const std::chrono::duration<double> at = change.at;
    std::cout << std::fixed << std::setprecision(3) << std::setw(10) << at.count() << " s  "
              << (change.from == fsm::kNoState ? "-" : name(change.from)) << " -> "
              << (change.to == fsm::kNoState ? "-" : name(change.to)) << "  "
              << fsm::Name(change.cause);
    if (change.command != fsm::kNoEvent) std::cout << " by " << machine.Name(change.command);
    std::cout << "\n";
  }
};

int Fail(const std::string& message) {
  std::cerr << message << std::endl;
  return kUsage;
}

int Play(const std::string& file, const ShowConfig& config) {
  const Result<std::string> text = config_toml::ReadTextFile(file, kMostBytes);
  if (!text) return Fail(file + ": error: " + text.error().message);
  const Result<fsm::Recording> recording = fsm::ReadRecording(text.value(), file);
  if (!recording) return Fail(recording.error().message);
  NoOutputs outputs;
  fsm::Machine machine({.name = recording.value().machine});
  Show show(config, outputs);
  if (const Result<> built = show.Build(machine); !built) return Fail(built.error().message);
  Printer printer;
  machine.Listen(&printer);
  show.Resume({});
  const Result<fsm::Replayed> replayed = fsm::Replay(
      recording.value(), machine,
      [&](std::string_view input, std::string_view words) { return show.Apply(input, words); });
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
  CLI::App app("Replays a recording of the show, without a robot and as fast as possible.",
               "musher-wedding replay");
  app.footer("Exit codes: 0 identical; 1 different; 2 usage, or no recording.");
  std::string file;
  std::string config_file;
  app.add_option("FILE", file, "The recording, from [record] file of the show's config")
      ->required();
  app.add_option("--config", config_file,
                 "The show's config that it was recorded with; default that of an empty file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSame : kUsage;
  }
  if (config_file.empty()) return Play(file, {});
  const WeddingReading reading = ReadWeddingFile(config_file);
  program::PrintErrors(reading.diagnostics);
  return reading.config ? Play(file, reading.config->show) : kUsage;
}

}  // namespace musher::wedding::tool
