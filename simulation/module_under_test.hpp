#pragma once
// A user's actuator class behind an actuator of a simulated robot.
//
// Threads: the network's, and one for the callback that runs; of the two only one runs at a time.
// StopRequested() hands over: virtual time goes on while the callback waits there, so what comes
// beside a callback (an emergency stop, a request to stop, its end by SIGKILL) comes between two of
// its polls. Real time plays no part, but for a callback that never hands over.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/simulation/scenario.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::simulation {

// What a fake of the hardware is told by the scenario: asked in callbacks, on their thread.
class Faults {
 public:
  explicit Faults(std::uint64_t seed) : random_(seed) {}

  // Whether the step fails that is being taken. By chance while callbacks are to fail, else never.
  bool Strike() { return under_way_ && random_.Chance(0.5); }
  // For whatever else a fake has to draw.
  std::uint64_t Draw() { return random_.Next(); }

  void SetUnderWay(bool under_way) { under_way_ = under_way; }

 private:
  transport::sim::Random random_;
  bool under_way_ = false;
};

// What the actuators under trial met.
struct FaultTestCounts {
  std::uint64_t scenarios = 0;
  std::uint64_t processes = 0;
  std::uint64_t callbacks = 0;
  std::uint64_t failed = 0;           // of them
  std::uint64_t repeated = 0;         // run again in the same state
  std::uint64_t asked_to_stop = 0;    // that saw it
  std::uint64_t killed_in = 0;        // whose process was killed
  std::uint64_t stopped_beside = 0;   // beside which an emergency stop was engaged
  std::uint64_t stopped_before = 0;   // the same, between its start and its first instruction
  std::uint64_t emergency_stops = 0;  // altogether
  std::uint64_t torn_down = 0;
};

class ModuleUnderTest : public Module {
 public:
  struct Production {
    std::function<std::unique_ptr<MachineActuator>(Faults&)> make;
    // The fakes fail (Faults), so that callbacks need not be made to.
    bool fails_by_itself = false;
    std::chrono::milliseconds real_time_limit{10'000};
    // Beside no callback: one has succeeded, or an emergency stop was engaged.
    std::function<void(const MachineActuator&, const ActuatorReport&)> check;
    // An emergency stop was engaged, maybe in the midst of a callback; or a callback has ended
    // under one without being taken to its state.
    std::function<void(const MachineActuator&, const ActuatorReport&)> check_stop;
    // What is wrong with the actuator: the rest of a sentence about it.
    std::function<void(const std::string& what)> complain;
    // A thread of it is given up, which never comes back.
    std::function<void()> on_stuck;
    FaultTestCounts* tally = nullptr;
    const MachineConfig* config = nullptr;  // that Allowed() judges by
    std::optional<int> battery;             // %; nullopt: not known
  };

  // `production` must outlive it.
  ModuleUnderTest(const Production& production, Scenario::Draw draw, std::uint64_t seed);
  ~ModuleUnderTest() override;

  Act Run(const State& state) override;
  std::unique_ptr<Worker> MakeWorker(transport::EventLoop& loop) override;
  void SetStopRequested(bool requested) override;
  void OnEmergencyStop() override;
  void OnReport(const ActuatorReport& report) override;

 private:
  class LockstepWorker;
  struct Stage;  // shared with the thread of the callback

  void GiveUp(const std::string& why);

  const Production& production_;
  const Scenario::Draw draw_;
  transport::sim::Random random_;
  std::shared_ptr<Stage> stage_;
  State state_;                // that was commanded last
  bool waits_ = false;         // its callback for its thread, before its first instruction
  Act act_;                    // and what was drawn for it
  std::optional<bool> ended_;  // its callback, well or not; the actuator is yet to notice
  bool settled_ = false;       // the last callback has succeeded
  ActuatorReport report_;
};

}  // namespace musher::simulation
