#pragma once
// A controller in the benchmark's own process that can be looked into: when it put what on record,
// by the steady clock, and how its machine stood then. It starts its machine up by itself, as
// `musher up` does.
//
// Threads: calls from the benchmark's thread; conditions run on the controller's loop.
// Errors: what does not come within two minutes ends the benchmark with a message.

#include <functional>
#include <future>
#include <list>
#include <memory>
#include <string>

#include "musher/controller/controller.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::benchmark {

class ObservedController {
 public:
  // Evaluated at each record; the machine is as it is after the whole decision.
  using Condition = std::function<bool(const action::Record& record, const Machine& machine)>;

  explicit ObservedController(const std::string& config_file);
  // Kills the actuators that it started, and leaves the others running.
  ~ObservedController();
  ObservedController(const ObservedController&) = delete;
  ObservedController& operator=(const ObservedController&) = delete;

  // When the first record from now on that meets the condition was made. Call it before the fault.
  std::future<Time> Next(Condition condition);
  // The same, for each record until the controller's end, which the watcher must outlive.
  void Watch(std::function<void(const action::Record& record, const Machine& machine)> watcher);

  // Waits until the machine is so.
  void Await(const std::string& what, const std::function<bool(const Machine&)>& is_so);
  // Until it is in use and all its actuators are where it is, well and at rest.
  void AwaitAllThere();

  Machine Snapshot();
  SwitchResult Switch(const State& target);

 private:
  void OnRecord(const action::Record& record);

  MachineConfig config_;
  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<Controller> controller_;
  std::list<Condition> waiting_;  // on the loop; a true condition is removed
};

// Waits for what Next() gave.
Time MomentOf(std::future<Time>& moment, const std::string& what);

// Whether this actuator follows and is where the machine is, with nothing left to be done.
bool IsThere(const Machine& machine, ActuatorIndex actuator);

// The condition that the health of an actuator is on record as `health`.
ObservedController::Condition IsOnRecord(ActuatorIndex actuator, Health health);

}  // namespace musher::benchmark
