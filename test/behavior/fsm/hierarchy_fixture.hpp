#pragma once
// Machines of logging states, inside of each other.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/behavior/fsm/nested.hpp"
#include "musher/test/behavior/fsm/machine_fixture.hpp"

namespace musher::fsm {

// Logs "SHOW enter" before its machines are started, and "SHOW exit" after they were stopped.
class LoggingNested : public Nested {
 public:
  LoggingNested(std::string name, Log& log, std::vector<Region> regions, Options options = {})
      : Nested(std::move(regions), std::move(options)), state_(std::move(name), log) {}

  void Declare(Transitions& transitions) override {
    Nested::Declare(transitions);
    if (declare) declare(transitions);
  }
  void OnEnter(const Tick& tick) override {
    state_.OnEnter(tick);
    Nested::OnEnter(tick);
  }
  void OnExit(const Tick& tick) override {
    Nested::OnExit(tick);
    state_.OnExit(tick);
  }

  std::function<void(Transitions&)> declare;
  std::function<Next(const Tick&)> decide;
  LoggingState& state() { return state_; }

 protected:
  Next Decide(const Tick& tick) override { return decide ? decide(tick) : Next::Stay(); }

 private:
  LoggingState state_;
};

class HierarchyFixture : public MachineFixture {
 protected:
  static std::unique_ptr<Machine> NewMachine(const std::string& name) {
    return std::make_unique<Machine>(Machine::Options{.name = name});
  }
  LoggingNested& AddNested(Machine& machine, const std::string& name,
                           std::vector<Nested::Region> regions, Nested::Options options = {}) {
    auto state =
        std::make_unique<LoggingNested>(name, log_, std::move(regions), std::move(options));
    LoggingNested& added = *state;
    machine.Add(name, std::move(state));
    return added;
  }
  LoggingNested& AddNested(Machine& machine, const std::string& name,
                           std::unique_ptr<Machine> inside, const std::string& start,
                           Nested::Options options = {}) {
    std::vector<Nested::Region> regions;
    regions.push_back({std::move(inside), start});
    return AddNested(machine, name, std::move(regions), std::move(options));
  }
  // The calls of the next tick.
  Log TickLog() {
    log_.clear();
    Run();
    return log_;
  }
};

}  // namespace musher::fsm
