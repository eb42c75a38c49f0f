#include "musher/modules/race/course_state.hpp"

#include <algorithm>

namespace musher::race {

void Race::CourseState::Declare(fsm::Transitions& transitions) {
  const Course& course = race_.course_;
  start_ = transitions.On(command::kStart);
  stop_ = transitions.On(command::kStop);
  ids_.assign(course.states.size(), fsm::kNoState);
  const auto to = [&](Index state, const std::string& when) {
    ids_[state] = transitions.To(course.states[state].name, when);
  };
  const StateRule& rule = course.states[index_];
  for (const TransitionRule& transition : rule.transitions) {
    if (transition.to == kInterrupted) continue;
    to(transition.to, is_start() ? "the command START" : Condition(transition));
  }
  if (index_ == course.error) to(course.start, "the command STOP or RESET");
  for (const Index state : Successors(course, index_)) {
    if (ids_[state] != fsm::kNoState) continue;
    const bool fault = state == rule.on_fault;
    const bool light = rule.light && course.light && state == course.light->state;
    to(state, light ? "a yellow light" : fault ? "a fault" : "the interrupted movement");
  }
}

// What a person reads in the graph.
std::string Race::CourseState::Condition(const TransitionRule& transition) const {
  const Course& course = race_.course_;
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (transition.result) {
    const ResultRule& result = course.results[*transition.result];
    add(result.name + " is " + result.values[transition.is]);
  }
  for (const Index state : transition.from) add("from " + course.states[state].name);
  if (transition.counter) {
    const std::string& counter = course.counters[*transition.counter];
    if (transition.below) add(counter + " < " + std::to_string(*transition.below));
    if (transition.at_least) add(counter + " >= " + std::to_string(*transition.at_least));
  }
  return text.empty() ? "its steps are done" : text;
}

void Race::CourseState::OnEnter(const fsm::Tick& tick) {
  // A forced change has no source that leads here.
  race_.runner_.Enter(index_, race_.decided_, tick.now);
}

void Race::CourseState::OnExit(const fsm::Tick& /*tick*/) {
  race_.runner_.Leave();
}

fsm::Next Race::CourseState::Go(Index state) const {
  return fsm::Next::To(ids_[state]);
}

fsm::Next Race::CourseState::OnCommand(fsm::EventId command) {
  if (command == stop_) {
    race_.Stop();
  } else if (!race_.start_counts_) {
    race_.Refuse("START", "START is refused: a later command has stopped it");
  } else if (race_.waits_for_start()) {
    race_.GoOn();
  } else if (race_.memory().completed()) {
    race_.Refuse("START", "START is refused: the task is completed; send RESET before");
  } else if (!is_start()) {
    race_.Refuse("START", "START is refused in " + race_.course_.states[index_].name +
                              ": the race is under way; send STOP or RESET before");
  } else {
    return Go(race_.course_.states[index_].transitions[0].to);
  }
  return fsm::Next::Handle();
}

fsm::Next Race::CourseState::CheckTransition(const fsm::Tick& tick) {
  const bool held = race_.jump_.has_value() || race_.waits_for_start();
  if (tick.command != fsm::kNoEvent) {
    const fsm::Next next = OnCommand(tick.command);
    if (!next.stays()) return next;
    static_cast<void>(race_.runner_.Advance(tick.now, race_.now_, true));
    return next;
  }
  const auto target = race_.runner_.Advance(tick.now, race_.now_, held);
  return target ? Go(*target) : fsm::Next::Stay();
}

}  // namespace musher::race
