#pragma once
// What a run has found so far: results, counters, and what it is not sure of. One thread.

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/race/course.hpp"

namespace musher::race {

// The race went on although a check was given up, a sight was not found, or the like.
struct Reservation {
  std::string state;
  std::string reason;

  std::string Text() const { return state + ": " + reason; }
};

class Memory {
 public:
  explicit Memory(const Course& course)
      : course_(course),
        results_(course.results.size()),
        counters_(course.counters.size()),
        missed_(course.untils.size()) {}

  // The index of the result's value; nothing: not known.
  std::optional<Index> Value(Index result) const { return results_[result].value; }
  // Its text; "None" where it is not known.
  std::string Text(Index result) const {
    const auto value = Value(result);
    return value ? course_.results[result].values[*value] : "None";
  }
  void Set(Index result, Index value, bool by_command = false) {
    results_[result] = {value, by_command, false};
    if (course_.results[result].shown) shown_ = result;
  }
  // Its default, as it was not found.
  void SetDefault(Index result) {
    Set(result, *course_.results[result].by_default);
    results_[result].by_default = true;
  }
  bool IsDefault(Index result) const { return results_[result].by_default; }
  // The last one that state_info shows.
  std::string Shown() const { return shown_ ? Text(*shown_) : "None"; }

  int Count(Index counter) const { return counters_[counter]; }
  void SetCount(Index counter, int count) {
    counters_[counter] = std::clamp(count, 0, 10 * kMostSteps);
  }

  // Whether the last walk until this sight has ended without it.
  bool Missed(Index until) const { return missed_[until]; }
  void SetMissed(Index until, bool missed) { missed_[until] = missed; }

  // The first kMostKept of them and the last one.
  const std::vector<Reservation>& reservations() const { return reservations_; }
  std::size_t reserved() const { return reserved_; }
  void Reserve(Reservation reservation) {
    if (reservations_.size() > kMostKept) reservations_.pop_back();
    reservations_.push_back(std::move(reservation));
    ++reserved_;
  }
  // Checks that were given up.
  int given_up() const { return given_up_; }
  void GiveUpCheck() { ++given_up_; }

  bool completed() const { return completed_; }
  void SetCompleted(bool completed) { completed_ = completed; }

  // Results, counters, reservations and completion.
  void Forget() { *this = Memory(course_); }
  // A new run: what a command has set stays.
  void BeginRun() {
    shown_.reset();
    for (Index i = 0; i < results_.size(); ++i) {
      if (!results_[i].by_command) results_[i] = {};
      if (results_[i].value && course_.results[i].shown) shown_ = i;
    }
    std::ranges::fill(counters_, 0);
    missed_.assign(missed_.size(), false);
    reservations_.clear();
    reserved_ = 0;
    given_up_ = 0;
  }

  Memory(const Memory&) = default;
  Memory& operator=(const Memory& other) {
    results_ = other.results_;
    counters_ = other.counters_;
    shown_ = other.shown_;
    completed_ = other.completed_;
    missed_ = other.missed_;
    reservations_ = other.reservations_;
    reserved_ = other.reserved_;
    given_up_ = other.given_up_;
    return *this;
  }
  ~Memory() = default;

 private:
  static constexpr std::size_t kMostKept = 100;

  struct Known {
    std::optional<Index> value;
    bool by_command = false;
    bool by_default = false;
  };

  const Course& course_;
  std::vector<Known> results_;
  std::vector<int> counters_;
  std::optional<Index> shown_;
  bool completed_ = false;
  std::vector<bool> missed_;  // by until
  std::vector<Reservation> reservations_;
  std::size_t reserved_ = 0;
  int given_up_ = 0;
};

}  // namespace musher::race
