#include "musher/test/benchmark/common/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace musher::benchmark {

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at = std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[at];
}

double Median(const std::vector<double>& values) {
  return Quantile(values, 0.5);
}

double Microseconds(Duration duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}

Table::Table(const std::string& title) {
  std::printf("\n### %s\n\n", title.c_str());
  std::printf(
      "| what | median | quartiles | p99 | max | n | target |\n|---|---|---|---|---|---|---|\n");
  std::fflush(stdout);
}

void Table::Row(const std::string& what, const std::vector<double>& values, const std::string& unit,
                double limit) const {
  const double median = Median(values);
  const int digits = unit.empty() || median >= 1000 ? 0 : median < 10 ? 2 : 1;
  std::printf("| %s | %.*f %s | %.*f – %.*f | %.*f | %.*f | %zu | ", what.c_str(), digits, median,
              unit.c_str(), digits, Quantile(values, 0.25), digits, Quantile(values, 0.75), digits,
              Quantile(values, 0.99), digits, Quantile(values, 1), values.size());
  if (limit > 0) {
    const bool met = !values.empty() && median <= limit;
    std::printf("≤ %g: %s ", limit, met ? "met" : "**missed**");
  }
  std::printf("|\n");
  std::fflush(stdout);
}

std::vector<double> Ratios(const std::vector<double>& above, const std::vector<double>& below) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(above.size(), below.size()); ++i) {
    ratios.push_back(above[i] / below[i]);
  }
  return ratios;
}

}  // namespace musher::benchmark
