#pragma once
// What a run has found so far: results and counters. One thread.

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/race/course.hpp"

namespace musher::race {

class Memory {
 public:
  explicit Memory(const Course& course)
      : course_(course), results_(course.results.size()), counters_(course.counters.size()) {}

  // The index of the result's value; nothing: not known.
  std::optional<Index> Value(Index result) const { return results_[result].value; }
  // Its text; "None" where it is not known.
  std::string Text(Index result) const {
    const auto value = Value(result);
    return value ? course_.results[result].values[*value] : "None";
  }
  void Set(Index result, Index value, bool by_command = false) {
    results_[result] = {value, by_command};
    if (course_.results[result].shown) shown_ = result;
  }
  // The last one that state_info shows.
  std::string Shown() const { return shown_ ? Text(*shown_) : "None"; }

  int Count(Index counter) const { return counters_[counter]; }
  void SetCount(Index counter, int count) {
    counters_[counter] = std::clamp(count, 0, 10 * kMostSteps);
  }

  bool completed() const { return completed_; }
  void Complete() { completed_ = true; }

  // Results, counters and completion.
  void Forget() { *this = Memory(course_); }
  // A new run: what a command has set stays.
  void BeginRun() {
    shown_.reset();
    for (Index i = 0; i < results_.size(); ++i) {
      if (!results_[i].by_command) results_[i] = {};
      if (results_[i].value && course_.results[i].shown) shown_ = i;
    }
    std::ranges::fill(counters_, 0);
  }

  Memory(const Memory&) = default;
  Memory& operator=(const Memory& other) {
    results_ = other.results_;
    counters_ = other.counters_;
    shown_ = other.shown_;
    completed_ = other.completed_;
    return *this;
  }
  ~Memory() = default;

 private:
  struct Known {
    std::optional<Index> value;
    bool by_command = false;
  };

  const Course& course_;
  std::vector<Known> results_;
  std::vector<int> counters_;
  std::optional<Index> shown_;
  bool completed_ = false;
};

}  // namespace musher::race
