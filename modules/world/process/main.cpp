// musher-world: a simulated robot and the place it is in. See ../README.md.

#include <CLI/CLI.hpp>
#include <cstdint>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/base/version.hpp"
#include "musher/modules/world/process/world_actuator.hpp"
#include "musher/modules/world/process/world_alone.hpp"
#include "musher/modules/world/process/world_control.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"

namespace {

using musher::program::kUsageError;

struct Options {
  std::string scene;
  std::string actuator;
  std::string state_config;
  bool alone = false;
  std::string name_space;
  std::string picture;
  std::vector<std::string> shot;  // a camera, a picture
  double seconds = 0;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> choose;  // NAME=VALUE
};

std::optional<musher::world::SceneRun> RunOf(const Options& options) {
  musher::world::SceneRun run;
  run.seed = options.seed;
  for (const std::string& choice : options.choose) {
    const std::size_t at = choice.find('=');
    if (at == std::string::npos || at == 0) {
      std::cerr << "musher-world: expected --choose NAME=VALUE, found \"" << choice << "\""
                << std::endl;
      return std::nullopt;
    }
    run.chosen[choice.substr(0, at)] = choice.substr(at + 1);
  }
  return run;
}

int Run(const Options& options) {
  const auto run = RunOf(options);
  if (!run) return kUsageError;
  const musher::world::SceneReading reading = musher::world::ReadSceneFile(options.scene, *run);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.scene) return kUsageError;
  const auto time = musher::FromSeconds(options.seconds);
  if (!options.picture.empty()) {
    return musher::world::DrawScene(*reading.scene, time, options.picture);
  }
  if (!options.shot.empty()) {
    return musher::world::ShootScene(*reading.scene, time, options.shot[0], options.shot[1]);
  }
  if (options.alone) return musher::world::RunAlone(*reading.scene, options.name_space);
  if (options.actuator.empty() || options.state_config.empty()) {
    std::cerr << "musher-world: expected --alone, --draw, --shot, or --actuator and --config"
              << std::endl;
    return kUsageError;
  }
  musher::world::WorldActuator world(options.actuator, *reading.scene);
  return musher::program::RunToEnd(world, options.state_config);
}

// musher-world send WORDS...
int WorldControlMain(int argc, char** argv) {
  CLI::App app("Controls a running world from the command line.", "musher-world send");
  app.footer(std::string("Commands:\n") + musher::world::kWorldCommands +
             "\n\nExit codes: 0 done; 1 no world, or it refused; 2 usage.");
  std::vector<std::string> words;
  std::string name_space;
  bool json = false;
  double timeout_s = 5;
  constexpr double kLongestS = 3600;
  app.add_option("WORDS", words, "What, see below")->required()->type_name("");
  app.add_option("--namespace", name_space, "Of the topics")->envname("MUSHER_NAMESPACE");
  app.add_flag("--json", json, "With referee and robots: the report as JSON");
  app.add_option("--timeout", timeout_s, "How long to look for the world, in s; default 5")
      ->check(CLI::Range(0.1, kLongestS).description(""));
  app.allow_extras(false);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return musher::EndOfParse(app, error, kUsageError);
  }
  if (json) words.emplace_back("--json");
  const auto command = musher::world::ParseWorldCommand(words);
  if (!command) {
    std::cerr << "musher-world: " << command.error().message << std::endl;
    return kUsageError;
  }
  const auto timeout = musher::FromSeconds(timeout_s);
  const auto answer = musher::world::SendWorldCommand(command.value(), name_space, timeout);
  if (!answer) {
    std::cerr << "musher-world: " << answer.error().message << std::endl;
    return 1;
  }
  if (!answer.value().empty()) std::cout << answer.value() << std::endl;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && argv[1] == std::string_view("send")) return WorldControlMain(argc - 1, argv + 1);
  Options options;
  CLI::App app("A simulated robot and the place it is in, as the actuator world or alone.",
               "musher-world");
  app.footer(
      "`musher-world send` controls a running world, see its --help.\n\n"
      "Exit codes: 0 torn down, ended by a signal, or drawn; 1 not started or not drawn\n"
      "(reason on stderr); 2 usage or config.");
  app.set_version_flag("--version", "musher-world " + std::string(musher::Version()),
                       "Print the version");
  constexpr double kLongestS = 100'000;
  app.add_option("SCENE", options.scene, "The scene (TOML)")->required();
  app.add_option("--actuator", options.actuator, "Which actuator of the state config this is")
      ->envname("MUSHER_ACTUATOR");
  app.add_option("--config", options.state_config, "The state config (TOML)")
      ->envname("MUSHER_CONFIG");
  bool check = false;
  app.add_flag("--check", check, "Report every error of the configs, and start nothing");
  auto* alone = app.add_flag("--alone", options.alone, "Run without a machine, until Ctrl+C");
  app.add_option("--namespace", options.name_space, "Of the topics, with --alone")->needs(alone);
  auto* draw = app.add_option("--draw", options.picture,
                              "Draw what the scene does by itself to this PNG, and end");
  app.add_option("--shot", options.shot,
                 "Draw what a camera (front, left, right, a robot) sees to this PNG, and end")
      ->expected(2)
      ->type_name("CAMERA FILE")
      ->excludes(draw)
      ->excludes(alone);
  constexpr std::uint64_t kMostSeed = std::uint64_t{1} << 62;
  app.add_option("--seed", options.seed, "Of this run, instead of the scene's")
      ->check(CLI::Range(std::uint64_t{0}, kMostSeed).description(""));
  app.add_option("--choose", options.choose, "A value of the scene's [choices]; repeatable")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--for", options.seconds, "World time before that, in s")
      ->check(CLI::Range(0.0, kLongestS));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return musher::EndOfParse(app, error, kUsageError);
  }
  if (check) musher::program::OnlyCheck();
  return Run(options);
}
