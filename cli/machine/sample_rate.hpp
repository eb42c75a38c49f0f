#pragma once
// The rate of a topic's samples, by the times between them. Pure.

#include <cstddef>
#include <deque>
#include <optional>

#include "musher/base/time.hpp"

namespace musher::cli {

class SampleRate {
 public:
  // Of the last `window` samples; at least 2.
  explicit SampleRate(std::size_t window) : window_(window) {}

  void Add(Time at);

  struct Report {
    std::size_t samples = 0;
    double rate_hz = 0;
    // between two samples
    double min_s = 0;
    double max_s = 0;
    double stddev_s = 0;
  };
  // nullopt: fewer than two samples.
  std::optional<Report> Now() const;

  std::size_t all() const { return all_; }  // since the begin

 private:
  const std::size_t window_;
  std::size_t all_ = 0;
  std::deque<Time> times_;
};

}  // namespace musher::cli
