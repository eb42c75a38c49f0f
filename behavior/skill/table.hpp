#pragma once
// The states, transitions, limits and parameters of a skill, as it declares them. Times are run
// time: see Tick.
//
// Four states are part of every skill:
//
//   IDLE ──request──→ the first declared state ──→ … ──→ SUCCEEDED | FAILED | CANCELLED
//
// A skill may fail and be cancelled in each of its states, without a declaration. Every other
// transition that it makes and has not declared is a fault, which fails it: a skill never succeeds
// from a state in which it cannot.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/behavior/fsm/chart.hpp"
#include "musher/behavior/skill/value.hpp"

namespace musher::skill {

using fsm::StateId;

inline constexpr StateId kIdle{0};
inline constexpr StateId kSucceeded{1};
inline constexpr StateId kFailed{2};
inline constexpr StateId kCancelled{3};

constexpr bool IsEnd(StateId state) {
  return state == kSucceeded || state == kFailed || state == kCancelled;
}

inline constexpr Duration kNoLimit = Duration::max();

struct Limits {
  Duration run = std::chrono::minutes(10);    // of the whole run; then it fails
  Duration cancel = std::chrono::seconds(5);  // of the skill's own cancellation; then it is ended
  int retries = 3;                            // of one run

  friend bool operator==(const Limits&, const Limits&) = default;
};

// What a config changes of a skill; see toml/skills_toml.hpp.
struct Settings {
  std::optional<Duration> run{};
  std::optional<Duration> cancel{};
  std::optional<int> retries{};
  std::vector<std::pair<std::string, Duration>> states{};  // limits
  Values parameters{};                                     // defaults

  friend bool operator==(const Settings&, const Settings&) = default;
};

// "1.5 s", for messages.
std::string SecondsText(Duration time);

class Table {
 public:
  Table();

  // --- what a skill declares ---

  // What it does, in one sentence, for people: "Rises to an altitude and stays there".
  void Does(const std::string& summary) { summary_ = summary; }
  // The first one is the state in which a run begins. `limit`: of the time in the state; then
  // Skill::OnLimit() decides.
  StateId State(const std::string& name, Duration limit = kNoLimit);
  // `when` is for people: "the path is planned". To kSucceeded: the skill may succeed there.
  void To(StateId from, StateId to, const std::string& when);
  // The reported progress never falls in a run: a lower one leaves it unchanged.
  void MonotoneProgress() { monotone_ = true; }
  void Limit(const Limits& limits) { limits_ = limits; }
  // A part of the robot that the skill needs for itself: "base", "arm". No two skills that use the
  // same part run at the same time.
  void Uses(const std::string& part);
  // The same for requests that need it only then: `when` gets the complete parameters.
  using When = std::function<bool(const Values& parameters)>;
  void UsesWhen(const std::string& part, When when);
  // A run of it is not paused by a request (Manager::Pause()). `why` is for people: "its hand
  // cannot be stopped halfway".
  void CannotPause(const std::string& why) { cannot_pause_ = why; }

  // A parameter with a default, or one that has to be given. `meaning` has the unit: "m above the
  // ground".
  void Takes(const std::string& name, const Value& otherwise, const std::string& meaning);
  void Needs(const std::string& name, Kind kind, const std::string& meaning);

  // A parameter that is declared has this name as well: requests of older clients have it.
  void Also(const std::string& parameter, const std::string& name);
  // A parameter of older clients that it does not take. `why` is for people, with what to do.
  void RefusesParameter(const std::string& name, const std::string& why);

  // An error of the skill itself: it cannot begin.
  void Refuse(const std::string& why) { errors_.push_back(why); }

  // --- what others read ---

  struct Parameter {
    std::string name;
    Kind kind = Kind::kText;
    std::optional<Value> otherwise;  // none: it has to be given
    std::string meaning;
  };

  const std::string& summary() const { return summary_; }  // may be empty
  const fsm::Chart& chart() const { return chart_; }
  const std::vector<Parameter>& parameters() const { return parameters_; }
  const Limits& limits() const { return limits_; }
  // Parts of the robot: used by every request, used by some requests, and used by this request.
  const std::vector<std::string>& parts() const { return parts_; }
  const std::vector<std::pair<std::string, When>>& parts_when() const { return parts_when_; }
  std::vector<std::string> PartsFor(const Values& parameters) const;
  const std::string& cannot_pause() const { return cannot_pause_; }  // empty: it can
  bool monotone() const { return monotone_; }
  // Errors of the declarations themselves: a name that occurs twice, ...
  const std::vector<std::string>& errors() const { return errors_; }

  std::string_view Name(StateId state) const;
  std::optional<StateId> Find(std::string_view state) const;
  StateId first() const;  // kIdle: no state is declared
  Duration LimitOf(StateId state) const;
  // Replace what the skill has declared. Fail for an unknown name, with the nearest, and for a
  // value of another kind.
  Result<> SetLimit(std::string_view state, Duration limit);
  Result<> SetDefault(std::string_view parameter, const Value& value);
  // All of them, with all errors.
  Result<> Apply(const Settings& settings);
  bool Declared(StateId from, StateId to) const;

  // The given values with the defaults of the others. Fails, with all errors, for an unknown
  // parameter, with the nearest, a missing one and a value of another kind.
  Result<Values> Complete(const Values& given) const;
  // The same for values as texts; see Parse().
  Result<Values> Parse(const std::vector<std::pair<std::string, std::string>>& given) const;

 private:
  // The parameter with this name or alias; null: there is none.
  const Parameter* FindParameter(std::string_view name) const;
  std::string UnknownParameter(std::string_view name) const;
  void AddParameter(Parameter parameter);

  std::string summary_;
  fsm::Chart chart_;
  std::vector<Duration> state_limits_;  // by state
  std::vector<Parameter> parameters_;
  std::vector<std::pair<std::string, std::string>> other_names_;  // with their parameters
  std::vector<std::pair<std::string, std::string>> refused_;      // with the reasons
  Limits limits_;
  std::vector<std::string> parts_;
  std::vector<std::pair<std::string, When>> parts_when_;
  std::string cannot_pause_;
  bool monotone_ = false;
  std::vector<std::string> errors_;
};

// The first part of the robot that both of them use; nullptr: none.
const std::string* SharedPart(const std::vector<std::string>& one,
                              const std::vector<std::string>& other);

// "altitude: a number, default 1 (m above the ground)", "name: a text, required".
std::string ToText(const Table::Parameter& parameter);

}  // namespace musher::skill
