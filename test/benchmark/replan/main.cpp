// A path around a thing that the map does not have: how long the planner takes for a robot that
// drives, near it, and for one without an earlier path, on the whole map.
//
//   benchmark_replan [RUNS [SEED]]     (500)   CPU time of the calling thread

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <vector>

#include "musher/modules/navigation/planner_server/planner_work.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/navigation/maps.hpp"

namespace musher::benchmark {
namespace {

using namespace navigation;           // NOLINT(google-build-using-namespace)
using namespace navigation::testing;  // NOLINT(google-build-using-namespace)

double CpuMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) / 1e6;
}

struct Replans {
  std::vector<double> local_ms, whole_ms;
  int around = 0, through = 0, none = 0;
};

// The rim of a disc on the path, so far from its begin, as a scan sees it.
std::vector<Point> SeenOn(const Path& path, double ahead_m, double radius_m) {
  double left_m = ahead_m;
  Point at = path.back().at;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double length_m = Distance(path[i - 1].at, path[i].at);
    if (length_m >= left_m) {
      at = Between(path[i - 1].at, path[i].at, left_m / length_m);
      break;
    }
    left_m -= length_m;
  }
  std::vector<Point> seen;
  for (int i = 0; i < 40; ++i) {
    const double angle_rad = 2 * M_PI * i / 40;
    seen.push_back(
        {at.x_m + radius_m * std::cos(angle_rad), at.y_m + radius_m * std::sin(angle_rad), 0});
  }
  return seen;
}

void Measure(double side_m, int runs, std::uint64_t seed, Replans& replans) {
  PlannerConfig config;
  PlannerRobot robot;
  for (int run = 0; run < runs; ++run) {
    PlannerRules rules;
    rules.radius_m = robot.radius_m + robot.margin_m;
    rules.start_within_m = robot.margin_m;
    const auto planner = Planner::Make(RandomBoxes(seed + run, side_m, 0.05, 0.1), rules);
    if (!planner) continue;
    std::mt19937_64 random(seed + run);
    PathRequest request;
    request.start = {FreePlace(planner.value().clearance(), 0.4, random), 0};
    request.goal = {FreePlace(planner.value().clearance(), 0.4, random), 0};
    const PathReply first = FindPath(planner.value(), request, config, robot, {});
    if (!first.plan || first.plan.value().length_m < 4) continue;
    request.seen = SeenOn(first.plan.value().path, 2, 0.25);
    const auto time = [&](std::vector<double>& ms) {
      const double begin_ms = CpuMs();
      const PathReply reply = FindPath(planner.value(), request, config, robot, {});
      ms.push_back(CpuMs() - begin_ms);
      return reply;
    };
    static_cast<void>(time(replans.whole_ms));
    request.before = first.plan.value().path;
    const PathReply reply = time(replans.local_ms);
    replans.none += !reply.plan;
    (reply.around_seen ? replans.around : replans.through) += reply.plan.ok();
  }
}

void Row(const char* what, const std::vector<double>& ms) {
  std::printf("| %s | %.3g | %.3g | %.3g | ms | %zu |\n", what, Median(ms), Quantile(ms, 0.99),
              Quantile(ms, 1), ms.size());
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  using namespace musher::benchmark;  // NOLINT(google-build-using-namespace)
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const int runs = argc > 1 ? std::atoi(argv[1]) : 500;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  for (const double side_m : {10.0, 30.0}) {
    Replans replans;
    Measure(side_m, runs > 0 ? runs : 1, seed, replans);
    std::printf(
        "\nA disc of 0.25 m on the path, 2 m ahead, maps of %.0f x %.0f m, cells of 5 cm, 10 %% "
        "blocked\n\n| what | median | p99 | highest | unit | number |\n|---|---|---|---|---|---|\n",
        side_m, side_m);
    Row("a robot that drives: near it first", replans.local_ms);
    Row("without an earlier path: the whole map as well", replans.whole_ms);
    std::printf("\nAround it: %d; there is no way around: %d; no path: %d.\n", replans.around,
                replans.through, replans.none);
  }
  return 0;
}
