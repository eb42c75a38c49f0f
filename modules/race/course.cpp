#include "musher/modules/race/course.hpp"

#include <algorithm>
#include <cctype>

namespace musher::race {
namespace {

constexpr std::array<std::string_view, 5> kLineWords{"left", "right", "front", "back", "center"};

int MostSteps(const Corrections& corrections) {
  int most = 0;
  for (const auto& correction : corrections) {
    if (correction) most = std::max(most, correction->count);
  }
  return most;
}

class Stay {
 public:
  explicit Stay(const Course& course) : course_(course) {}

  Duration operator()(const MoveStep& step) const {
    const Movement& movement = course_.movements[step.movement];
    if (movement.walks) return Walk(step.count);
    return movement.before + movement.limit + movement.after;
  }
  Duration operator()(const CheckStep& step) const {
    const Check& check = course_.checks[step.check];
    const CheckRules& rules = course_.check;
    const int most = std::max(MostSteps(check.usual), MostSteps(check.after_turn));
    const Duration look = rules.settle + rules.picture;
    const Duration stay =
        look + check.max_corrections.value_or(rules.max_corrections) * (look + Walk(most));
    if (!rules.step_back || check.required) return stay;
    return stay + look + Walk(rules.step_back->away.count) + Walk(rules.step_back->back.count);
  }
  Duration operator()(const WaitStep& step) const {
    const Wait& wait = course_.waits[step.wait];
    return wait.limit + wait.retries * (wait.limit + Walk(wait.retry.count));
  }
  Duration operator()(const UntilStep& step) const {
    return step.most.value_or(course_.untils[step.until].most.count) * course_.step +
           kLongestHidden;
  }
  Duration operator()(const WalkStep& step) const {
    const LaneWalk& walk = course_.walks[step.walk];
    return walk.limit + walk.retries * (walk.retry_after + kStopGrace);
  }
  Duration operator()(const SayStep& step) const {
    return std::max(Said(step.speech), Said(step.unsure.value_or(step.speech)));
  }
  Duration operator()(const CountStep& /*step*/) const { return Duration(0); }

 private:
  // At most, where odometry shows less than its steps.
  Duration Walk(int steps) const {
    const double share = course_.odometry.used() ? course_.odometry.most_share : 1;
    return std::chrono::duration_cast<Duration>(steps * course_.step * share);
  }
  Duration Said(Index index) const {
    const Speech& speech = course_.speeches[index];
    return std::max(speech.limit, static_cast<int>(speech.phrases.size()) * speech.every);
  }

  const Course& course_;
};

}  // namespace

bool SameWord(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

std::optional<LineWord> LineWordOf(std::string_view word) {
  const auto* found = std::ranges::find_if(
      kLineWords, [word](std::string_view known) { return SameWord(known, word); });
  if (found == kLineWords.end()) return std::nullopt;
  return static_cast<LineWord>(found - kLineWords.begin());
}

std::string_view Name(LineWord word) {
  return kLineWords[static_cast<std::size_t>(word)];
}

Duration LongestStay(const Course& course, Index state) {
  Duration stay{};
  for (const Step& step : course.states[state].steps) stay += std::visit(Stay(course), step);
  return stay;
}

std::vector<Index> Successors(const Course& course, Index state, bool back) {
  const StateRule& rule = course.states[state];
  std::vector<Index> all;
  const auto add = [&all](Index target) {
    if (std::ranges::find(all, target) == all.end()) all.push_back(target);
  };
  const auto add_otherwise = [&](const Otherwise& otherwise) {
    if (otherwise.kind == Otherwise::Kind::kState) add(otherwise.state);
  };
  for (const TransitionRule& transition : rule.transitions) {
    if (transition.to != kInterrupted) {
      add(transition.to);
      continue;
    }
    for (Index i = 0; back && i < course.states.size(); ++i) {
      if (course.states[i].light) add(i);
    }
  }
  for (const Step& step : rule.steps) {
    if (const auto* wait = std::get_if<WaitStep>(&step)) {
      add_otherwise(course.waits[wait->wait].otherwise);
    } else if (const auto* until = std::get_if<UntilStep>(&step)) {
      add_otherwise(course.untils[until->until].otherwise);
    } else if (const auto* walk = std::get_if<WalkStep>(&step)) {
      add_otherwise(course.walks[walk->walk].otherwise);
    }
  }
  if (rule.light && course.light) add(course.light->state);
  const bool can_fail = state != course.error && state != course.end && state != course.start;
  if (can_fail) add(rule.on_fault);
  return all;
}

}  // namespace musher::race
