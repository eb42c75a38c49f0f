#pragma once
// Measured values and their report: a Markdown table on stdout with medians and spread.

#include <cstddef>
#include <string>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::benchmark {

// The value below which `share` (0 to 1) of the values lie; 0 when there are none.
double Quantile(std::vector<double> values, double share);
double Median(const std::vector<double>& values);

double Microseconds(Duration duration);

// Columns: what, median, quartiles, 99th percentile, the highest, number of values, target and
// whether it is met.
class Table {
 public:
  explicit Table(const std::string& title);

  // `unit` empty: the values are whole. `limit`: the median may not be above it, and there has to
  // be one; 0: there is no target.
  void Row(const std::string& what, const std::vector<double>& values, const std::string& unit,
           double limit = 0) const;
};

// Of values measured in turns: the n-th of `above` by the n-th of `below`.
std::vector<double> Ratios(const std::vector<double>& above, const std::vector<double>& below);

}  // namespace musher::benchmark
