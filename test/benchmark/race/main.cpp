// Drives the whole course in virtual time, by rendered pictures, for one seed or many: which runs
// arrive, how long they take, which lines are stepped on.
//
//   benchmark_race                        seed 1, the choices of the seed
//   benchmark_race --seeds 40             seeds 1 to 40, a line for each, and the sums
//   benchmark_race --seed 3 --choose arrow=left --log --pictures DIR

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "musher/modules/world/picture/picture.hpp"
#include "musher/modules/world/simulation/referee_report.hpp"
#include "musher/test/modules/race/drive/course_drive.hpp"

namespace {

using musher::race::testing::CourseDrive;
using musher::race::testing::DriveResult;
using musher::race::testing::DriveSettings;

double Seconds(musher::Duration time) {
  return std::chrono::duration<double>(time).count();
}

bool Drive(const DriveSettings& settings, const std::string& drawing) {
  CourseDrive drive(settings);
  const DriveResult result = drive.Run();
  const musher::world::Referee& referee = result.world->referee();
  int corrections = 0;
  std::string last;
  for (const std::string& line : result.log) {
    if (line.find("correction ") != std::string::npos) ++corrections;
    if (line.find("race:") != std::string::npos) last = line;
  }
  const bool whole = result.state == "END" && referee.finished() && referee.whole_foot_count() == 0;
  std::printf(
      "seed %2d: %s %-12s %5.0f s, %3d corrections, %4zu pictures, feet on lines %zu (whole %zu), "
      "collisions %zu, zones %zu%s\n",
      static_cast<int>(settings.seed), whole ? "ok  " : "FAIL", result.state.c_str(),
      Seconds(result.took), corrections, result.pictures, referee.touch_count(),
      referee.whole_foot_count(), referee.collisions(), referee.visits().size(),
      whole ? "" : ("\n    " + last).c_str());
  if (!whole) {
    const auto& world = *result.world;
    std::printf("%s\n", musher::world::RefereeText(world.scene(), referee, world.now()).c_str());
  }
  for (const auto& touch : referee.touches()) {
    if (!touch.whole_foot) continue;
    std::printf("    %s foot on a line at %.1f s (%.2f, %.2f)\n", musher::world::kFeet[touch.foot],
                Seconds(touch.from), touch.where_m.x(), touch.where_m.y());
  }
  std::fflush(stdout);
  if (!drawing.empty()) static_cast<void>(musher::world::Draw(*result.world, drawing));
  return whole;
}

}  // namespace

int main(int argc, char** argv) {
  DriveSettings settings;
  int seeds = 0;
  bool log = false;
  std::vector<std::string> chosen;
  std::vector<double> from;
  std::string drawing;
  CLI::App app("Drives the course in virtual time.", "benchmark_race");
  app.add_option("--seed", settings.seed, "The seed of a single run");
  app.add_option("--seeds", seeds, "Runs the seeds 1 to N");
  app.add_option("--choose", chosen, "NAME=VALUE of the scene's choices");
  app.add_option("--pictures", settings.pictures, "A folder for what the detectors saw");
  app.add_option("--draw", drawing, "A PNG of the run from above");
  app.add_option("--lines-from", from, "Prints the lines seen from a pose instead: m, m, degrees")
      ->expected(3);
  app.add_flag("--light", settings.yellow_light, "A yellow light appears in the START lane");
  app.add_flag("--log", log, "Prints what happens");
  CLI11_PARSE(app, argc, argv);
  for (const std::string& each : chosen) {
    const std::size_t equals = each.find('=');
    settings.chosen[each.substr(0, equals)] = each.substr(equals + 1);
  }
  if (log) settings.on_log = [](const std::string& line) { std::printf("%s\n", line.c_str()); };
  if (!from.empty()) {
    CourseDrive drive(settings);
    for (const std::string& line : drive.LinesFrom({{from[0], from[1]}, from[2] * M_PI / 180})) {
      std::printf("%s\n", line.c_str());
    }
    return 0;
  }
  if (seeds == 0) return Drive(settings, drawing) ? 0 : 1;
  int whole = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    settings.seed = static_cast<std::uint64_t>(seed);
    if (Drive(settings, "")) ++whole;
  }
  std::printf("%d of %d whole courses\n", whole, seeds);
  return 0;
}
