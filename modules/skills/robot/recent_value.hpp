#pragma once
// The last value of a topic, as long as it is recent: 0.5 s of the machine's clock, unless the
// topic is slow. Older ones are not what the robot sees now. Any thread, one at a time.

#include <optional>
#include <utility>

#include "musher/base/time.hpp"

namespace musher::skills {

template <class T>
class RecentValue {
 public:
  RecentValue() = default;
  explicit RecentValue(Duration longest) : longest_(longest) {}

  void Set(T value, Time at) {
    value_ = std::move(value);
    at_ = at;
  }
  void Clear() { value_.reset(); }
  // Null: none came, or the last one is too old. A clock that jumped back makes it too old as well.
  const T* At(Time now) const {
    if (!value_ || now < at_ || now - at_ > longest_) return nullptr;
    return &*value_;
  }

 private:
  Duration longest_ = Milliseconds(500);
  std::optional<T> value_;
  Time at_;
};

}  // namespace musher::skills
