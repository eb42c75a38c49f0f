#include "musher/behavior/fsm/check.hpp"

#include <cstddef>
#include <utility>

#include "musher/behavior/fsm/reach.hpp"

namespace musher::fsm {
namespace {

class ChartCheck {
 public:
  explicit ChartCheck(const Chart& chart) : chart_(chart), leads_on_(chart.states.size()) {
    for (const ChartTransition& transition : chart_.transitions) {
      if (transition.from != transition.to) leads_on_[Index(transition.from)] = true;
    }
  }

  std::vector<Problem> Run() && {
    const Marks reached = Reached();
    const Marks dead = DeadEnds(reached);
    for (std::size_t i = 0; i < chart_.states.size(); ++i) {
      if (!reached[i]) Warn(i, "only Force() reaches it: no transition leads to it");
      if (dead[i]) {
        Fail(i, "is a dead end: it declares no transition out; make it final if it is the end");
      }
      if (chart_.states[i].role == Role::kSafe && !leads_on_[i]) {
        Warn(i, "declares no transition out: only a force or a reset ends a safe stop");
      }
      EvaluateWays(i);
      for (const Chart& inside : chart_.states[i].inside) Descend(i, inside);
    }
    EvaluateTraps(reached, dead);
    return std::move(problems_);
  }

 private:
  Marks Reached() const {
    Marks reached(chart_.states.size());
    for (std::size_t i = 0; i < reached.size(); ++i) {
      reached[i] = i == Index(chart_.start) || chart_.states[i].role == Role::kSafe;
    }
    Spread(chart_, reached, false);
    return reached;
  }

  // Not in a machine with one state, or one that starts in a final state.
  Marks DeadEnds(const Marks& reached) const {
    Marks dead(chart_.states.size());
    for (std::size_t i = 0; i < dead.size(); ++i) {
      dead[i] = reached[i] && !leads_on_[i] && i != Index(chart_.start) &&
                chart_.states[i].role == Role::kNormal;
    }
    return dead;
  }

  void EvaluateWays(std::size_t from) {
    for (std::size_t i = 0; i < chart_.transitions.size(); ++i) {
      const ChartTransition& transition = chart_.transitions[i];
      if (Index(transition.from) != from) continue;
      const std::string to = chart_.states[Index(transition.to)].name;
      if (chart_.states[from].role == Role::kFinal) {
        Fail(from, "is final, but declares a transition to " + to);
      }
      if (IsRepeated(chart_, i)) {
        Warn(from, "declares its transition to " + to + " twice");
      }
    }
  }

  // States from which neither the start, a safe nor a final state is reached. States that lead to a
  // dead end are not reported again.
  void EvaluateTraps(const Marks& reached, const Marks& dead) {
    Marks good = dead;
    for (std::size_t i = 0; i < good.size(); ++i) {
      if (i == Index(chart_.start) || chart_.states[i].role != Role::kNormal) good[i] = true;
    }
    Spread(chart_, good, true);
    std::string trapped;
    std::size_t first = good.size();
    for (std::size_t i = good.size(); i-- > 0;) {
      if (good[i] || !reached[i]) continue;
      trapped = chart_.states[i].name + (trapped.empty() ? "" : ", ") + trapped;
      first = i;
    }
    if (trapped.empty()) return;
    Fail(first, "is in a trap: from " + trapped + " nothing leads to " +
                    chart_.states[Index(chart_.start)].name +
                    ", to a safe state or to a final one");
  }

  void Descend(std::size_t state, const Chart& inside) {
    for (Problem& problem : Check(inside)) {
      problem.where = chart_.states[state].name + "/" + problem.where;
      problems_.push_back(std::move(problem));
    }
  }

  void Fail(std::size_t state, std::string what) {
    problems_.push_back({Severity::kError, chart_.states[state].name, std::move(what)});
  }
  void Warn(std::size_t state, std::string what) {
    problems_.push_back({Severity::kWarning, chart_.states[state].name, std::move(what)});
  }

  const Chart& chart_;
  Marks leads_on_;
  std::vector<Problem> problems_;
};

}  // namespace

std::vector<Problem> Check(const Chart& chart) {
  if (Index(chart.start) >= chart.states.size()) {
    return {{Severity::kError, chart.name, "has no start state"}};
  }
  return ChartCheck(chart).Run();
}

}  // namespace musher::fsm
