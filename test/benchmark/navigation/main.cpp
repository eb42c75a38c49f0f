// The navigation chain: how long planner, trajectory and controller take, how short the paths are,
// how well a body follows, and what happens among movers.
//
//   benchmark_navigation [RUNS [SEED [PART]]]
//
// RUNS: maps of the planner; navigations among movers are as many, other parts have fewer. PART:
// one of planner, samples, space, trajectory, controller, tracking, movers, gate, appearances. CPU
// time of the calling thread.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "musher/navigation/controller/axis_control.hpp"
#include "musher/navigation/gate/motion_gate.hpp"
#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/planner/planner.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/navigation/sampled_search.hpp"
#include "musher/test/navigation/drive.hpp"
#include "musher/test/navigation/gate_run.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/test/navigation/scanned_body.hpp"

namespace musher::benchmark {
namespace {

using namespace navigation;           // NOLINT(google-build-using-namespace)
using namespace navigation::testing;  // NOLINT(google-build-using-namespace)

double CpuMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) / 1e6;
}

double MsOf(const std::function<void()>& call) {
  const double begin_ms = CpuMs();
  call();
  return CpuMs() - begin_ms;
}

void Row(const char* what, const std::vector<double>& values, const char* unit) {
  std::printf("| %s | %.3g | %.3g | %.3g | %s | %zu |\n", what, Median(values),
              Quantile(values, 0.99), Quantile(values, 1), unit, values.size());
}

void Head(const char* title) {
  std::printf(
      "\n%s\n\n| what | median | p99 | highest | unit | number |\n|---|---|---|---|---|---|\n",
      title);
}

// Maps of 200 x 200 cells of 5 cm with a fifth of them blocked, from one random place to another.
void MeasurePlanner(int runs, std::uint64_t seed) {
  std::vector<double> map_ms, find_ms, ratio, smooth_ms;
  int solved = 0, walled_in = 0;
  for (int run = 0; run < runs; ++run) {
    const CellMap map = RandomBoxes(seed + run, 10, 0.05, 0.2);
    PlannerRules rules;
    std::optional<Planner> planner;
    map_ms.push_back(MsOf([&] { planner = Planner::Make(map, rules).value(); }));
    std::mt19937_64 random(seed + run);
    const Pose start = {FreePlace(planner->clearance(), rules.radius_m, random), 0};
    const Pose goal = {FreePlace(planner->clearance(), rules.radius_m, random), 0};
    std::optional<Result<Plan>> plan;
    find_ms.push_back(MsOf([&] { plan = planner->Find(start, goal); }));
    if (!plan->ok()) {
      walled_in += Is(plan->error(), Fault::kWalledIn);
      continue;
    }
    ++solved;
    const Plan& found = plan->value();
    if (found.cell_length_m > 1) ratio.push_back(found.length_m / found.cell_length_m);
  }
  Head("Planner, 200 x 200 cells of 5 cm, 20 % blocked, a body of 0.3 m radius");
  Row("a map: distances, regions", map_ms, "ms");
  Row("a path", find_ms, "ms");
  Row("its length / the shortest from cell to cell", ratio, "");
  std::printf("\nSolved: %d of %d; no path by the map: %d; other refusals: %d.\n", solved, runs,
              walled_in, runs - solved - walled_in);
}

// The same paths by samples.
void CompareSearches(int runs, std::uint64_t seed) {
  std::printf(
      "\nSearches by samples, the first %d of these maps, 1 s of CPU each\n\n"
      "| planner | solved | of | CPU ms, median; p99 | length / the planner's, median |\n"
      "|---|---|---|---|---|\n",
      runs);
  for (const char* name : {"RRTConnect", "RRT*", "BIT*"}) {
    int solved = 0, possible = 0;
    std::vector<double> ms, ratio;
    for (int run = 0; run < runs; ++run) {
      const auto planner = Planner::Make(RandomBoxes(seed + run, 10, 0.05, 0.2), {}).value();
      std::mt19937_64 random(seed + run);
      const Point start = FreePlace(planner.clearance(), 0.3, random);
      const Point goal = FreePlace(planner.clearance(), 0.3, random);
      const auto plan = planner.Find({start, 0}, {goal, 0});
      if (!plan.ok() || plan.value().length_m < 1) continue;
      ++possible;
      std::optional<double> length_m;
      ms.push_back(
          MsOf([&] { length_m = SampledLength(name, planner.clearance(), 0.3, start, goal, 1); }));
      if (!length_m) continue;
      ++solved;
      ratio.push_back(*length_m / plan.value().length_m);
    }
    std::printf("| %s | %d | %d | %.3g; %.3g | %.3f |\n", name, solved, possible, Median(ms),
                Quantile(ms, 0.99), Median(ratio));
  }
}

void MeasureFlight(int runs, std::uint64_t seed) {
  std::vector<double> map_ms, find_ms;
  int solved = 0;
  for (int run = 0; run < runs; ++run) {
    std::mt19937_64 random(seed + run);
    CellMap map;
    map.resolution_m = 0.2;
    map.size_x = map.size_y = 100;
    map.size_z = 25;
    map.blocked.resize(std::size_t{100} * 100 * 25);
    for (int pillar = 0; pillar < 60; ++pillar) {
      const int x = static_cast<int>(random() % 96), y = static_cast<int>(random() % 96);
      const int top = 5 + static_cast<int>(random() % 20);
      for (int i = 0; i < 16 * top; ++i)
        map.blocked[map.IndexOf({x + i % 4, y + i / 4 % 4, i / 16})] = 1;
    }
    std::optional<Planner> planner;
    map_ms.push_back(MsOf([&] { planner = Planner::Make(map, {}).value(); }));
    const Pose start = {FreePlace(planner->clearance(), 0.3, random), 0};
    const Pose goal = {FreePlace(planner->clearance(), 0.3, random), 0};
    find_ms.push_back(MsOf([&] { solved += planner->Find(start, goal).ok(); }));
  }
  Head("Planner in space, 100 x 100 x 25 cells of 20 cm, 60 pillars");
  Row("a map: distances, regions", map_ms, "ms");
  Row("a path", find_ms, "ms");
  std::printf("\nSolved: %d of %d.\n", solved, runs);
}

void MeasureTrajectory(int runs, std::uint64_t seed) {
  std::vector<double> ms;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> turn(-0.3, 0.3);
  for (int run = 0; run < runs; ++run) {
    navigation::Path path = {{{0, 0, 0}, 0}};
    for (int i = 1; i < 100; ++i) {
      const Pose& last = path.back();
      const double yaw = last.yaw_rad + turn(random);
      path.push_back(
          {{last.at.x_m + 0.2 * std::cos(yaw), last.at.y_m + 0.2 * std::sin(yaw), 0}, yaw});
    }
    ms.push_back(MsOf([&] { (void)MakeTrajectory(path, {}).value(); }));
  }
  Head("Trajectory, 100 points, 20 m");
  Row("a trajectory", ms, "ms");
}

void MeasureController(int runs, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> error(-0.3, 0.3);
  const auto trajectory =
      MakeTrajectory({{{0, 0, 0}, 0}, {{9, 4, 0}, 1}, {{3, 9, 0}, 2}}, {}).value();
  Head("Controller, four axes, horizon 20");
  for (const double lag_s : {0.0, 0.2}) {
    std::vector<double> us;
    FollowerRules rules;
    rules.flat = false;
    rules.lag_s = lag_s;
    Follower follower(rules);
    Time now{};
    (void)follower.Start(trajectory, now).ok();
    for (int i = 0; i < runs * 50; ++i) {
      now += Milliseconds(1);
      const TrajectoryPoint at = trajectory.At(Milliseconds(i % 8000));
      const Pose pose = {
          {at.pose.at.x_m + error(random), at.pose.at.y_m + error(random), error(random)},
          at.pose.yaw_rad + error(random)};
      us.push_back(1e3 * MsOf([&] { (void)follower.Update(now, pose, at.velocity, {}); }));
    }
    Row(lag_s > 0 ? "an update, the lag of the body known" : "an update, integrator", us, "µs");
  }
}

// A body with a lag of 0.2 s on random paths, with what the controller knows and weighs.
void MeasureTracking(int runs, std::uint64_t seed) {
  std::puts(
      "\nTracking, a body with a lag of 0.2 s\n\n"
      "| step, s | control weight | lag known | rms, m | highest, m | arrived "
      "|\n|---|---|---|---|---|---|");
  for (const bool known : {false, true}) {
    for (const double step_s : {0.01, 1.0 / 60, 0.05}) {
      for (const double weight : {0.5, 0.05}) {
        double squares = 0, most_m = 0;
        int arrived = 0;
        for (int run = 0; run < runs; ++run) {
          const CellMap map = RandomBoxes(seed + run, 15, 0.1, 0.1);
          DriveOptions options;
          options.follower.lag_s = known ? 0.2 : 0;
          options.follower.step_s = step_s;
          options.follower.velocity_weight = weight;
          options.follower.yaw_rate_weight = weight / 5;
          std::mt19937_64 random(seed + run);
          const Clearance clearance(map);
          const Pose start = {FreePlace(clearance, 0.4, random), 0};
          const Pose goal = {FreePlace(clearance, 0.4, random), 0};
          const DriveResult result = Drive(map, start, goal, options);
          arrived += result.end == DriveResult::End::kArrived;
          squares += result.tracking_rms_m * result.tracking_rms_m;
          most_m = std::max(most_m, result.tracking_most_m);
        }
        std::printf("| %.3f | %.2f | %s | %.4f | %.4f | %d |\n", step_s, weight,
                    known ? "yes" : "no", std::sqrt(squares / runs), most_m, arrived);
      }
    }
  }
}

std::vector<Mover> MoversOn(const Clearance& clearance, const Point& keep_away, int count,
                            bool yield, std::mt19937_64& random) {
  std::vector<Mover> movers;
  while (static_cast<int>(movers.size()) < count) {
    const Point from = FreePlace(clearance, 0.3, random), to = FreePlace(clearance, 0.3, random);
    if (Distance(from, to) < 2 || !clearance.FitsAlong(from, to, 0.25)) continue;
    if (Distance(from, keep_away) < 1.5) continue;
    Mover mover{from, to};
    mover.yields = yield;
    mover.speed_m_s = 0.2 + 0.1 * static_cast<double>(random() % 5);
    movers.push_back(mover);
  }
  return movers;
}

void MeasureNavigations(int runs, std::uint64_t seed, bool yield) {
  int arrived = 0, refused = 0, hits_of_body = 0, hits_of_movers = 0, walls = 0, replans = 0;
  std::map<std::string, int> failed;
  std::vector<double> seconds, waited;
  for (int run = 0; run < runs; ++run) {
    const CellMap map = RandomBoxes(seed + run, 15, 0.1, 0.1);
    const Clearance clearance(map);
    std::mt19937_64 random(seed + run);
    const Pose start = {FreePlace(clearance, 0.4, random), 0};
    const Pose goal = {FreePlace(clearance, 0.4, random), 0};
    DriveOptions options;
    options.movers = MoversOn(clearance, start.at, 5, yield, random);
    const DriveResult result = Drive(map, start, goal, options);
    arrived += result.end == DriveResult::End::kArrived;
    refused += result.end == DriveResult::End::kRefused;
    if (result.end == DriveResult::End::kFailed) {
      ++failed[result.reason.substr(0, 3) == "not" ? "late" : "obstacle"];
      std::printf("run %d: %s\n", run, result.reason.c_str());
    }
    if (result.hits_of_body > 0) std::printf("run %d: hit a mover\n", run);
    hits_of_body += result.hits_of_body;
    hits_of_movers += result.hits_of_movers;
    walls += result.end != DriveResult::End::kRefused && result.least_room_m < -0.001;
    replans += result.replans;
    if (result.end == DriveResult::End::kArrived) {
      seconds.push_back(result.seconds);
      waited.push_back(result.waited_s);
    }
  }
  Head(yield ? "Navigations among 5 movers that stand before the body, 15 x 15 m"
             : "The same, with movers that never stand");
  Row("time to the goal", seconds, "s");
  Row("of it in waiting", waited, "s");
  std::printf(
      "\nArrived: %d of %d; no path by the map: %d; an obstacle stayed: %d; late: %d; new plans: "
      "%d.\nCollisions with walls: %d; of the body, driving towards a mover: %d; of a mover "
      "that comes to the body: %d.\n",
      arrived, runs, refused, failed["obstacle"], failed["late"], replans, walls, hits_of_body,
      hits_of_movers);
}

// 20 s of commands of a source that knows nothing, on random maps; and what a check costs.
void MeasureGate(int runs, std::uint64_t seed) {
  std::printf("\n%d bodies of 0.2 m radius for 20 s of any commands\n\n", runs);
  std::printf("| | contacts | driven, m | least room, m |\n|---|---|---|---|\n");
  for (const bool gated : {false, true}) {
    int contacts = 0;
    double driven_m = 0, least_m = 1;
    for (int run = 0; run < runs; ++run) {
      const GateRun result = RunThroughGate(seed + run, gated);
      contacts += result.least_room_m <= 0;
      driven_m += result.driven_m;
      least_m = std::min(least_m, result.least_room_m);
    }
    std::printf("| %s | %d | %.0f | %.3f |\n", gated ? "with the gate" : "without", contacts,
                driven_m, least_m);
  }
  GateRules rules;
  rules.scanners = {{.topic = "scan"}};
  MotionGate gate(rules);
  Scan scan{0, M_PI / 180, 0.05, 8, std::vector<float>(360, 1.2F)};
  Time now{};
  gate.OnScan(0, scan, {}, now);
  // What the gate adds between a command, or a scan, and what is published.
  std::vector<double> check_us, scan_us;
  for (int i = 0; i < 1000; ++i) {
    check_us.push_back(1e3 * MsOf([&] { gate.Check({1.5, 0, 0, 0.5}, now); }));
    now += Milliseconds(100);
    scan_us.push_back(1e3 * MsOf([&] {
                        gate.OnScan(0, scan, now.time_since_epoch(), now);
                        gate.Check({1.5, 0, 0, 0.5}, now);
                      }));
  }
  Head("The gate, a scan of 360 points 1.2 m around a body at 1.5 m/s");
  Row("a check, of each command", check_us, "us");
  Row("a scan, and the check after it", scan_us, "us");
}

// What the only scanner of a body sees of a disc.
Scan LookAt(const Pose& body, const Point& disc, double disc_radius_m) {
  Scan scan{0, M_PI / 180, 0.02, 8, {}};
  const double x = disc.x_m - body.at.x_m, y = disc.y_m - body.at.y_m;
  for (int i = 0; i < 360; ++i) {
    const double angle_rad = body.yaw_rad + scan.from_rad + i * scan.step_rad;
    const double along = x * std::cos(angle_rad) + y * std::sin(angle_rad);
    const double square = disc_radius_m * disc_radius_m - (x * x + y * y - along * along);
    const bool hits = along > 0 && square >= 0;
    scan.ranges_m.push_back(hits ? static_cast<float>(along - std::sqrt(square)) : 9.0F);
  }
  return scan;
}

struct Appearance {
  double needed_m = 0;  // to stand, with a scan and a command that come at the worst moment
  double appears_m = 0;
  double left_m = 0;  // between body and disc, once it stands
};

// A disc appears ahead of a body that drives straight on, at any moment between two scans.
Appearance StopBeforeADisc(std::uint64_t seed) {
  constexpr double kDiscM = 0.2, kStepS = 1.0 / 60, kScanS = 0.1;
  std::mt19937_64 random(seed);
  const auto between = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  const Clearance nowhere(RandomBoxes(1, 1, 0.5, 0));
  const ScannedBodyOptions options;
  ScannedBody body(nowhere, {}, options);
  GateRules rules;
  rules.scanners = {{.topic = "scan"}};
  rules.reaction_s = 0.2 + options.lag_s;
  MotionGate gate(rules);
  const double speed_m_s = between(0.2, 1.5), aside_m = between(-0.15, 0.15);
  const double seen_at_s = 4 + between(0, kScanS);
  Appearance result;
  result.needed_m = speed_m_s * speed_m_s / (2 * options.acceleration_m_s2) +
                    speed_m_s * (kScanS + options.lag_s + kStepS);
  result.appears_m = between(0.02, 2.5);
  Point disc{1e3, 0, 0};
  Time now = Time{} + std::chrono::seconds(1);
  double scan_s = 0;
  for (double at_s = 0; at_s < 12; at_s += kStepS, now += FromSeconds(kStepS)) {
    if (at_s >= seen_at_s && disc.x_m > 999) {
      const double clear_m = options.radius_m + kDiscM;  // of the middles, where they touch
      const double touch_m = std::sqrt(clear_m * clear_m - aside_m * aside_m);
      disc = {body.pose().at.x_m + touch_m + result.appears_m, aside_m, 0};
    }
    if (at_s >= scan_s) {
      scan_s += kScanS;
      gate.OnScan(0, LookAt(body.pose(), disc, kDiscM), now.time_since_epoch(), now);
    }
    gate.OnVelocity(body.velocity(), now);
    body.Move(gate.Check({speed_m_s, 0, 0, 0}, now).command, kStepS);
  }
  result.left_m = Distance(body.pose().at, disc) - options.radius_m - kDiscM;
  if (body.pose().at.x_m > disc.x_m) result.left_m = -1;  // it has gone through
  return result;
}

void MeasureAppearances(int runs, std::uint64_t seed) {
  std::vector<double> left_m, too_near_m;
  int contacts = 0, contacts_near = 0;
  for (int run = 0; run < runs; ++run) {
    const Appearance one = StopBeforeADisc(seed + run);
    const bool possible = one.appears_m > one.needed_m;
    (possible ? left_m : too_near_m).push_back(one.left_m);
    (possible ? contacts : contacts_near) += one.left_m <= 0;
  }
  Head("A disc that appears ahead of a body at 0.2 to 1.5 m/s, scans at 10 Hz: what is left");
  Row("where the body can stand in time", left_m, "m");
  Row("nearer", too_near_m, "m");
  std::printf("\nContacts: %d of %zu; nearer than it can brake: %d of %zu; least left: %.3f m.\n",
              contacts, left_m.size(), contacts_near, too_near_m.size(),
              left_m.empty() ? 0 : *std::min_element(left_m.begin(), left_m.end()));
}

// All parts, or one.
void Run(int runs, std::uint64_t seed, const std::string& part) {
  const auto wanted = [&](const char* name) { return part.empty() || part == name; };
  if (wanted("planner")) MeasurePlanner(runs, seed);
  if (wanted("samples")) CompareSearches(std::max(1, runs / 20), seed);
  if (wanted("space")) MeasureFlight(std::max(1, runs / 5), seed);
  if (wanted("trajectory")) MeasureTrajectory(runs, seed);
  if (wanted("controller")) MeasureController(runs, seed);
  if (wanted("tracking")) MeasureTracking(std::max(1, runs / 10), seed);
  if (wanted("movers")) MeasureNavigations(runs, seed, true);
  if (wanted("movers")) MeasureNavigations(runs, seed, false);
  if (wanted("gate")) MeasureGate(runs, seed);
  if (wanted("appearances")) MeasureAppearances(5 * runs, seed);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const int runs = argc > 1 ? std::atoi(argv[1]) : 200;
  const int seed = argc > 2 ? std::atoi(argv[2]) : 1;
  musher::benchmark::Run(runs > 0 ? runs : 1, static_cast<std::uint64_t>(seed),
                         argc > 3 ? argv[3] : "");
}
