#pragma once
// Statistics of a series of pictures: how many arrived, how often, how old they were, and how many
// are missing. A missing one is detected by the gap that it leaves between two stamps. Pure.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/messages/sensor_msgs/image.hpp"

namespace musher::camera::tool {

class PictureCount {
 public:
  void Add(const msg::Image& picture, Duration age, Time now);

  std::size_t count() const { return ages_ms_.size(); }
  // "640x480 bgr8", of the last one.
  const std::string& shape() const { return shape_; }
  // Pictures a second, from the first that arrived to the last.
  double RateHz() const;
  // Below which `share` of the ages lie.
  double AgeMs(double share) const;
  // Missing between the first and the last.
  std::uint64_t Lost() const;

 private:
  std::string shape_;
  std::vector<double> ages_ms_;
  std::vector<std::int64_t> stamps_ns_;
  Time first_{};
  Time last_{};
};

}  // namespace musher::camera::tool
