#include "musher/lifecycle/config/stable_rule.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/suggest.hpp"

namespace musher {
namespace {

constexpr std::string_view kForm =
    "expected 'never ACTUATOR STATE', or 'never ACTUATOR STATE while ACTUATOR is [not] STATE'";
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

// Reads the words of one line, the first error of which counts.
class LineReader {
 public:
  LineReader(const MachineConfig& config, std::string_view line)
      : config_(config), words_(WordsOf(line)), end_column_(static_cast<int>(line.size()) + 1) {}

  bool IsBlank() const { return words_.empty(); }
  const std::string& error() const { return error_; }
  int column() const { return column_; }

  StableRule Read() {
    StableRule rule;
    for (const LineWord& word : words_) rule.text += (rule.text.empty() ? "" : " ") + word.text;
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
    if (next_ < words_.size()) Fail(words_[next_].column, std::string(kForm));
    return rule;
  }

 private:
  void Fail(int column, const std::string& error) {
    if (!error_.empty()) return;
    error_ = error;
    column_ = column;
  }

  const LineWord* Next() {
    if (!error_.empty()) return nullptr;
    if (next_ < words_.size()) return &words_[next_++];
    Fail(end_column_, std::string(kForm));
    return nullptr;
  }

  void Take(const std::string& expected) {
    const LineWord* word = Next();
    if (word != nullptr && word->text != expected) Fail(word->column, std::string(kForm));
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

  // One that the machine, or the actuator, can be in; "exited": none.
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
  std::size_t next_ = 0;
  std::string error_;
  int column_ = 0;
};

}  // namespace

bool StableRule::IsViolated(
    const std::function<State(std::optional<ActuatorIndex>)>& state_of) const {
  if (state_of(never.actuator) != never.state) return false;
  if (!condition) return true;
  return (state_of(condition->actuator) == condition->state) != condition_negated;
}

StableRules ReadStableRules(const MachineConfig& config, const std::string& file,
                            std::string_view text) {
  StableRules read;
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    LineReader line(config, text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (line.IsBlank()) continue;
    StableRule rule = line.Read();
    if (line.error().empty()) {
      read.rules.push_back(std::move(rule));
    } else {
      read.diagnostics.push_back({file, number, line.column(), Severity::kError, line.error()});
    }
  }
  return read;
}

}  // namespace musher
