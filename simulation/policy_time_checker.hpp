#pragma once
// Checks what the policy does by time, by the clock that it follows.
//
// Invariants: kNotBeforeItsTime.

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "musher/simulation/subject_checker.hpp"

namespace musher::simulation {

class PolicyTimeChecker : public SubjectChecker {
 public:
  explicit PolicyTimeChecker(CheckerContext& context) : SubjectChecker(context) {}

  // A sample of /clock.
  void OnClock(Time time);
  // A sample of the body is published.
  void OnMotion(std::int32_t motion);
  void NotePolicyTimes(const SimulatedController& controller);
  void CheckPolicyTime(const SimulatedController& controller, const action::Record& record);

 private:
  struct Mark {
    Time at{};            // of the network
    Duration by_clock{};  // the least that the policy's clock may have shown then
    Time sampled{};       // when the sample of /clock with that time was published
  };
  struct Seen {  // of a controller
    // Since when, by the policy's clock, the machine is in Active or Protected, and is kept.
    std::optional<Mark> awake;
    std::optional<Mark> kept;
    std::int64_t kept_for_s = 0;
  };

  Duration PolicyTime() const;
  Mark MarkNow() const;
  bool JustMoved() const;
  static std::optional<Mark> LaterOf(const std::optional<Mark>& a, const std::optional<Mark>& b);
  void CheckWaited(const SimulatedController& controller, const std::optional<Mark>& since,
                   Duration limit, const std::string& what);

  std::map<std::uint64_t, Seen> seen_;  // by the serial of the controller
  // /clock, without its jumps: so much of it has passed at each of the last samples.
  Duration clock_passed_{};
  Duration clock_step_{};
  std::optional<Time> clock_;
  std::deque<std::pair<Time, Duration>> clock_samples_;  // when
  std::optional<Mark> still_;  // since when the body lies still, by its samples
  std::optional<Mark> still_before_;
  std::optional<Time> moved_at_;  // when it moved after that
};

}  // namespace musher::simulation
