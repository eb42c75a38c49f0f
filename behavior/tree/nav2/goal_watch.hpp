#pragma once
// Whether the goals of a navigation have changed; only for the nodes of this folder.

#include <optional>

#include "musher/behavior/tree/nav2/geometry.hpp"
#include "musher/behavior/tree/setup.hpp"

namespace musher::tree::nav2 {

class GoalWatch {
 public:
  explicit GoalWatch(Setup& setup)
      : goal_port_(setup.Input<Pose>("goal", FromEntry{"goal"}, "the goal")),
        goals_port_(
            setup.Input<Goals>("goals", FromEntry{"goals"}, "the goals, where it has several")) {}

  // Since the last call.
  bool HasChanged() {
    const bool one = Differs(goal_port_, goal_);
    const bool several = Differs(goals_port_, goals_);
    return one || several;
  }

 private:
  template <class T>
  static bool Differs(const InPort<T>& port, std::optional<T>& known) {
    const T* value = port.Find();
    if (value == nullptr ? !known : known == *value) return false;
    if (value == nullptr) {
      known.reset();
    } else {
      known = *value;
    }
    return true;
  }

  InPort<Pose> goal_port_;
  InPort<Goals> goals_port_;
  std::optional<Pose> goal_;
  std::optional<Goals> goals_;
};

}  // namespace musher::tree::nav2
