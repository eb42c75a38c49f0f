#include "musher/simulation/trial.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <utility>

#include "musher/lifecycle/config_toml.hpp"
#include "musher/simulation/timeline.hpp"

namespace musher::simulation {
namespace {

using transport::sim::Random;

StoryOptions OptionsFor(const MachineConfig& config) {
  StoryOptions options = UsualOptions(config);
  options.provided = false;  // the module is judged, not the config
  return options;
}

bool IsNumber(const std::string& text, std::uint64_t& number) {
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && last == end;
}

std::string Variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// The least active one that can be left again.
State LeastState(const MachineConfig& config) {
  State least;
  for (const State& state : config.states) {
    const auto rank = config.RankOf(state);
    if (!rank || state == kTearDown || state == kError || state == kOta) continue;
    if (least.empty() || *rank < *config.RankOf(least)) least = state;
  }
  return least.empty() ? config.states.front() : least;
}

std::string Quoted(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "\"" : ", \"") + word + "\"";
  return "[" + text + "]";
}

}  // namespace

Trial::Trial(MachineConfig config, std::size_t actuator, RehearsedModule::Production production,
             std::function<std::string()> complaint, std::function<void()> before_story)
    : config_(std::move(config)),
      actuator_(actuator),
      options_(OptionsFor(config_)),
      production_(std::move(production)),
      complaint_(std::move(complaint)),
      before_story_(std::move(before_story)) {
  const auto and_ask = [this](auto judge) {
    return [this, judge = std::move(judge)](const MachineActuator& tried,
                                            const ActuatorReport& report) {
      judge(tried, report);
      if (const std::string what = complaint_(); !what.empty()) on_complaint_(what);
    };
  };
  production_.judge = and_ask(std::move(production_.judge));
  production_.judge_stop = and_ask(std::move(production_.judge_stop));
  production_.complain = [this](const std::string& what) {
    on_complaint_(config_.actuators[actuator_].name + ": " + what);
  };
  production_.on_stuck = [this] { stuck_ = true; };
  production_.tally = &tally_;
  production_.config = &config_;
}

std::optional<Trial::Verdict> Trial::TellOnce(const StoryId& id) {
  if (before_story_) before_story_();
  stuck_ = false;
  Incidents incidents = DrawIncidentsAt(config_, actuator_, id.seed);
  if (id.only) {
    Incidents some;
    for (const std::size_t number : *id.only) some.push_back(incidents.at(number - 1));
    incidents = std::move(some);
  }
  ++tally_.stories;
  std::optional<Verdict> verdict;
  {
    Story story(config_, id.seed, std::move(incidents), options_);
    on_complaint_ = [&](const std::string& what) {
      if (!verdict) verdict = {what, std::nullopt};
      story.EndNow();
    };
    Random dice(id.seed);
    story.UseModule(config_.actuators[actuator_].name, [&](const Story::Draw& draw) {
      return std::make_unique<RehearsedModule>(production_, draw, dice.Next());
    });
    Timeline timeline(story, config_);
    const Ending ending = story.Tell();
    timeline.End(ending);
    timeline_ = timeline.Text();
    if (!verdict && ending.violation) {
      verdict = {ending.violation->what + "; so it does not hold that " +
                     std::string(PromiseText(ending.violation->promise)),
                 ending.violation->promise};
    }
  }
  if (const std::string what = complaint_(); !verdict && !what.empty()) {
    verdict = {what, std::nullopt};
  }
  return verdict;
}

TrialFailure Trial::Shorten(std::uint64_t seed, const Verdict& verdict) {
  TrialFailure failure{{seed, std::nullopt}, verdict.what, timeline_, true};
  if (stuck_) return failure;  // it would take as long again, and another thread
  const auto bad = [&](const std::optional<std::vector<std::size_t>>& only) {
    const auto again = TellOnce({seed, only});
    return again && again->promise == verdict.promise;
  };
  failure.again = bad(std::nullopt);
  if (!failure.again) return failure;
  failure.id.only = ShrinkWhile(DrawIncidentsAt(config_, actuator_, seed).size(), bad);
  if (const auto last = TellOnce(failure.id)) failure.what = last->what;
  failure.timeline = timeline_;
  return failure;
}

std::optional<TrialFailure> Trial::Find(std::uint64_t first, std::uint64_t count) {
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    if (const auto verdict = TellOnce({seed, std::nullopt})) {
      return Shorten(seed, *verdict);
    }
  }
  return std::nullopt;
}

Result<std::optional<TrialFailure>> Trial::Tell(const StoryId& id) {
  const std::size_t count = DrawIncidentsAt(config_, actuator_, id.seed).size();
  for (const std::size_t number : id.only.value_or(std::vector<std::size_t>())) {
    if (number == 0 || number > count) {
      return Error{kCodeParametersInvalid, "seed " + std::to_string(id.seed) + " has " +
                                               std::to_string(count) + " incidents, and no " +
                                               std::to_string(number)};
    }
  }
  std::optional<TrialFailure> failure;
  if (const auto verdict = TellOnce(id)) failure = {id, verdict->what, timeline_, true};
  return failure;
}

Incidents DrawIncidentsAt(const MachineConfig& config, std::size_t actuator, std::uint64_t seed) {
  Incidents incidents = DrawIncidents(config, seed);
  Random dice(seed * 2 + 2);
  for (Incident& incident : incidents) {
    if (dice.Chance(0.5)) incident.actuator = actuator;
  }
  const Duration last = incidents.empty() ? Duration::zero() : incidents.back().at;
  const auto add = [&](IncidentKind kind, Duration at, const State& state) {
    Incident incident;
    incident.kind = kind;
    incident.at = at;
    incident.actuator = actuator;
    incident.state = state;
    incident.lasts = Milliseconds(200);
    incident.chance = dice.Next();
    incidents.push_back(incident);
  };
  // The machine goes down and up again, and then, beside a callback on the way, something happens.
  const State home = UsualOptions(config).home;
  const Duration down = dice.Between(Milliseconds(300), last + Milliseconds(1000));
  const Duration up = down + dice.Between(Milliseconds(50), Milliseconds(500));
  const Duration then = up + dice.Between(Duration::zero(), Milliseconds(150));
  add(IncidentKind::kSet, down, LeastState(config));
  add(IncidentKind::kSet, up, home);
  switch (dice.Next() % 6) {
    case 0:
    case 1:
      add(IncidentKind::kEmergencyStop, then, {});
      break;
    case 2:
      add(IncidentKind::kCrash, then, {});
      break;
    case 3:
      add(IncidentKind::kSlow, up, {});
      break;
    case 4:
      add(IncidentKind::kFail, dice.Chance(0.5) ? down : up, {});
      break;
    default:
      if (config.HasState(kTearDown)) add(IncidentKind::kSet, then, State(kTearDown));
      break;
  }
  std::stable_sort(incidents.begin(), incidents.end(),
                   [](const Incident& a, const Incident& b) { return a.at < b.at; });
  return incidents;
}

Result<MachineConfig> ConfigAround(const std::string& actuator, const std::vector<State>& states) {
  std::ostringstream text;
  const std::vector<std::string> names = {"before_" + actuator, actuator, "after_" + actuator};
  text << "[controller]\nname = \"trial\"\nactuators = " << Quoted(names)
       << "\nstates = " << Quoted(states)
       << "\ndefault_time = 1000\ndefault_state = \"Uninitialized\"\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    text << "[actuator." << names[i] << "]\nstates = " << Quoted(states) << "\ntimes = [";
    for (std::size_t k = 0; k < states.size(); ++k) text << "1000, ";
    text << "]\ncommand = [\"" << names[i] << "\"]\n";
    if (i > 0) text << "after = [\"" << names[i - 1] << "\"]\n";
    if (i == 1) text << "critical = true\n";
  }
  ConfigReading reading = ReadConfigText(text.str(), "trial.toml");
  if (reading.config) return std::move(*reading.config);
  std::string faults = "no config can be made for " + actuator + ", so give one:";
  for (const Diagnostic& diagnostic : reading.diagnostics)
    faults += "\n" + FormatDiagnostic(diagnostic);
  return Error{kCodeParametersInvalid, faults};
}

std::string TrialCommand(const StoryId& id, const std::string& test) {
  std::string only;
  for (const std::size_t number : id.only.value_or(std::vector<std::size_t>())) {
    only += (only.empty() ? " MUSHER_ONLY=" : ",") + std::to_string(number);
  }
  if (id.only && id.only->empty()) only = " MUSHER_ONLY=none";
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  return "MUSHER_SEED=" + std::to_string(id.seed) + only + " " + program.string() +
         " --gtest_filter='" + test + "'";
}

Result<std::optional<StoryId>> StoryFromEnvironment() {
  const std::string seed = Variable("MUSHER_SEED");
  if (seed.empty()) return std::optional<StoryId>();
  StoryId id;
  if (!IsNumber(seed, id.seed)) return Error{kCodeParametersInvalid, "MUSHER_SEED is no number"};
  const std::string only = Variable("MUSHER_ONLY");
  if (only.empty()) return std::optional(id);
  id.only.emplace();
  std::istringstream numbers(only == "none" ? "" : only);
  for (std::string one; std::getline(numbers, one, ',');) {
    std::uint64_t number = 0;
    if (!IsNumber(one, number)) {
      return Error{kCodeParametersInvalid, "MUSHER_ONLY is no list of numbers such as 3,7"};
    }
    id.only->push_back(number);
  }
  return std::optional(id);
}

}  // namespace musher::simulation
