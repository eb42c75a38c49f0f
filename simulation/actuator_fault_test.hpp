#pragma once
// Tests an actuator class under injected faults, in a GoogleTest: a whole robot in virtual time
// with your class behind one of its actuators, and events sampled from seeds. No DDS, no processes,
// no waiting. Link musher::simulation and GTest.
//
//   TEST(Gripper, HasNoPowerInLowPower) {
//     musher::simulation::ActuatorFaultTest<Gripper> test;
//     test.config_file = "robot.toml";
//     test.always = [](const Gripper& gripper, const musher::ActuatorReport& report) {
//       EXPECT_FALSE(report.state == "LowPower" && gripper.powered());
//     };
//     test.Run();
//   }
//
// A failing scenario fails the test. The message has its seed, a command that replays it, and a
// timeline with as few injected events as possible. A scenario fails when `always` reports a
// failure; a callback fails when it runs twice in its state; a callback neither ends nor calls
// StopRequested(); OnEmergencyStop() throws or blocks; the actuator does not work after its repair;
// or any other invariant of `musher simulate` is violated.
//
//   MUSHER_SEED=42 [MUSHER_ONLY=3,7]   replays that scenario, optionally with these events only
//   MUSHER_SEEDS=100000                runs so many scenarios
//
// Limits: the process is an object. When it is killed, StopRequested() throws an exception that
// leaves the callback, and the object is destroyed without TearDown. Static objects of your code
// outlive it, as hardware does: make a fake of the hardware static or a member of the test, and
// nothing else. Callbacks run on a thread, in turn with the simulation; virtual time passes only in
// StopRequested() and at their end. The network of `make_node` has a time of its own, which passes
// in NodeThread::WaitFor() and where the test runs it. Threads and clocks of your own are real, so
// a seed does not reproduce what they do. Checkpoint() does nothing.
//
// Threads: `make`, `always` and the other functions of this class run on the thread of the test.

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

#include "musher/simulation/fault_test.hpp"

namespace musher::simulation {

template <typename T>
class ActuatorFaultTest {
 public:
  static_assert(std::is_base_of_v<MachineActuator, T>);

  // The state config of the robot: a file, or the text of one. Default: your actuator, one before
  // and one after it.
  std::string config_file;
  std::string config_text;
  // Makes a process of the actuator. Default: T's default constructor.
  std::function<std::unique_ptr<T>()> make;
  // The same for an actuator whose fake hardware fails when Faults::ShouldFail() says so. Without
  // it, an injected callback failure happens before the first step of the callback.
  std::function<std::unique_ptr<T>(Faults& faults)> make_with_faults;
  // Makes the node of a process, usually a SimulatedNodeThread: node() returns it, and topics and
  // services are opened on its network, where the test has their peers (make a new network in
  // `before_scenario`). Default: there is no transport, and node() is null.
  std::function<std::shared_ptr<transport::NodeThread>()> make_node;
  // Runs before each scenario; resets what outlives a process.
  std::function<void()> before_scenario;
  // Must hold whenever a callback has succeeded, and when an emergency stop is engaged while no
  // callback runs. Checks with EXPECT_ and ASSERT_. `report.state` is the state that the actuator
  // is in, `report.emergency_stop` is 0 without a stop. After a failed callback it is not called
  // until the next callback has succeeded, since the work may be half done.
  std::function<void(const T& actuator, const ActuatorReport& report)> always;
  // Must hold as soon as OnEmergencyStop() has run, which may be during the callback of
  // `report.target`.
  std::function<void(const T& actuator, const ActuatorReport& report)> after_emergency_stop;
  // The battery's level in all scenarios, %: Allowed() compares it with the min_battery of a
  // capability. nullopt: it is not known.
  std::optional<int> battery = 100;
  std::uint64_t first_seed = 1;
  std::uint64_t scenarios = 300;
  // A callback that has neither ended nor called StopRequested() for so long is stuck.
  std::chrono::milliseconds real_time_limit{10'000};

  // Fails the running test at the first failing scenario. The output of actuators is printed only
  // when a scenario is replayed (MUSHER_SEED).
  void Run() {
    const auto chosen = ScenarioFromEnvironment();
    if (!chosen) {
      ADD_FAILURE() << chosen.error().message;
      return;
    }
    if (chosen.value()) return Replay(*chosen.value());
    const char* seeds = std::getenv("MUSHER_SEEDS");
    if (seeds != nullptr) scenarios = std::strtoull(seeds, nullptr, 10);
    const auto found = Find();
    if (!found) {
      ADD_FAILURE() << found.error().message;
    } else if (found.value()) {
      Report(*found.value());
    }
  }

  // The first failing scenario; nothing when there is none. Fails when no scenario can run: the
  // config has errors, or does not fit the callbacks.
  Result<std::optional<FaultTestFailure>> Find() {
    const Silence silence;
    return On([this](FaultTest& test) -> Result<std::optional<FaultTestFailure>> {
      return test.Find(first_seed, scenarios);
    });
  }

  // What the actuators of the last Run() or Find() went through.
  const FaultTestCounts& counts() const { return counts_; }

 private:
  using FindResult = Result<std::optional<FaultTestFailure>>;

  // Discards what is written to std::cout and std::cerr.
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

  FaultTestSetup MakeSetup() {
    FaultTestSetup setup;
    setup.config_file = config_file;
    setup.config_text = config_text;
    setup.make = [this](Faults& faults) { return Make(faults); };
    setup.make_node = make_node;
    setup.fails_by_itself = make_with_faults != nullptr;
    setup.real_time_limit = real_time_limit;
    setup.battery = battery;
    setup.before_scenario = before_scenario;
    setup.check = [this](const MachineActuator& actuator, const ActuatorReport& report) {
      Check(always, actuator, report);
    };
    setup.check_stop = [this](const MachineActuator& actuator, const ActuatorReport& report) {
      Check(after_emergency_stop, actuator, report);
    };
    return setup;
  }

  template <typename Property>
  static void Check(const Property& property, const MachineActuator& actuator,
                    const ActuatorReport& report) {
    if (!property) return;
    try {
      property(static_cast<const T&>(actuator), report);
    } catch (const std::exception& e) {
      ADD_FAILURE() << "the test threw: " << e.what();
    }
  }

  // Collects GoogleTest's failures while `work` runs, so that only those of the shortest scenario
  // are reported.
  FindResult On(const std::function<FindResult(FaultTest&)>& work) {
    auto failures = std::make_unique<::testing::TestPartResultArray>();
    int seen = 0;
    FaultTestSetup setup = MakeSetup();
    setup.next_failure = [&]() -> std::string {
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
    auto made = FaultTest::Make(std::move(setup));
    if (!made) return made.error();
    FaultTest& test = made.value();
    using Reporter = ::testing::ScopedFakeTestPartResultReporter;
    const Reporter of_callbacks(Reporter::INTERCEPT_ALL_THREADS, failures.get());
    const Reporter of_checks(Reporter::INTERCEPT_ONLY_CURRENT_THREAD, failures.get());
    FindResult result = work(test);
    counts_ = test.counts();
    timeline_ = test.timeline();
    return result;
  }

  void Replay(const ScenarioId& id) {
    const auto failure = On([&](FaultTest& test) { return test.Run(id); });
    std::cout << timeline_;
    if (!failure) {
      ADD_FAILURE() << failure.error().message;
    } else if (failure.value()) {
      ADD_FAILURE() << failure.value()->what;
    }
  }

  static void Report(const FaultTestFailure& failure) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    const std::string name =
        test == nullptr ? "*" : std::string(test->test_suite_name()) + "." + test->name();
    ADD_FAILURE() << failure.what << "\nreplay with: " << ReplayCommand(failure.id, name) << "\n"
                  << (failure.reproduced
                          ? ""
                          : "not reproduced: the replayed scenario passed. Either some state "
                            "outlives a scenario (reset it in before_scenario), or the actuator "
                            "uses real time or threads of its own\n")
                  << failure.timeline;
  }

  FaultTestCounts counts_;
  std::string timeline_;
};

}  // namespace musher::simulation
