// The plans of a competition robot: how long the search takes for a map, and the check of a plan.
//
//   benchmark_meilin [MAPS [SEED]]
//
// CPU time of the calling thread.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <random>
#include <vector>

#include "musher/modules/meilin/plan/box_map_text.hpp"
#include "musher/test/benchmark/common/statistics.hpp"

namespace musher::benchmark {
namespace {

using namespace meilin;  // NOLINT(google-build-using-namespace)

double CpuUs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e6 + static_cast<double>(time.tv_nsec) / 1e3;
}

double UsOf(const std::function<void()>& call) {
  const double begin_us = CpuUs();
  call();
  return CpuUs() - begin_us;
}

void Row(const char* what, const std::vector<double>& values_us) {
  std::printf("| %s | %.3g | %.3g | %.3g | %zu |\n", what, Median(values_us),
              Quantile(values_us, 0.99), Quantile(values_us, 1), values_us.size());
}

// As many boxes in rows 1 to 4 as a map has in a match, the rest empty.
BoxMap RandomMap(std::mt19937_64& random, int kfs1, int kfs2, int fake) {
  std::vector<Box> boxes(12, Box::kEmpty);
  auto next = boxes.begin();
  next = std::fill_n(next, kfs1, Box::kKfs1);
  next = std::fill_n(next, kfs2, Box::kKfs2);
  std::fill_n(next, fake, Box::kFake);
  std::shuffle(boxes.begin(), boxes.end(), random);
  BoxMap map;
  map.side = random() % 2 == 0 ? Side::kBlue : Side::kRed;
  for (std::size_t index = 0; index < boxes.size(); ++index) {
    map.boxes.at(1 + index / kCols).at(index % kCols) = boxes[index];
  }
  return map;
}

void MeasureSearch(const char* what, int maps, std::uint64_t seed, int kfs1, int kfs2, int fake) {
  std::mt19937_64 random(seed);
  std::vector<double> search_us, check_us;
  int with_plan = 0, incomplete = 0;
  for (int count = 0; count < maps; ++count) {
    const BoxMap map = RandomMap(random, kfs1, kfs2, fake);
    RouteReport report;
    search_us.push_back(UsOf([&] { report = FindRoutes(map); }));
    incomplete += report.complete ? 0 : 1;
    const Route* best = BestRoute(report.routes);
    if (best == nullptr) continue;
    ++with_plan;
    PlanRules rules;
    rules.grid.side = map.side;
    const auto plan = ToActionSequence(best->steps);
    check_us.push_back(UsOf([&] {
      if (!ReadActionSequence(plan, rules, {}).ok()) std::abort();
    }));
  }
  std::printf("\n%s: %d of %d maps have a plan, %d searches ended at the limit\n\n", what,
              with_plan, maps, incomplete);
  std::printf("| what | median us | p99 us | highest us | number |\n|---|---|---|---|---|\n");
  Row("search of all plans", search_us);
  if (!check_us.empty()) Row("check of the best plan", check_us);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int maps = argc > 1 ? std::atoi(argv[1]) : 1000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  musher::benchmark::MeasureSearch("A match: 3 KFS1, 4 KFS2, 1 fake", maps, seed, 3, 4, 1);
  musher::benchmark::MeasureSearch("Boxes on every cell: 4 KFS1, 8 KFS2", maps, seed, 4, 8, 0);
  return 0;
}
