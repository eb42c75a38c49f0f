#pragma once
// A user's actuator class behind an actuator of a simulated robot.
//
// Threads: the network's, and one for the running callback; only one of the two runs at a time.
// StopRequested() hands over to the network's: virtual time advances while the callback waits
// there. So an event during a callback (an emergency stop, a request to stop, its end by SIGKILL)
// happens between two of its polls. Real time matters only for a callback that never hands over.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/simulation/scenario.hpp"
#include "musher/transport/dds/node_thread.hpp"
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

class ModuleUnderTest : public Module {
 public:
  struct Setup {
    std::function<std::unique_ptr<MachineActuator>(Faults&)> make;
    // Makes the node of a process; empty: node() is null.
    std::function<std::shared_ptr<transport::NodeThread>()> make_node;
    // The fakes fail (Faults), so that callbacks need not be failed from outside.
    bool fails_by_itself = false;
    std::chrono::milliseconds real_time_limit{10'000};
    // Called while no callback runs: one has succeeded, or an emergency stop was engaged.
    std::function<void(const MachineActuator&, const ActuatorReport&)> check;
    // An emergency stop was engaged, possibly during a callback; or a callback has ended during a
    // stop and the actuator did not enter its state.
    std::function<void(const MachineActuator&, const ActuatorReport&)> check_stop;
    // The actuator is faulty. `what` continues a sentence that begins with its name.
    std::function<void(const std::string& what)> report_error;
    // A callback does not return: its thread is given up.
    std::function<void()> on_stuck;
    FaultTestCounts* counts = nullptr;
    const MachineConfig* config = nullptr;  // that Allowed() goes by
    std::optional<int> battery;             // %; nullopt: not known
  };

  // `setup` must outlive it.
  ModuleUnderTest(const Setup& setup, Scenario::ActSampler sample_act, std::uint64_t seed);
  ~ModuleUnderTest() override;

  Act Run(const State& state) override;
  std::unique_ptr<Worker> MakeWorker(transport::EventLoop& loop) override;
  void SetStopRequested(bool requested) override;
  void OnEmergencyStop() override;
  void OnReport(const ActuatorReport& report) override;

 private:
  class LockstepWorker;
  struct CallbackThread;  // the state that is shared with the thread of the callback

  void GiveUp(const std::string& why);

  const Setup& setup_;
  const Scenario::ActSampler sample_act_;
  transport::sim::Random random_;
  std::shared_ptr<CallbackThread> callback_;
  State state_;                // that was commanded last
  bool waits_ = false;         // the callback waits for its thread, before its first instruction
  Act act_;                    // that was sampled for the callback
  std::optional<bool> ended_;  // the callback's success; nullopt once the actuator has noticed it
  bool settled_ = false;       // the last callback has succeeded
  ActuatorReport report_;
};

}  // namespace musher::simulation
