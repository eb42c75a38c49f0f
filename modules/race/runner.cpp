#include "musher/modules/race/runner.hpp"

#include <algorithm>

namespace musher::race {

Runner::Runner(const Course& course, RaceOutputs& outputs)
    : course_(course),
      outputs_(outputs),
      memory_(course),
      perception_(course, outputs),
      locomotion_(course, outputs),
      lane_walker_(course, outputs),
      voice_(course, outputs),
      state_(course.start),
      previous_(course.start) {
  if (course.light) light_.emplace(*course.light);
}

void Runner::Enter(Index state, bool by_decision, Duration now) {
  const bool back = by_decision && returns_ && interrupted_ && interrupted_->state == state;
  const bool begins = by_decision && state_ == course_.start;
  light_stops_ = returns_ = skips_ = false;
  unknown_.clear();
  if (back) {
    const Interrupted interrupted = *std::exchange(interrupted_, std::nullopt);
    state_ = state;
    previous_ = interrupted.previous;
    at_ = interrupted.activity;
    locomotion_.Continue(interrupted.walk);
    light_->Continue(now);
    return;
  }
  if (begins) {
    memory_.BeginRun();
    reason_.clear();
    if (light_) light_->Reset();
  }
  if (!by_decision || state == course_.error || begins) interrupted_.reset();
  previous_ = state_;
  state_ = state;
  at_ = {};
  at_.since = now;
  if (state == course_.end) memory_.Complete();
}

void Runner::Leave() {
  static_cast<void>(locomotion_.Stop());
  lane_walker_.Stop();
  voice_.Stop();
  if (light_) light_->Interrupt();
}

void Runner::SkipSteps() {
  Leave();
  skips_ = true;
}

void Runner::Pause() {
  locomotion_.Pause();
  lane_walker_.Pause();
  voice_.Pause();
  perception_.Close();
  if (light_) light_->Interrupt();
}

void Runner::Resume(Duration now) {
  const bool under_way = !idle() && state_ != course_.error && at_.step < rule().steps.size();
  locomotion_.Resume(under_way, now);
}

std::optional<Index> Runner::Advance(Duration now, Time time, bool held) {
  perception_.BeginTick();
  std::optional<Index> next;
  locomotion_.ExpireCall(now);
  if (!held) next = RunSteps(now, time);
  const std::optional<Index> silent = perception_.EndTick(now);
  if (next || !silent) return next;
  return Fail("no sample of the detector " + course_.detectors[*silent].name + " for " +
              std::to_string(ToMilliseconds(course_.check.silent)) +
              " ms: its camera or the detector is lost");
}

std::optional<Index> Runner::RunSteps(Duration now, Time time) {
  if (skips_) {
    if (locomotion_.busy()) return std::nullopt;
    at_.step = rule().steps.size();
  }
  if (locomotion_.standing_up()) {
    const bool stands = locomotion_.AdvanceStanding(now);
    if (const auto fault = locomotion_.Fault(now)) return Fail(*fault);
    if (!stands) return std::nullopt;
    at_.after = std::max(at_.after, time + course_.check.settle);
  }
  while (at_.step < rule().steps.size()) {
    fault_.clear();
    const Outcome outcome =
        std::visit([&](const auto& step) { return Run(step, now, time); }, rule().steps[at_.step]);
    if (!fault_.empty()) return Fail(fault_);
    if (const auto fault = locomotion_.Fault(now)) return Fail(*fault);
    if (outcome == Outcome::kTarget) return target_;
    if (outcome == Outcome::kRunning) return std::nullopt;
    at_ = {.step = at_.step + 1, .phase = 0, .since = now, .after = {}, .tries = 0};
    if (outcome == Outcome::kDone) return std::nullopt;  // a new stream begins in the next tick
  }
  if (idle() || state_ == course_.error) return std::nullopt;
  return ChooseTransition();
}

// In the error state itself a fault only drops the step: it has nowhere else to go.
std::optional<Index> Runner::Fail(const std::string& reason) {
  Say(reason);
  if (state_ == course_.error) {
    Leave();
    ++at_.step;
    at_.phase = 0;
    return std::nullopt;
  }
  reason_ = rule().name + ": " + reason;
  return rule().on_fault;
}

bool Runner::Holds(const TransitionRule& transition) const {
  if (transition.result && memory_.Value(*transition.result) != transition.is) return false;
  if (!transition.from.empty() &&
      std::ranges::find(transition.from, previous_) == transition.from.end())
    return false;
  if (!transition.counter) return true;
  const int count = memory_.Count(*transition.counter);
  return (!transition.below || count < *transition.below) &&
         (!transition.at_least || count >= *transition.at_least);
}

std::optional<Index> Runner::ChooseTransition() {
  for (const TransitionRule& transition : rule().transitions) {
    if (!Holds(transition)) continue;
    if (transition.to != kInterrupted) return transition.to;
    if (!interrupted_) return Fail("no movement was interrupted, to which it could go back");
    returns_ = true;
    return interrupted_->state;
  }
  std::string known;
  for (const TransitionRule& transition : rule().transitions) {
    if (!transition.result) continue;
    const std::string& name = course_.results[*transition.result].name;
    if (known.find(name) == std::string::npos) {
      known += (known.empty() ? ": " : ", ") + name + " is " + memory_.Text(*transition.result);
    }
  }
  return Fail("none of its transitions can be taken" + known);
}

}  // namespace musher::race
