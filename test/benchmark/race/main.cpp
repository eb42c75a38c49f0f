// Drives the whole course in virtual time, by rendered pictures, for one seed or many: which runs
// arrive, how long they take, which lines are stepped on.
//
//   benchmark_race                        seed 1, the choices of the seed
//   benchmark_race --seeds 40             seeds 1 to 40, a line for each, and the sums
//   benchmark_race --seed 3 --choose arrow=left --log --pictures DIR
//   benchmark_race --seeds 4 --figures    also how far the walker is beside the middle of the S,
//                                         and the time from a picture to what is done by it

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/world/picture/picture.hpp"
#include "musher/modules/world/simulation/referee_report.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/modules/race/drive/course_drive.hpp"

namespace {

using musher::race::testing::CourseDrive;
using musher::race::testing::DriveResult;
using musher::race::testing::DriveSettings;

using musher::ToSeconds;

// Metres to the left of the middle of the S lane of config/scenes/course.toml, for a robot that
// walks east; nothing beside its ends.
std::optional<double> BesideS(const Eigen::Vector2d& at_m) {
  constexpr double kBeginM = 0.54, kEndM = 4.43, kRadiusM = 1.6;
  const Eigen::Vector2d first(1.7, 1.2), second(4.1513, -0.857);  // the centres of its arcs
  const double x = at_m.x();
  if (x < kBeginM || x > kEndM) return std::nullopt;
  if (x < first.x()) return at_m.y() - (first.y() - kRadiusM);
  if (x > second.x()) return at_m.y() - (second.y() + kRadiusM);
  const bool in_first = (at_m - first).norm() < (at_m - second).norm();
  return in_first ? kRadiusM - (at_m - first).norm() : (at_m - second).norm() - kRadiusM;
}

// Of all runs.
struct Figures {
  std::vector<double> beside_m;    // while the walker is on the S lane
  std::vector<double> speeds_m_s;  // of the body, ahead
  std::vector<double> walker_ms, race_ms, walker_cpu_us, race_cpu_us;

  void See(const musher::world::World& world, bool walks) {
    const auto& body = world.body();
    const auto beside_m = walks ? BesideS(body.pose().position_m) : std::nullopt;
    if (!beside_m) return;
    this->beside_m.push_back(std::abs(*beside_m));
    speeds_m_s.push_back(body.speed().x());
  }

  void Add(const musher::race::testing::Latencies& latencies) {
    const auto add = [](const std::vector<musher::Duration>& times, double unit_ns, auto& values) {
      for (const musher::Duration time : times) {
        values.push_back(static_cast<double>(time.count()) / unit_ns);
      }
    };
    add(latencies.of_walker, 1e6, walker_ms);
    add(latencies.of_race, 1e6, race_ms);
    add(latencies.walker_cpu, 1e3, walker_cpu_us);
    add(latencies.race_cpu, 1e3, race_cpu_us);
  }

  void Print() const {
    double squares = 0;
    for (const double each : beside_m)
      squares += each * each / static_cast<double>(beside_m.size());
    const musher::benchmark::Table table("The race on its course, in virtual time");
    std::printf("| beside the middle of the S, rms | %.1f cm | | | | | |\n",
                100 * std::sqrt(squares));
    std::vector<double> beside_cm;
    for (const double each : beside_m) beside_cm.push_back(100 * each);
    table.Row("beside the middle of the S", beside_cm, "cm");
    table.Row("speed on the S", speeds_m_s, "m/s");
    table.Row("from a picture to the walker's frame", walker_ms, "ms");
    table.Row("from a picture to a decision of the race", race_ms, "ms");
    table.Row("CPU of the walker for it", walker_cpu_us, "µs");
    table.Row("CPU of the race for it", race_cpu_us, "µs");
  }
};

bool Drive(DriveSettings settings, const std::string& drawing, Figures& figures) {
  settings.on_step = [&](const auto& world, bool walks) { figures.See(world, walks); };
  CourseDrive drive(settings);
  const DriveResult result = drive.Run();
  figures.Add(result.latencies);
  const musher::world::Referee& referee = result.world->referee();
  int corrections = 0;
  std::string last;
  for (const std::string& line : result.log) {
    if (line.find("correction ") != std::string::npos) ++corrections;
    const bool of_race = line.find("race:") != std::string::npos;
    if (of_race && line.find("reservation") == std::string::npos &&
        line.find("race:   ") == std::string::npos) {
      last = line;
    }
  }
  const bool whole = result.state == "END" && referee.finished() && referee.whole_foot_count() == 0;
  std::printf(
      "seed %2d: %s %-12s %5.0f s, %3d corrections, %4zu pictures, feet on lines %zu (whole %zu), "
      "collisions %zu, zones %zu, reservations %zu%s\n",
      static_cast<int>(settings.seed), whole ? "ok  " : "FAIL", result.state.c_str(),
      ToSeconds(result.took), corrections, result.pictures, referee.touch_count(),
      referee.whole_foot_count(), referee.collisions(), referee.visits().size(),
      result.reservations.size(), whole ? "" : ("\n    " + last).c_str());
  if (!whole) {
    const auto& world = *result.world;
    std::printf("%s\n", musher::world::RefereeText(world.scene(), referee, world.now()).c_str());
  }
  for (const std::string& each : result.reservations) std::printf("    %s\n", each.c_str());
  for (const auto& touch : referee.touches()) {
    if (!touch.whole_foot) continue;
    std::printf("    %s foot on a line at %.1f s (%.2f, %.2f)\n", musher::world::kFeet[touch.foot],
                ToSeconds(touch.from), touch.where_m.x(), touch.where_m.y());
  }
  std::fflush(stdout);
  if (!drawing.empty()) static_cast<void>(musher::world::Draw(*result.world, drawing));
  return whole;
}

}  // namespace

int main(int argc, char** argv) {
  DriveSettings settings;
  int seeds = 0;
  bool log = false, with_figures = false;
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
  app.add_option("--slip", settings.slip, "Of the feet, 0 to 1, instead of the scene's");
  app.add_option("--unseen", settings.unseen, "Detectors of the race that never see their thing");
  app.add_flag("--light", settings.yellow_light, "A yellow light appears in the START lane");
  app.add_flag("--log", log, "Prints what happens");
  app.add_flag("--figures", with_figures, "Prints a table of the walker's errors and of latencies");
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
  Figures figures;
  if (seeds == 0) {
    const bool good = Drive(settings, drawing, figures);
    if (with_figures) figures.Print();
    return good ? 0 : 1;
  }
  int whole = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    settings.seed = static_cast<std::uint64_t>(seed);
    if (Drive(settings, "", figures)) ++whole;
  }
  std::printf("%d of %d whole courses\n", whole, seeds);
  if (with_figures) figures.Print();
  return 0;
}
