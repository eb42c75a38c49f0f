#include "musher/lifecycle/config/user_rules.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "musher/base/suggest.hpp"

namespace musher {
namespace {

constexpr const char* kForm =
    "expected 'never ACTUATOR STATE', 'never ACTUATOR STATE while ACTUATOR is [not] STATE', or "
    "'within TIME of STATE ACTUATOR in STATE [or STATE …]'";
constexpr const char* kTimedForm =
    "expected 'within TIME of STATE ACTUATOR in STATE [or STATE …]', where TIME is such as 5 s";
constexpr std::string_view kWithin = "within";
constexpr Duration kShortestWithin = Milliseconds(1);
constexpr Duration kLongestWithin = std::chrono::hours(24);

struct TimeUnit {
  std::string_view name;
  Duration unit;
};
constexpr std::array<TimeUnit, 3> kTimeUnits = {{{"ms", std::chrono::milliseconds(1)},
                                                 {"s", std::chrono::seconds(1)},
                                                 {"min", std::chrono::minutes(1)}}};

constexpr std::string_view kMachine = "machine";
constexpr std::string_view kTwoMachines =
    "'machine' means the state of the machine, and an actuator has this name, too; a rule cannot "
    "name that one";
constexpr std::string_view kExited = "exited";

struct LineWord {
  std::string text;
  int column = 1;
};

std::vector<LineWord> WordsOf(std::string_view line) {
  std::vector<LineWord> words;
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t\r", i);
    if (begin == std::string_view::npos || line[begin] == '#') break;
    const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
    words.push_back({std::string(line.substr(begin, end - begin)), static_cast<int>(begin) + 1});
    i = end;
  }
  return words;
}

// Reads the words of one line. The first error of a line counts.
class LineReader {
 public:
  LineReader(const MachineConfig& config, std::string_view line)
      : config_(config),
        words_(WordsOf(line)),
        end_column_(static_cast<int>(line.size()) + 1),
        form_(IsTimed() ? kTimedForm : kForm) {}

  bool IsBlank() const { return words_.empty(); }
  bool IsTimed() const { return !words_.empty() && words_.front().text == kWithin; }
  const std::string& error() const { return error_; }
  int column() const { return column_; }

  TimedRule ReadTimed(int line) {
    TimedRule rule;
    rule.text = Text();
    rule.line = line;
    Take(std::string(kWithin));
    rule.within = TakeTime();
    Take("of");
    rule.of = TakeState(std::nullopt);
    rule.subject = TakeSubject();
    Take("in");
    rule.states.push_back(TakeState(rule.subject));
    while (next_ < words_.size() && error_.empty()) {
      Take("or");
      rule.states.push_back(TakeState(rule.subject));
    }
    return rule;
  }

  StableRule ReadStable() {
    StableRule rule;
    rule.text = Text();
    Take("never");
    rule.never.actuator = TakeSubject();
    rule.never.state = TakeState(rule.never.actuator);
    if (next_ == words_.size() || !error_.empty()) return rule;
    Take("while");
    StableRule::Place condition;
    condition.actuator = TakeSubject();
    Take("is");
    if (next_ < words_.size() && words_[next_].text == "not") {
      rule.condition_negated = true;
      ++next_;
    }
    condition.state = TakeState(condition.actuator);
    rule.condition = std::move(condition);
    if (next_ < words_.size()) Fail(words_[next_].column, form_);
    return rule;
  }

 private:
  std::string Text() const {
    std::string text;
    for (const LineWord& word : words_) text += (text.empty() ? "" : " ") + word.text;
    return text;
  }

  void Fail(int column, const std::string& error) {
    if (!error_.empty()) return;
    error_ = error;
    column_ = column;
  }

  const LineWord* Next() {
    if (!error_.empty()) return nullptr;
    if (next_ < words_.size()) return &words_[next_++];
    Fail(end_column_, form_);
    return nullptr;
  }

  void Take(const std::string& expected) {
    const LineWord* word = Next();
    if (word != nullptr && word->text != expected) Fail(word->column, form_);
  }

  // "5 s"
  Duration TakeTime() {
    const LineWord* number = Next();
    const LineWord* unit = Next();
    if (number == nullptr || unit == nullptr) return {};
    const std::string& text = number->text;
    double value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size()) {
      Fail(number->column,
           "expected a time such as 5 s, found '" + text.substr(0, kLongestWord) + "'");
      return {};
    }
    const auto known = std::ranges::find(kTimeUnits, unit->text, &TimeUnit::name);
    if (known == kTimeUnits.end()) {
      Fail(unit->column, "there is no unit '" + unit->text.substr(0, kLongestWord) +
                             "' of a time; use ms, s or min");
      return {};
    }
    const double ns = value * static_cast<double>(known->unit.count());
    if (ns >= static_cast<double>(kShortestWithin.count()) &&
        ns <= static_cast<double>(kLongestWithin.count())) {
      return Duration(static_cast<std::int64_t>(ns));
    }
    Fail(number->column, "expected a time from 1 ms to 1440 min, found '" +
                             text.substr(0, kLongestWord) + " " + unit->text + "'");
    return {};
  }

  std::optional<ActuatorIndex> TakeSubject() {
    const LineWord* word = Next();
    if (word == nullptr) return std::nullopt;
    const auto actuator = config_.IndexOf(word->text);
    if (word->text == kMachine) {
      if (actuator) Fail(word->column, std::string(kTwoMachines));
      return std::nullopt;
    }
    if (!actuator) Fail(word->column, UnknownActuator(word->text, config_).message);
    return actuator;
  }

  // Takes a state that the machine, or the actuator, can be in. Empty for "exited".
  State TakeState(std::optional<ActuatorIndex> actuator) {
    const LineWord* word = Next();
    if (word == nullptr || (actuator && word->text == kExited)) return {};
    std::vector<State> states = actuator ? config_.actuators[*actuator].states : config_.states;
    const std::string subject = actuator ? config_.actuators[*actuator].name : "the machine";
    if (std::find(states.begin(), states.end(), word->text) == states.end()) {
      if (actuator) states.emplace_back(kExited);
      Fail(word->column, subject + " has no state '" + word->text.substr(0, kLongestWord) + "'" +
                             DidYouMean(word->text, states));
    }
    return State(word->text);
  }

  const MachineConfig& config_;
  const std::vector<LineWord> words_;
  const int end_column_;
  const std::string form_;
  std::size_t next_ = 0;
  std::string error_;
  int column_ = 0;
};

}  // namespace

bool TimedRule::IsMetIn(const State& state) const {
  return std::find(states.begin(), states.end(), state) != states.end();
}

RuleCoverage& RuleCoverage::operator+=(const RuleCoverage& other) {
  states += other.states;
  condition += other.condition;
  forbidden += other.forbidden;
  return *this;
}

TimedRuleCoverage& TimedRuleCoverage::operator+=(const TimedRuleCoverage& other) {
  begun += other.begun;
  met += other.met;
  return *this;
}

UserRulesCoverage& UserRulesCoverage::operator+=(const UserRulesCoverage& other) {
  stable.resize(std::max(stable.size(), other.stable.size()));
  timed.resize(std::max(timed.size(), other.timed.size()));
  for (std::size_t i = 0; i < other.stable.size(); ++i) stable[i] += other.stable[i];
  for (std::size_t i = 0; i < other.timed.size(); ++i) timed[i] += other.timed[i];
  return *this;
}

bool StableRule::IsForbidden(const StateOf& state_of) const {
  return state_of(never.actuator) == never.state;
}

bool StableRule::HasCondition(const StateOf& state_of) const {
  if (!condition) return true;
  return (state_of(condition->actuator) == condition->state) != condition_negated;
}

bool StableRule::IsViolated(const StateOf& state_of) const {
  return IsForbidden(state_of) && HasCondition(state_of);
}

bool StableRule::IsViolated(const StateOf& state_of, RuleCoverage& coverage) const {
  const bool forbidden = IsForbidden(state_of);
  const bool has_condition = HasCondition(state_of);
  coverage += RuleCoverage{1, has_condition ? 1U : 0U, forbidden ? 1U : 0U};
  return forbidden && has_condition;
}

UserRulesReading ReadUserRules(const MachineConfig& config, const std::string& file,
                               std::string_view text) {
  UserRulesReading read;
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    LineReader line(config, text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (line.IsBlank()) continue;
    if (line.IsTimed()) {
      TimedRule rule = line.ReadTimed(number);
      if (line.error().empty()) read.rules.timed.push_back(std::move(rule));
    } else {
      StableRule rule = line.ReadStable();
      if (line.error().empty()) read.rules.stable.push_back(std::move(rule));
    }
    if (!line.error().empty()) {
      read.diagnostics.push_back({file, number, line.column(), Severity::kError, line.error()});
    }
  }
  return read;
}

}  // namespace musher
