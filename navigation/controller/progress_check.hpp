#pragma once
// Whether a body makes progress, as nav2's SimpleProgressChecker has it: it has to move so far
// within so long. Pure; one thread.

#include <optional>

#include "musher/base/time.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation {

struct ProgressRules {
  double radius_m = 0.5;
  Duration time = std::chrono::seconds(10);

  friend bool operator==(const ProgressRules&, const ProgressRules&) = default;
};

class ProgressCheck {
 public:
  // Nullopt: nothing is required.
  void Begin(const std::optional<ProgressRules>& rules) {
    rules_ = rules;
    from_.reset();
  }
  // False: it has not moved far enough for too long.
  bool Note(const Pose& pose, Time now) {
    if (!rules_) return true;
    if (!from_ || Distance(pose.at, from_->at) >= rules_->radius_m) {
      from_ = pose;
      since_ = now;
    }
    return now - since_ <= rules_->time;
  }
  const std::optional<ProgressRules>& rules() const { return rules_; }

 private:
  std::optional<ProgressRules> rules_;
  std::optional<Pose> from_;
  Time since_{};
};

}  // namespace musher::navigation
