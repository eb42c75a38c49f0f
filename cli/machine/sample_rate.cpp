#include "musher/cli/machine/sample_rate.hpp"

#include <algorithm>
#include <cmath>

namespace musher::cli {

void SampleRate::Add(Time at) {
  ++all_;
  times_.push_back(at);
  if (times_.size() > window_) times_.pop_front();
}

std::optional<SampleRate::Report> SampleRate::Now() const {
  if (times_.size() < 2) return std::nullopt;
  const double gaps = static_cast<double>(times_.size() - 1);
  const double mean = ToSeconds(times_.back() - times_.front()) / gaps;
  Report report{times_.size(), mean > 0 ? 1 / mean : 0, mean, mean, 0};
  double squares = 0;
  for (std::size_t i = 1; i < times_.size(); ++i) {
    const double gap = ToSeconds(times_[i] - times_[i - 1]);
    report.min_s = std::min(report.min_s, gap);
    report.max_s = std::max(report.max_s, gap);
    squares += (gap - mean) * (gap - mean);
  }
  report.stddev_s = std::sqrt(squares / gaps);
  return report;
}

}  // namespace musher::cli
