// The errors of a course's states: states that are not reached, have no outgoing transition, lead
// round without taking time, or lack a transition for a value; numbers that are not unique.

#include <algorithm>
#include <functional>
#include <map>
#include <string>

#include "musher/modules/race/course_parts.hpp"
#include "musher/modules/race/course_reader.hpp"

namespace musher::race {
namespace parts {
namespace {

constexpr std::size_t kMostCases = 100'000;  // of the conditions of one state

// Not so what may be skipped: the wait for a result that is known, a walk of which no step is left
// or whose sight was not found, the speech about a result that is not known or about such a sight.
bool TakesTime(const Course& course, const Step& step) {
  if (const auto* move = std::get_if<MoveStep>(&step)) return !move->less && !move->only;
  if (const auto* wait = std::get_if<WaitStep>(&step)) return !course.waits[wait->wait].detector;
  if (const auto* say = std::get_if<SayStep>(&step)) {
    const bool of_result = course.speeches[say->speech].result ||
                           course.speeches[say->unsure.value_or(say->speech)].result;
    return !of_result && !say->only;
  }
  return !std::holds_alternative<CountStep>(step);
}

// What the conditions of a state depend on.
struct Case {
  std::map<Index, Index> values;  // of a result
  std::map<Index, int> counters;
  Index from = 0;
};

bool Holds(const TransitionRule& transition, const Case& at) {
  if (transition.result && at.values.at(*transition.result) != transition.is) return false;
  if (!transition.from.empty() &&
      std::ranges::find(transition.from, at.from) == transition.from.end())
    return false;
  if (!transition.counter) return true;
  const int count = at.counters.at(*transition.counter);
  return (!transition.below || count < *transition.below) &&
         (!transition.at_least || count >= *transition.at_least);
}

class CourseCheck {
 public:
  explicit CourseCheck(Reading& reading) : reading_(reading), course_(reading.course) {}

  void Run() {
    CheckNumbers();
    if (reading_.has_ends && reading_.has_leads) CheckReached();
    for (Index state = 0; state < course_.states.size(); ++state) {
      if (reading_.has_ends) CheckOutgoing(state);
      if (reading_.places[state].has_all_transitions) CheckEachValueHasATransition(state);
      if (reading_.has_ends && reading_.has_leads) CheckFault(state);
      CheckLight(state);
    }
    CheckTimelessCycles();
  }

 private:
  const StateRule& At(Index state) const { return course_.states[state]; }
  void Fail(Position at, Index state, const std::string& what) {
    reading_.findings.Error(at, "state." + At(state).name + ": " + what);
  }
  bool IsEnd(Index state) const { return state == course_.end || state == course_.error; }
  // A state with errors counts as one that takes time.
  bool TakesTime(Index state) const {
    return !reading_.places[state].has_all_steps ||
           std::ranges::any_of(At(state).steps, [this](const Step& step) {
             return parts::TakesTime(course_, step);
           });
  }

  void CheckNumbers() {
    std::map<int, Index> first;
    for (Index i = 0; i < course_.states.size(); ++i) {
      if (!reading_.places[i].has_number) continue;
      const auto [found, is_new] = first.emplace(At(i).number, i);
      if (is_new) continue;
      Fail(reading_.places[i].at, i,
           "number " + std::to_string(At(i).number) + " is that of " + At(found->second).name +
               ", too");
    }
  }

  void CheckReached() {
    std::vector<bool> reached(course_.states.size());
    std::vector<Index> open = {course_.start, course_.error};
    for (const Index state : open) reached[state] = true;
    while (!open.empty()) {
      const Index state = open.back();
      open.pop_back();
      for (const Index next : Successors(course_, state, false)) {
        if (reached[next]) continue;
        reached[next] = true;
        open.push_back(next);
      }
    }
    for (Index i = 0; i < reached.size(); ++i) {
      if (!reached[i]) {
        Fail(reading_.places[i].at, i,
             "is unreachable: no transition leads to it from " + At(course_.start).name);
      }
    }
  }

  void CheckOutgoing(Index state) {
    if (IsEnd(state)) {
      if (At(state).transitions.empty()) return;
      return Fail(reading_.places[state].next, state,
                  "only a command leaves it: expected no \"next\"");
    }
    if (At(state).transitions.empty() && reading_.places[state].has_all_transitions) {
      return Fail(
          reading_.places[state].at, state,
          "has no outgoing transition: the key \"next\" is missing; expected the name of a state");
    }
    if (!reading_.places[state].has_all_transitions) return;
    const bool itself = std::ranges::all_of(
        At(state).transitions,
        [&](const TransitionRule& transition) { return transition.to == state; });
    if (itself)
      Fail(reading_.places[state].next, state,
           "has no outgoing transition: it leads to itself only");
    if (state != course_.start) return;
    if (At(state).transitions.size() != 1 || !At(state).transitions[0].always() ||
        !At(state).steps.empty()) {
      Fail(reading_.places[state].next, state,
           "is the start: expected no steps, and the name of one state as \"next\"");
    }
  }

  void CheckLight(Index state) {
    const bool back = std::ranges::any_of(
        At(state).transitions,
        [](const TransitionRule& transition) { return transition.to == kInterrupted; });
    if (back && !course_.light) {
      Fail(reading_.places[state].next, state,
           "\"back\" leads to the movement that a light has interrupted, and the course has no "
           "[light]");
    }
    const bool own = reading_.has_leads && course_.light && course_.light->state == state;
    if (own && At(state).light) {
      Fail(reading_.places[state].at, state,
           "light = true in the state of [light], which would interrupt itself");
    }
  }

  // The values of every condition in all combinations: one of the transitions holds in each.
  void CheckEachValueHasATransition(Index state) {
    const std::vector<TransitionRule>& transitions = At(state).transitions;
    for (std::size_t i = 0; i + 1 < transitions.size(); ++i) {
      if (!transitions[i].always()) continue;
      Fail(reading_.places[state].transitions[i + 1], state,
           "this transition is never taken: the one before it has no condition");
      return;
    }
    if (transitions.empty() || transitions.back().always()) return;
    for (const TransitionRule& transition : transitions) {
      const bool no_value = transition.result && course_.results[*transition.result].values.empty();
      if (no_value || (!transition.from.empty() && !reading_.has_leads)) return;
    }
    std::vector<Case> cases(1);
    for (const TransitionRule& transition : transitions) {
      if (transition.result && !cases.front().values.contains(*transition.result)) {
        Multiply(cases, course_.results[*transition.result].values.size(),
                 [&](Case& at, std::size_t value) { at.values[*transition.result] = value; });
      }
      if (transition.counter && !cases.front().counters.contains(*transition.counter)) {
        const std::vector<int> counts = Thresholds(transitions, *transition.counter);
        Multiply(cases, counts.size(),
                 [&](Case& at, std::size_t i) { at.counters[*transition.counter] = counts[i]; });
      }
    }
    const std::vector<Index> before = Predecessors(state);
    if (!before.empty()) {
      Multiply(cases, before.size(), [&](Case& at, std::size_t i) { at.from = before[i]; });
    }
    for (const Case& at : cases) {
      if (std::ranges::any_of(
              transitions, [&](const TransitionRule& transition) { return Holds(transition, at); }))
        continue;
      return Fail(reading_.places[state].next, state,
                  "has no transition in the case " + Text(at, transitions));
    }
  }

  static void Multiply(std::vector<Case>& cases, std::size_t size,
                       const std::function<void(Case&, std::size_t)>& set) {
    if (cases.size() * size > kMostCases) size = 1;
    std::vector<Case> all;
    for (const Case& at : cases) {
      for (std::size_t i = 0; i < size; ++i) {
        all.push_back(at);
        set(all.back(), i);
      }
    }
    cases = std::move(all);
  }

  // One number of each range that the transitions distinguish.
  static std::vector<int> Thresholds(const std::vector<TransitionRule>& transitions,
                                     Index counter) {
    std::vector<int> counts = {0};
    for (const TransitionRule& transition : transitions) {
      if (transition.counter != counter) continue;
      if (transition.below) counts.push_back(*transition.below);
      if (transition.at_least) counts.push_back(*transition.at_least);
    }
    return counts;
  }

  std::vector<Index> Predecessors(Index state) const {
    std::vector<Index> before;
    for (Index i = 0; i < course_.states.size(); ++i) {
      const std::vector<Index> next = Successors(course_, i, false);
      if (std::ranges::find(next, state) != next.end()) before.push_back(i);
    }
    return before;
  }

  std::string Text(const Case& at, const std::vector<TransitionRule>& transitions) const {
    std::string text;
    const auto add = [&text](const std::string& part) {
      text += (text.empty() ? "" : ", ") + part;
    };
    for (const auto& [result, value] : at.values) {
      add(course_.results[result].name + " = \"" + course_.results[result].values[value] + "\"");
    }
    for (const auto& [counter, count] : at.counters) {
      add(course_.counters[counter] + " = " + std::to_string(count));
    }
    if (std::ranges::any_of(transitions, [](const TransitionRule& transition) {
          return !transition.from.empty();
        })) {
      add("from = " + At(at.from).name);
    }
    return text;
  }

  // A fault leads to the error state in two states at most, whatever fails again.
  void CheckFault(Index state) {
    const Index target = At(state).on_fault;
    if (target == course_.error || At(target).on_fault == course_.error) return;
    Fail(reading_.places[state].on_fault, state,
         "on_fault: " + At(target).name + " has an on_fault of its own; expected a state whose " +
             "faults lead to " + At(course_.error).name);
  }

  void CheckTimelessCycles() {
    std::vector<int> marks(course_.states.size());  // 1: on the path, 2: done
    for (Index i = 0; i < marks.size(); ++i) Follow(i, marks);
  }
  void Follow(Index state, std::vector<int>& marks) {
    if (marks[state] != 0 || TakesTime(state) || state == course_.start) return;
    marks[state] = 1;
    for (const TransitionRule& transition : At(state).transitions) {
      if (transition.to == kInterrupted) continue;
      if (marks[transition.to] == 1) {
        Fail(reading_.places[state].next, state,
             "leads back to " + At(transition.to).name + " through states that may take no time");
      } else {
        Follow(transition.to, marks);
      }
    }
    marks[state] = 2;
  }

  Reading& reading_;
  const Course& course_;
};

}  // namespace

void CheckStates(Reading& reading) {
  CourseCheck(reading).Run();
}

}  // namespace parts

std::string Summary(const Course& course) {
  const auto count = [](std::size_t n, const char* thing) {
    return std::to_string(n) + " " + thing + (n == 1 ? "" : "s");
  };
  std::size_t steps = 0;
  Duration longest{};
  Index longest_state = 0;
  for (Index i = 0; i < course.states.size(); ++i) {
    steps += course.states[i].steps.size();
    const Duration stay = LongestStay(course, i);
    if (stay > longest) longest_state = i;
    longest = std::max(longest, stay);
  }
  std::string text = count(course.states.size(), "state") + " with " + count(steps, "step") + ", " +
                     count(course.movements.size(), "movement") + ", " +
                     count(course.checks.size(), "check") + ", " +
                     count(course.waits.size(), "wait") + ", " +
                     count(course.detectors.size(), "detector") + "\n";
  text += "from " + course.states[course.start].name + " to " + course.states[course.end].name +
          "; faults lead to " + course.states[course.error].name + "\n";
  text += "the longest stay: " + course.states[longest_state].name + ", at most " +
          std::to_string(ToMilliseconds(longest) / 1000) + " s";
  return text;
}

}  // namespace musher::race
