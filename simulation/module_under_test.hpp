#pragma once
// A user's actuator class behind an actuator of a simulated robot.
//
// Threads: the network's, and one for the running callback; only one of the two runs at a time.
// StopRequested() hands over to the network's: virtual time advances while the callback waits
// there. So an event during a callback (an emergency stop, a request to stop, its end by SIGKILL)
// happens between two of its polls. Real time matters only for a callback that never hands over.

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/simulation/fault_test.hpp"
#include "musher/simulation/scenario.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::simulation {

class ModuleUnderTest : public Module {
 public:
  struct Setup : FaultTestSetup {
    explicit Setup(FaultTestSetup setup) : FaultTestSetup(std::move(setup)) {}

    // The actuator is faulty. `what` continues a sentence that begins with its name.
    std::function<void(const std::string& what)> report_error;
    // A callback does not return: its thread is given up.
    std::function<void()> on_stuck;
    FaultTestCounts* counts = nullptr;
    const MachineConfig* config = nullptr;  // that Allowed() goes by
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
  // The thread of an OnEmergencyStop() that was given up; it ends with the callback that it awaits.
  std::thread stop_;
  std::future<Result<>> stop_done_;
  State state_;                // that was commanded last
  bool waits_ = false;         // the callback waits for its thread, before its first instruction
  Act act_;                    // that was sampled for the callback
  std::optional<bool> ended_;  // the callback's success; nullopt once the actuator has noticed it
  bool settled_ = false;       // the last callback has succeeded
  ActuatorReport report_;
};

}  // namespace musher::simulation
