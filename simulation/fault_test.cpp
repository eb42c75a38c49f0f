#include "musher/simulation/fault_test.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <sstream>
#include <utility>

#include "musher/actuator/callback_harness.hpp"
#include "musher/base/program_path.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/simulation/module_under_test.hpp"
#include "musher/simulation/search.hpp"
#include "musher/simulation/timeline.hpp"
#include "musher/wire/dds_options.hpp"

namespace musher::simulation {
namespace {

using transport::sim::Random;

ScenarioOptions OptionsFor(const MachineConfig& config) {
  ScenarioOptions options = UsualOptions(config);
  options.provided = false;  // the module is tested, not the config
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

// The least active state that can be left again.
State LeastState(const MachineConfig& config) {
  State least;
  for (const State& state : config.states) {
    const auto rank = config.RankOf(state);
    if (!rank || state == kTearDown || state == kError || state == kOta) continue;
    if (least.empty() || *rank < *config.RankOf(least)) least = state;
  }
  return least.empty() ? config.states.front() : least;
}

template <typename Word>
std::string Quoted(const std::vector<Word>& words) {
  std::string text;
  for (const Word& word : words) text += (text.empty() ? "\"" : ", \"") + word + "\"";
  return "[" + text + "]";
}

// The injected events for a robot whose actuator is under test: as SampleInjections(), but half of
// them hit that actuator. In addition the machine switches down and up once, and one event hits the
// actuator during that.
Injections SampleInjectionsAt(const MachineConfig& config, ActuatorIndex actuator,
                              std::uint64_t seed) {
  Injections injections = SampleInjections(config, seed);
  Random random(seed * 2 + 2);
  for (Injection& injection : injections) {
    if (random.Bernoulli(0.5)) injection.actuator = actuator;
  }
  const Duration last = injections.empty() ? Duration::zero() : injections.back().at;
  const auto add = [&](InjectionKind kind, Duration at, const State& state) {
    Injection injection;
    injection.kind = kind;
    injection.at = at;
    injection.actuator = actuator;
    injection.state = state;
    injection.lasts = Milliseconds(200);
    injection.random = random.Next();
    injections.push_back(injection);
  };
  // The machine switches down and up again, and an event hits the actuator's callback meanwhile.
  const State home = UsualOptions(config).home;
  const Duration down = random.Between(Milliseconds(300), last + Milliseconds(1000));
  const Duration up = down + random.Between(Milliseconds(50), Milliseconds(500));
  const Duration during = up + random.Between(Duration::zero(), Milliseconds(150));
  add(InjectionKind::kSet, down, LeastState(config));
  add(InjectionKind::kSet, up, home);
  switch (random.Next() % 6) {
    case 0:
    case 1:
      add(InjectionKind::kEmergencyStop, during, {});
      break;
    case 2:
      add(InjectionKind::kCrash, during, {});
      break;
    case 3:
      add(InjectionKind::kSlow, up, {});
      break;
    case 4:
      add(InjectionKind::kFail, random.Bernoulli(0.5) ? down : up, {});
      break;
    default:
      if (config.HasState(kTearDown)) add(InjectionKind::kSet, during, State(kTearDown));
      break;
  }
  std::stable_sort(injections.begin(), injections.end(),
                   [](const Injection& a, const Injection& b) { return a.at < b.at; });
  return injections;
}

Result<MachineConfig> ReadConfig(const FaultTestSetup& setup, const std::string& name,
                                 const std::vector<State>& states) {
  if (!setup.config_file.empty()) return ReadValidConfig(setup.config_file);
  if (setup.config_text.empty()) return ConfigAround(name, states);
  ConfigReading reading = ReadConfigText(setup.config_text, "config_text");
  if (reading.config) return std::move(*reading.config);
  std::string faults;
  for (const Diagnostic& fault : reading.diagnostics) faults += FormatDiagnostic(fault) + "\n";
  return Error{kCodeParametersInvalid, faults};
}

}  // namespace

class FaultTest::Impl {
 public:
  Impl(MachineConfig config, ActuatorIndex actuator, FaultTestSetup setup);

  std::optional<FaultTestFailure> Find(std::uint64_t first, std::uint64_t count);
  Result<std::optional<FaultTestFailure>> Run(const ScenarioId& id);
  const std::string& timeline() const { return timeline_; }
  const FaultTestCounts& counts() const { return counts_; }

 private:
  struct Verdict {
    std::string what;
    std::optional<Invariant> invariant;  // that is violated; nullopt: the module's check failed
  };
  std::optional<Verdict> RunOnce(const ScenarioId& id);
  FaultTestFailure Shorten(std::uint64_t seed, const Verdict& verdict);

  const MachineConfig config_;
  const ActuatorIndex actuator_;
  const ScenarioOptions options_;
  ModuleUnderTest::Setup setup_;
  std::function<void(const std::string&)> on_failure_;  // of the running scenario
  bool stuck_ = false;                                  // a thread was given up
  std::string timeline_;
  FaultTestCounts counts_;
};

FaultTest::Impl::Impl(MachineConfig config, ActuatorIndex actuator, FaultTestSetup setup)
    : config_(std::move(config)),
      actuator_(actuator),
      options_(OptionsFor(config_)),
      setup_(std::move(setup)) {
  const auto then_report = [this](auto check) {
    return [this, check = std::move(check)](const MachineActuator& module,
                                            const ActuatorReport& report) {
      check(module, report);
      if (const std::string what = setup_.next_failure(); !what.empty()) on_failure_(what);
    };
  };
  setup_.check = then_report(std::move(setup_.check));
  setup_.check_stop = then_report(std::move(setup_.check_stop));
  setup_.report_error = [this](const std::string& what) {
    on_failure_(config_.actuators[actuator_].name + ": " + what);
  };
  setup_.on_stuck = [this] { stuck_ = true; };
  setup_.counts = &counts_;
  setup_.config = &config_;
}

std::optional<FaultTest::Impl::Verdict> FaultTest::Impl::RunOnce(const ScenarioId& id) {
  if (setup_.before_scenario) setup_.before_scenario();
  stuck_ = false;
  Injections injections = SampleInjectionsAt(config_, actuator_, id.seed);
  if (id.only) {
    Injections some;
    for (const std::size_t number : *id.only) some.push_back(injections.at(number - 1));
    injections = std::move(some);
  }
  ++counts_.scenarios;
  std::optional<Verdict> verdict;
  {
    Scenario scenario(config_, id.seed, std::move(injections), options_);
    on_failure_ = [&](const std::string& what) {
      if (!verdict) verdict = {what, std::nullopt};
      scenario.EndNow();
    };
    Random random(id.seed);
    scenario.UseModule(
        config_.actuators[actuator_].name, [&](const Scenario::ActSampler& sample_act) {
          return std::make_unique<ModuleUnderTest>(setup_, sample_act, random.Next());
        });
    Timeline timeline(scenario, config_);
    const ScenarioEnd ending = scenario.Run();
    timeline.End(ending);
    timeline_ = timeline.Text();
    if (!verdict && ending.violation) {
      verdict = {ending.violation->what +
                     "; violated: " + std::string(InvariantText(ending.violation->invariant)),
                 ending.violation->invariant};
    }
  }
  if (const std::string what = setup_.next_failure(); !verdict && !what.empty()) {
    verdict = {what, std::nullopt};
  }
  return verdict;
}

FaultTestFailure FaultTest::Impl::Shorten(std::uint64_t seed, const Verdict& verdict) {
  FaultTestFailure failure{{seed, std::nullopt}, verdict.what, timeline_, true};
  if (stuck_) return failure;  // each replay would take as long, and leave another thread behind
  const auto bad = [&](const std::optional<std::vector<std::size_t>>& only) {
    const auto again = RunOnce({seed, only});
    return again && again->invariant == verdict.invariant;
  };
  failure.reproduced = bad(std::nullopt);
  if (!failure.reproduced) return failure;
  failure.id.only = ShrinkWhile(SampleInjectionsAt(config_, actuator_, seed).size(), bad);
  if (const auto last = RunOnce(failure.id)) failure.what = last->what;
  failure.timeline = timeline_;
  return failure;
}

std::optional<FaultTestFailure> FaultTest::Impl::Find(std::uint64_t first, std::uint64_t count) {
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    if (const auto verdict = RunOnce({seed, std::nullopt})) {
      return Shorten(seed, *verdict);
    }
  }
  return std::nullopt;
}

Result<std::optional<FaultTestFailure>> FaultTest::Impl::Run(const ScenarioId& id) {
  const std::size_t count = SampleInjectionsAt(config_, actuator_, id.seed).size();
  for (const std::size_t number : id.only.value_or(std::vector<std::size_t>())) {
    if (number == 0 || number > count) {
      return Error{kCodeParametersInvalid, "seed " + std::to_string(id.seed) + " has " +
                                               std::to_string(count) + " injected events, and no " +
                                               std::to_string(number)};
    }
  }
  std::optional<FaultTestFailure> failure;
  if (const auto verdict = RunOnce(id)) failure = {id, verdict->what, timeline_, true};
  return failure;
}

Result<FaultTest> FaultTest::Make(FaultTestSetup setup) {
  if (setup.before_scenario) setup.before_scenario();
  Faults none(0);
  std::unique_ptr<MachineActuator> probe = setup.make(none);
  if (!probe) return Error{kCodeParametersInvalid, "nothing makes the actuator: set `make`"};
  CallbackHarness harness(*probe);
  auto config = ReadConfig(setup, probe->name(), harness.States());
  if (!config) return config.error();
  if (const auto fits = harness.Adopt(config.value()); !fits) return fits.error();
  const ActuatorIndex index = *config.value().IndexOf(probe->name());
  probe.reset();
  return FaultTest(std::make_unique<Impl>(std::move(config).value(), index, std::move(setup)));
}

FaultTest::FaultTest(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FaultTest::FaultTest(FaultTest&&) noexcept = default;
FaultTest& FaultTest::operator=(FaultTest&&) noexcept = default;
FaultTest::~FaultTest() = default;

std::optional<FaultTestFailure> FaultTest::Find(std::uint64_t first, std::uint64_t count) {
  return impl_->Find(first, count);
}

Result<std::optional<FaultTestFailure>> FaultTest::Run(const ScenarioId& id) {
  return impl_->Run(id);
}

const std::string& FaultTest::timeline() const {
  return impl_->timeline();
}

const FaultTestCounts& FaultTest::counts() const {
  return impl_->counts();
}

Result<MachineConfig> ConfigAround(const std::string& actuator, const std::vector<State>& states) {
  std::ostringstream text;
  const std::vector<std::string> names = {"before_" + actuator, actuator, "after_" + actuator};
  text << "[controller]\nname = \"fault_test\"\nactuators = " << Quoted(names)
       << "\nstates = " << Quoted(states)
       << "\ndefault_time = 1000\ndefault_state = \"Uninitialized\"\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    text << "[actuator." << names[i] << "]\nstates = " << Quoted(states) << "\ntimes = [";
    for (std::size_t k = 0; k < states.size(); ++k) text << "1000, ";
    text << "]\ncommand = [\"" << names[i] << "\"]\n";
    if (i > 0) text << "after = [\"" << names[i - 1] << "\"]\n";
    if (i == 1) text << "critical = true\n";
  }
  ConfigReading reading = ReadConfigText(text.str(), "fault_test.toml");
  if (reading.config) return std::move(*reading.config);
  std::string faults = "no default config fits " + actuator + "; set config_file or config_text:";
  for (const Diagnostic& diagnostic : reading.diagnostics)
    faults += "\n" + FormatDiagnostic(diagnostic);
  return Error{kCodeParametersInvalid, faults};
}

std::string ReplayCommand(const ScenarioId& id, const std::string& test) {
  std::string only;
  for (const std::size_t number : id.only.value_or(std::vector<std::size_t>())) {
    only += (only.empty() ? " MUSHER_ONLY=" : ",") + std::to_string(number);
  }
  if (id.only && id.only->empty()) only = " MUSHER_ONLY=none";
  return "MUSHER_SEED=" + std::to_string(id.seed) + only + " " + OwnProgram().string() +
         " --gtest_filter='" + test + "'";
}

Result<std::optional<ScenarioId>> ScenarioFromEnvironment() {
  const std::string seed = Variable("MUSHER_SEED");
  if (seed.empty()) return std::optional<ScenarioId>();
  ScenarioId id;
  if (!IsNumber(seed, id.seed))
    return Error{kCodeParametersInvalid, "MUSHER_SEED is not a number: " + seed};
  const std::string only = Variable("MUSHER_ONLY");
  if (only.empty()) return std::optional(id);
  id.only.emplace();
  std::istringstream numbers(only == "none" ? "" : only);
  for (std::string one; std::getline(numbers, one, ',');) {
    std::uint64_t number = 0;
    if (!IsNumber(one, number)) {
      return Error{kCodeParametersInvalid,
                   "MUSHER_ONLY is not a list of numbers such as 3,7: " + only};
    }
    id.only->push_back(number);
  }
  return std::optional(id);
}

}  // namespace musher::simulation
