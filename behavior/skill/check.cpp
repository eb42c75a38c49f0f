#include "musher/behavior/skill/check.hpp"

#include <utility>

#include "musher/behavior/fsm/reach.hpp"

namespace musher::skill {
namespace {

class TableCheck {
 public:
  explicit TableCheck(const Table& table) : table_(table), chart_(table.chart()) {}

  std::vector<Problem> Run() && {
    for (const std::string& error : table_.errors()) {
      problems_.push_back({Severity::kError, "", error});
    }
    if (table_.first() == kIdle) {
      problems_.push_back({Severity::kError, "", "declares no state"});
      return std::move(problems_);
    }
    fsm::Marks reached(chart_.states.size());
    reached[fsm::Index(kIdle)] = true;
    fsm::Spread(chart_.transitions, reached, false);
    fsm::Marks ends(chart_.states.size());
    for (const StateId end : {kSucceeded, kFailed, kCancelled}) ends[fsm::Index(end)] = true;
    fsm::Spread(chart_.transitions, ends, true);
    for (std::size_t i = 0; i < chart_.states.size(); ++i) {
      const auto state = static_cast<StateId>(i);
      if (!ends[i] && state != kIdle)
        Add(Severity::kError, i, "no declared transitions lead from it to an end");
      if (!reached[i] && !IsEnd(state)) Add(Severity::kWarning, i, "no transition leads to it");
      CheckTransitions(state);
    }
    if (!reached[fsm::Index(kSucceeded)]) {
      Add(Severity::kWarning, fsm::Index(kSucceeded),
          "no transition leads to it: it never succeeds");
    }
    return std::move(problems_);
  }

 private:
  void CheckTransitions(StateId from) {
    for (std::size_t i = 0; i < chart_.transitions.size(); ++i) {
      const fsm::ChartTransition& transition = chart_.transitions[i];
      if (transition.from != from) continue;
      const std::string to(table_.Name(transition.to));
      if (IsEnd(from)) {
        Add(Severity::kError, fsm::Index(from), "is an end, but declares a transition to " + to);
      } else if (from == kIdle && transition.to != table_.first()) {
        Add(Severity::kError, fsm::Index(from),
            "declares a transition to " + to + "; a run begins in the first state");
      } else if (transition.to == kIdle) {
        Add(Severity::kError, fsm::Index(from),
            "declares a transition to IDLE; a skill that has ended stays there until its reset");
      }
      if (fsm::IsRepeated(chart_, i)) {
        Add(Severity::kWarning, fsm::Index(from), "declares its transition to " + to + " twice");
      }
    }
  }

  void Add(Severity severity, std::size_t state, std::string what) {
    problems_.push_back({severity, chart_.states[state].name, std::move(what)});
  }

  const Table& table_;
  const fsm::Chart& chart_;
  std::vector<Problem> problems_;
};

}  // namespace

std::vector<Problem> Check(const Table& table) {
  return TableCheck(table).Run();
}

Result<> CheckErrors(const std::string& skill, const Table& table) {
  std::string errors;
  for (const Problem& problem : Check(table)) {
    if (problem.severity != Severity::kError) continue;
    errors += (errors.empty() ? "" : "\n") + skill + ": ";
    errors += (problem.where.empty() ? "" : problem.where + ": ") + problem.what;
  }
  if (errors.empty()) return Ok();
  return Error{kCodeFailed, errors};
}

}  // namespace musher::skill
