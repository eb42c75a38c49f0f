#include "musher/behavior/fsm/check.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "musher/behavior/fsm/reach.hpp"

namespace musher::fsm {
namespace {

// What the transitions between machines mean for the chart of one of them.
struct Crossing {
  std::vector<ChartTransition> across;  // between two of its states, or from inside of one
  std::vector<StateId> left;            // states with a transition out of the machine
  std::vector<StateId> entered;         // states with one from outside of the machine
};
struct Crossings {
  std::map<const Chart*, Crossing> of;
  std::set<std::string> handled;  // events that a state declares to handle
};

class CrossingSearch {
 public:
  CrossingSearch(const Chart& outermost, std::string_view place)
      : outermost_(outermost), place_(place.empty() ? "" : std::string(place) + "/") {}

  Crossings Run() && {
    Search(outermost_);
    return std::move(crossings_);
  }

 private:
  void Search(const Chart& chart) {
    for (const ChartTransition& transition : chart.transitions) {
      if (!transition.target.empty()) Cross(chart, transition);
    }
    for (std::size_t i = 0; i < chart.states.size(); ++i) {
      const std::vector<std::string>& handles = chart.states[i].handles;
      crossings_.handled.insert(handles.begin(), handles.end());
      for (const Chart& inside : chart.states[i].inside) {
        around_.push_back({&chart, static_cast<StateId>(i)});
        Search(inside);
        around_.pop_back();
      }
    }
  }

  void Cross(const Chart& chart, const ChartTransition& transition) {
    std::vector<ChartState> from = around_;
    from.push_back({&chart, transition.from});
    std::vector<ChartState> to;  // empty: around the checked machine
    if (transition.target.starts_with(place_)) {
      to = FindPath(outermost_, std::string_view(transition.target).substr(place_.size()));
    }
    for (std::size_t i = 0; i < from.size(); ++i) {
      const bool common = i < to.size() && from[i].chart == to[i].chart;
      if (!common) crossings_.of[from[i].chart].left.push_back(from[i].state);
    }
    for (std::size_t i = 0; i < to.size(); ++i) {
      Crossing& crossing = crossings_.of[to[i].chart];
      if (i >= from.size() || from[i].chart != to[i].chart) {
        crossing.entered.push_back(to[i].state);
      } else if (i + 1 >= from.size() || i + 1 >= to.size() ||
                 from[i + 1].chart != to[i + 1].chart) {
        crossing.across.push_back({from[i].state, to[i].state, transition.when});
      }
    }
  }

  const Chart& outermost_;
  const std::string place_;
  std::vector<ChartState> around_;  // the states around the chart that is searched
  Crossings crossings_;
};

class ChartCheck {
 public:
  ChartCheck(const Chart& chart, const Crossings& crossings)
      : chart_(chart), crossings_(crossings), leads_on_(chart.states.size()) {
    if (const auto found = crossings_.of.find(&chart_); found != crossings_.of.end()) {
      crossing_ = found->second;
    }
    for (const ChartTransition& transition : chart_.transitions) {
      if (transition.to != kNoState) crossing_.across.push_back(transition);
    }
    for (const ChartTransition& transition : crossing_.across) {
      if (transition.from != transition.to) leads_on_[Index(transition.from)] = true;
    }
    for (const StateId state : crossing_.left) leads_on_[Index(state)] = true;
  }

  std::vector<Problem> Run() && {
    if (Index(chart_.start) >= chart_.states.size()) {
      return {{Severity::kError, chart_.name, "has no start state"}};
    }
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
      EvaluateDeferrals(i);
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
    for (const StateId state : crossing_.entered) reached[Index(state)] = true;
    Spread(crossing_.across, reached, false);
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
      const std::string to =
          transition.target.empty() ? chart_.states[Index(transition.to)].name : transition.target;
      if (chart_.states[from].role == Role::kFinal) {
        Fail(from, "is final, but declares a transition to " + to);
      }
      if (IsRepeated(chart_, i)) {
        Warn(from, "declares its transition to " + to + " twice");
      }
    }
  }

  void EvaluateDeferrals(std::size_t state) {
    const Chart::Node& node = chart_.states[state];
    for (const std::string& event : node.defers) {
      if (std::ranges::find(node.handles, event) != node.handles.end()) {
        Fail(state, "both handles and defers " + event);
      } else if (!crossings_.handled.contains(event)) {
        Warn(state, "defers " + event + ", which no state declares to handle");
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
    for (const StateId state : crossing_.left) good[Index(state)] = true;
    Spread(crossing_.across, good, true);
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
    for (Problem& problem : ChartCheck(inside, crossings_).Run()) {
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
  const Crossings& crossings_;
  Crossing crossing_;  // of this chart
  Marks leads_on_;
  std::vector<Problem> problems_;
};

}  // namespace

std::vector<Problem> Check(const Chart& chart, std::string_view place) {
  const Crossings crossings = CrossingSearch(chart, place).Run();
  return ChartCheck(chart, crossings).Run();
}

}  // namespace musher::fsm
