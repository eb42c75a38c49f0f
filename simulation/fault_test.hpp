#pragma once
// Runs an actuator class in many scenarios and shrinks the first one that fails. The part of
// actuator_fault_test.hpp (which users include) that needs no template. The simulated robot is
// behind a pointer: a test of a user's class sees nothing of it.
//
// Threads: one, and those of the callbacks. Only one of them runs at a time.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/lifecycle/machine/report.hpp"
#include "musher/simulation/scenario_id.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::simulation {

// Makes a fake of the hardware fail. Called in callbacks, on their thread.
class Faults {
 public:
  explicit Faults(std::uint64_t seed) : random_(seed) {}

  // Whether the current step fails: at random while callback failures are injected, else never.
  bool ShouldFail() { return under_way_ && random_.Bernoulli(0.5); }
  // A random number, for whatever else a fake varies.
  std::uint64_t Random() { return random_.Next(); }

  void SetUnderWay(bool under_way) { under_way_ = under_way; }

 private:
  transport::sim::Random random_;
  bool under_way_ = false;
};

// What the actuators under test went through.
struct FaultTestCounts {
  std::uint64_t scenarios = 0;
  std::uint64_t processes = 0;
  std::uint64_t callbacks = 0;
  std::uint64_t failed = 0;          // of them
  std::uint64_t repeated = 0;        // run again in the same state
  std::uint64_t stop_requested = 0;  // that saw StopRequested() return true
  std::uint64_t killed = 0;          // with their process
  std::uint64_t stops_during_callback = 0;
  std::uint64_t stops_before_callback = 0;  // of these, before its first instruction
  std::uint64_t emergency_stops = 0;        // in all
  std::uint64_t torn_down = 0;
};

// A scenario that failed.
struct FaultTestFailure {
  ScenarioId id;     // shrunk
  std::string what;  // a sentence
  std::string timeline;
  bool reproduced = true;  // it failed again when it was replayed
};

struct FaultTestSetup {
  // The state config of the robot: a file, or the text of one. Default: your actuator, one before
  // and one after it.
  std::string config_file{};
  std::string config_text{};
  std::function<std::unique_ptr<MachineActuator>(Faults&)> make{};
  // Makes the node of a process; empty: node() is null.
  std::function<std::shared_ptr<transport::NodeThread>()> make_node{};
  // The fakes fail (Faults), so that callbacks need not be failed from outside.
  bool fails_by_itself = false;
  std::chrono::milliseconds real_time_limit{10'000};
  std::optional<int> battery{};  // %; nullopt: not known
  std::function<void()> before_scenario{};
  // Called while no callback runs: one has succeeded, or an emergency stop was engaged.
  std::function<void(const MachineActuator&, const ActuatorReport&)> check{};
  // An emergency stop was engaged, possibly during a callback; or a callback has ended during a
  // stop and the actuator did not enter its state.
  std::function<void(const MachineActuator&, const ActuatorReport&)> check_stop{};
  // Called after each of both checks, which need not report failures themselves: returns the next
  // failure of the test; empty: there is none.
  std::function<std::string()> next_failure{};
};

class FaultTest {
 public:
  // Makes one actuator, for its name and states. Fails when the config has errors or does not fit
  // the callbacks.
  static Result<FaultTest> Make(FaultTestSetup setup);
  FaultTest(FaultTest&&) noexcept;
  FaultTest& operator=(FaultTest&&) noexcept;
  ~FaultTest();

  // Runs `count` scenarios from the seed `first` on; returns the first failing one, shrunk.
  std::optional<FaultTestFailure> Find(std::uint64_t first, std::uint64_t count);
  // Runs one scenario; nothing: it passed. Fails when it has no injected event of that number.
  Result<std::optional<FaultTestFailure>> Run(const ScenarioId& id);
  // Timeline of the last scenario, as text.
  const std::string& timeline() const;
  const FaultTestCounts& counts() const;

 private:
  class Impl;
  explicit FaultTest(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A robot of an actuator with these states and two neighbours, one before and one after it. Fails
// for a state whose rank only a config can give.
Result<MachineConfig> ConfigAround(const std::string& actuator, const std::vector<State>& states);

// "MUSHER_SEED=42 MUSHER_ONLY=3,7 ./gripper_test --gtest_filter=Gripper.HoldsItsLoad"
std::string ReplayCommand(const ScenarioId& id, const std::string& test);
// MUSHER_SEED and MUSHER_ONLY of the environment; nothing without MUSHER_SEED.
Result<std::optional<ScenarioId>> ScenarioFromEnvironment();

}  // namespace musher::simulation
