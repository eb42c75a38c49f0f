#pragma once
// A fake robot: the real decision code of the controller and of its actuators, connected as the
// shells connect them. What is sent and what runs ends when the derived class decides so: after a
// time in test/lifecycle/coordination/harness.hpp, by a choice in harness.hpp.

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <variant>
#include <vector>

#include "musher/lifecycle/actuator/actuator_core.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"

namespace musher::search {

// An actuator and its process.
struct FakeActuator {
  bool alive = false;
  bool visible = false;      // its service: it is set up
  std::int64_t reports = 0;  // so far, for their stamps
  ActuatorCore core;

  // A new process starts, on the controller's host.
  void Launch(std::int32_t pid) {
    alive = true;
    core.report.pid = pid;
    core.report.incarnation = Incarnation(static_cast<std::uint64_t>(pid));
    core.report.host = "here";
  }
  std::int32_t pid() const { return core.report.pid; }
};

// A command or a query, from the controller that sent it.
struct Message {
  ActuatorIndex to = 0;
  Sender sender = 0;
  Epoch epoch = 0;
  std::variant<SwitchCommand, QueryCommand> what;
};

// What outlasts a controller.
struct Disk {
  Epoch epoch = 0;
  StoredStops stops;
  StoredPolicy policy;
  bool stop_intent = false;
  std::vector<RemoteActuator> remote;
  std::vector<StoredActuator> actuators;
  std::map<ActuatorIndex, std::int32_t> children;  // their pids
};

// A fake robot but for its actuators; a value.
struct FakeController {
  Time now = Time(std::chrono::hours(1));
  Machine machine;
  std::uint64_t generation = 0;  // grows with each controller that takes over
  Disk disk;

  Sender sender() const { return Sender(generation + 1); }
};

class FakeRobot {
 public:
  FakeRobot(const FakeRobot&) = delete;
  FakeRobot& operator=(const FakeRobot&) = delete;
  virtual ~FakeRobot() = default;

  // An event of the controller. Events are handled one after the other, as in its shell.
  void Feed(const Event& event);
  // The controller starts, with what is on the disk. `restarted`: by a supervisor, after a crash;
  // `supervised`: by a supervisor; `at_boot`: by one, for the first time since its host was booted.
  void BeginController(bool by_hand, bool restarted = false, bool supervised = false,
                       bool at_boot = false);
  // A message arrives, after a heartbeat of its sender if that is `announced`. A process that has
  // ended, or is not set up, receives nothing.
  void Deliver(const Message& message, bool announced = true);
  // What an actuator reports now. The stamps differ, also while time stands still.
  ActuatorReport Report(ActuatorIndex i);

 protected:
  // Both outlive this object.
  FakeRobot(const MachineConfig& config, FakeController& controller)
      : config_(config), controller_(controller) {}

  // The controller detects the exit of a process, which it has started or not.
  void FeedExit(const event::ProcessEnded& end);
  // Executes an action of the controller: by Send(), Save() or, if it is none of those, Do().
  void Apply(const Action& action);

  void NoteChild(const Event& event);
  virtual FakeActuator& Actuator(ActuatorIndex i) = 0;
  // One step of a decision code, with all its actions.
  virtual void StepController(const Event& event) = 0;
  virtual void StepActuator(ActuatorIndex i, const ActuatorEvent& event) = 0;
  // The token of a request; the answer to it has the same.
  virtual RequestToken TokenOf(Sender sender, CommandNumber number, bool query) = 0;
  // Leads to Deliver(), unless the message is lost.
  virtual void Send(const Message& message) = 0;
  // Leads to `write` and SaveEnded.
  virtual void Save(Stored what, SaveNumber save, std::function<void(Disk&)> write) = 0;
  virtual void Do(const Action& action) = 0;

  const MachineConfig& config_;
  FakeController& controller_;

 private:
  std::deque<Event> queue_;
  bool handling_ = false;
};

}  // namespace musher::search
