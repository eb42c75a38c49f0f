// musher-wedding replay FILE [--config SHOW]: replays a recording and prints the first difference.

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "musher/actuator/program/module_main.hpp"
#include "musher/application/fsm_replay_file.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/modules/wedding/show.hpp"
#include "musher/modules/wedding/tool/tool.hpp"

namespace musher::wedding::tool {
namespace {

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

int Play(const std::string& file, const ShowConfig& config) {
  NoOutputs outputs;
  const auto make = [&](fsm::Machine& machine) -> Result<ReplayedInput> {
    const auto show = std::make_shared<Show>(config, outputs);
    if (const Result<> built = show->Build(machine); !built) return built.error();
    show->Resume({});
    return ReplayedInput(
        [show](std::string_view input, std::string_view text) { return show->Apply(input, text); });
  };
  return static_cast<int>(ReplayFile(file, make, std::cout, std::cerr));
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
    return EndOfParse(app, error, program::kUsageError);
  }
  if (config_file.empty()) return Play(file, {});
  const Parsed<WeddingConfig> reading = ReadWeddingFile(config_file);
  program::PrintErrors(reading.diagnostics);
  return reading.config ? Play(file, reading.config->show) : program::kUsageError;
}

}  // namespace musher::wedding::tool
