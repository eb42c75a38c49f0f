#pragma once
// Tries an actuator class against faults, in a GoogleTest: a whole robot in virtual time, your
// class behind one of its actuators, and what befalls it drawn from seeds. No DDS, no processes, no
// waiting. Link musher::simulation and GTest.
//
//   TEST(Gripper, HasNoPowerInLowPower) {
//     musher::simulation::ActuatorFaultTest<Gripper> trial;
//     trial.config_file = "robot.toml";
//     trial.always = [](const Gripper& gripper, const musher::ActuatorReport& report) {
//       EXPECT_FALSE(report.state == "LowPower" && gripper.powered());
//     };
//     trial.Run();
//   }
//
// A scenario that ends badly fails the test with its seed, a command that tells it again, and what
// happened, in as few injected events as can be. Bad is: what `always` says; a callback that fails
// when it is run twice in its state; one that neither ends nor asks StopRequested(); an
// OnEmergencyStop() that throws or blocks; an actuator that is of no use after its repair; and
// every other invariant of `musher simulate`.
//
//   MUSHER_SEED=42 [MUSHER_ONLY=3,7]   tells that scenario, maybe of some of its injected events
//   only MUSHER_SEEDS=100000                tries so many
//
// What it is not: the process is an object. To be killed, it leaves a callback by an exception out
// of StopRequested() and is destroyed without TearDown; what is static in your code outlives it, as
// hardware does, so let a fake of the hardware be static or the test's, and nothing else. Callbacks
// run on a thread, in turn with the simulation; they take no virtual time but at StopRequested()
// and at their end. Threads and clocks of your own are real, and nothing that they do comes back
// the same from the same seed. Checkpoint() does nothing.
//
// Threads: that of the test.

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <streambuf>
#include <string>
#include <type_traits>
#include <utility>

#include "musher/actuator/callback_harness.hpp"
#include "musher/lifecycle/config_toml.hpp"
#include "musher/simulation/fault_test.hpp"

namespace musher::simulation {

template <typename T>
class ActuatorFaultTest {
 public:
  static_assert(std::is_base_of_v<MachineActuator, T>);

  // The state config of the robot: a file, or the text of one. Without: your actuator, one before
  // and one after it.
  std::string config_file;
  std::string config_text;
  // Makes a process of the actuator. Without: T's default constructor.
  std::function<std::unique_ptr<T>()> make;
  // The same for one whose fake hardware fails when Faults says so. Without it, callbacks that are
  // to fail do so before their first step.
  std::function<std::unique_ptr<T>(Faults& faults)> make_with_faults;
  // Before each scenario; puts back what outlives a process.
  std::function<void()> before_scenario;
  // Has to hold whenever a callback has succeeded, and when an emergency stop is engaged beside
  // none. Says so with EXPECT_ and ASSERT_. `report.state` is the state that the actuator is in,
  // `report.emergency_stop` is 0 without a stop. After a failed callback things may be half done
  // until the next one has succeeded; then nothing is asked.
  std::function<void(const T& actuator, const ActuatorReport& report)> always;
  // Has to hold as soon as OnEmergencyStop() has run, maybe in the midst of the callback of
  // `report.target`.
  std::function<void(const T& actuator, const ActuatorReport& report)> after_emergency_stop;
  // What the battery has in all scenarios, %: Allowed() goes by it where a capability has a
  // min_battery. nullopt: it is not known.
  std::optional<int> battery = 100;
  std::uint64_t first_seed = 1;
  std::uint64_t scenarios = 300;
  // A callback that has neither ended nor asked StopRequested() for so long is stuck.
  std::chrono::milliseconds real_time_limit{10'000};

  // Fails the running test at the first failing scenario. What actuators say is only to be
  // heard when a scenario is told again.
  void Run() {
    const auto told = ScenarioFromEnvironment();
    if (!told) {
      ADD_FAILURE() << told.error().message;
      return;
    }
    if (told.value()) return TellAgain(*told.value());
    const char* seeds = std::getenv("MUSHER_SEEDS");
    if (seeds != nullptr) scenarios = std::strtoull(seeds, nullptr, 10);
    const auto found = Find();
    if (!found) {
      ADD_FAILURE() << found.error().message;
    } else if (found.value()) {
      Report(*found.value());
    }
  }

  // The first failing scenario; nothing when there is none. Fails when there can be no trial: the
  // config is faulty, or does not fit the callbacks.
  Result<std::optional<FaultTestFailure>> Find() {
    const Silence silence;
    return On([this](FaultTest& test) -> Result<std::optional<FaultTestFailure>> {
      return test.Find(first_seed, scenarios);
    });
  }

  // What the actuators of the last trial met.
  const FaultTestCounts& tally() const { return tally_; }

 private:
  using Answer = Result<std::optional<FaultTestFailure>>;

  // Of std::cout and std::cerr.
  class Silence {
   public:
    Silence() : out_(std::cout.rdbuf(nullptr)), error_(std::cerr.rdbuf(nullptr)) {}
    ~Silence() {
      std::cout.rdbuf(out_);
      std::cerr.rdbuf(error_);
    }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;

   private:
    std::streambuf* out_;
    std::streambuf* error_;
  };

  std::unique_ptr<MachineActuator> Make(Faults& faults) {
    if (make_with_faults) return make_with_faults(faults);
    if (make) return make();
    if constexpr (std::is_default_constructible_v<T>) return std::make_unique<T>();
    return nullptr;
  }

  // The config, once it fits the actuator.
  Result<MachineConfig> ReadConfig(MachineActuator& actuator) const {
    CallbackHarness rehearsal(actuator);
    auto config = ConfigFor(actuator.name(), rehearsal.States());
    if (!config) return config;
    if (auto fits = rehearsal.Adopt(config.value()); !fits) return fits.error();
    return config;
  }

  Result<MachineConfig> ConfigFor(const std::string& name, const std::vector<State>& states) const {
    if (!config_file.empty()) return ReadValidConfig(config_file);
    if (config_text.empty()) return ConfigAround(name, states);
    ConfigReading reading = ReadConfigText(config_text, "config_text");
    if (reading.config) return std::move(*reading.config);
    std::string faults;
    for (const Diagnostic& fault : reading.diagnostics) faults += FormatDiagnostic(fault) + "\n";
    return Error{kCodeParametersInvalid, faults};
  }

  ModuleUnderTest::Production Produce() {
    ModuleUnderTest::Production production;
    production.make = [this](Faults& faults) { return Make(faults); };
    production.fails_by_itself = make_with_faults != nullptr;
    production.real_time_limit = real_time_limit;
    production.battery = battery;
    production.check = [this](const MachineActuator& actuator, const ActuatorReport& report) {
      Ask(always, actuator, report);
    };
    production.check_stop = [this](const MachineActuator& actuator, const ActuatorReport& report) {
      Ask(after_emergency_stop, actuator, report);
    };
    return production;
  }

  template <typename Checker>
  static void Ask(const Checker& check, const MachineActuator& actuator,
                  const ActuatorReport& report) {
    if (!check) return;
    try {
      check(static_cast<const T&>(actuator), report);
    } catch (const std::exception& e) {
      ADD_FAILURE() << "the test threw: " << e.what();
    }
  }

  // GoogleTest's failures are collected meanwhile, so that only the shortest scenario is told.
  Answer On(const std::function<Answer(FaultTest&)>& work) {
    if (before_scenario) before_scenario();
    Faults none(0);
    std::unique_ptr<MachineActuator> probe = Make(none);
    if (!probe) return Error{kCodeParametersInvalid, "nothing makes the actuator: set `make`"};
    auto config = ReadConfig(*probe);
    if (!config) return config.error();
    const std::size_t index = *config.value().IndexOf(probe->name());
    probe.reset();
    auto failures = std::make_unique<::testing::TestPartResultArray>();
    using Reporter = ::testing::ScopedFakeTestPartResultReporter;
    const Reporter of_callbacks(Reporter::INTERCEPT_ALL_THREADS, failures.get());
    const Reporter of_judges(Reporter::INTERCEPT_ONLY_CURRENT_THREAD, failures.get());
    int seen = 0;
    const auto complaint = [&]() -> std::string {
      while (seen < failures->size()) {
        const auto& part = failures->GetTestPartResult(seen++);
        if (!part.failed()) continue;
        const char* file = part.file_name();
        return (file == nullptr ? std::string("the test")
                                : file + (":" + std::to_string(part.line_number()))) +
               ": " + part.message();
      }
      return {};
    };
    FaultTest test(std::move(config).value(), index, Produce(), complaint, before_scenario);
    Answer answer = work(test);
    tally_ = test.tally();
    timeline_ = test.timeline();
    return answer;
  }

  void TellAgain(const ScenarioId& id) {
    const auto told = On([&](FaultTest& test) { return test.Tell(id); });
    std::cout << timeline_;
    if (!told) {
      ADD_FAILURE() << told.error().message;
    } else if (told.value()) {
      ADD_FAILURE() << told.value()->what;
    }
  }

  static void Report(const FaultTestFailure& failure) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    const std::string name =
        test == nullptr ? "*" : std::string(test->test_suite_name()) + "." + test->name();
    ADD_FAILURE() << failure.what << "\nagain with: " << TrialCommand(failure.id, name) << "\n"
                  << (failure.again ? ""
                                    : "told again, this scenario ended well: something outlives it "
                                      "(put it back in before_scenario), or time or threads of the "
                                      "actuator's own play a part\n")
                  << failure.timeline;
  }

  FaultTestCounts tally_;
  std::string timeline_;
};

}  // namespace musher::simulation
