#pragma once
// A state that holds a machine of its own, with the same rules, to any depth.
//
//   auto photo = std::make_unique<fsm::Machine>(fsm::Machine::Options{.name = "photo"});
//   photo->Add("CONFIRM", ...);  ...  photo->Add("DONE", ..., fsm::Role::kFinal);
//   machine.Add("PHOTO", std::make_unique<fsm::Nested>(std::move(photo), "CONFIRM",
//                                                      fsm::Nested::Options{.finished =
//                                                      "TRACKING"}));
//
//   the outer state is entered    the inner machine starts, or resumes
//   stays                         the inner machine is ticked, with the outer one's machine time
//   is left gradually             the inner machine is paused; its safety checks are not called
//   is left, however              the inner machine is stopped: its state is left too
//
// A command that the outer state neither handles nor keeps goes to the inner machine, if that has
// an event of the same name; during a gradual transition inside, it waits outside. A fault of the
// inner machine stays inside as long as its safe state handles it; a fault that stops the inner
// machine is a fault of the outer state, reported with the path ("PHOTO/CONFIRM"). Once the inner
// machine is in a final state, the outer one goes to `finished` in the next tick.
//
// A state inside may go to any state of the hierarchy (Transitions::To()): in the same tick the
// innermost state is left first, up to the one below the machine that has both ends; then the
// target and the states around it are entered, the outermost first.
//
// A state may hold several machines, which run side by side (regions): each tick ticks them in
// order, a command goes to all that have it, and the state is finished once all of them are in a
// final state. Their names and those of their states differ. They are left in the reverse order.
//
// A derived class that overrides Decide() decides more; its function has to call this class's
// function.
//
// Threads: those of the outer machine, one at a time.

#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "musher/behavior/fsm/machine.hpp"

namespace musher::fsm {

// The fault that stopped a machine, thrown to the machine around it.
class InnerFault : public std::exception {
 public:
  explicit InnerFault(Fault fault) : fault_(std::move(fault)) {}
  const char* what() const noexcept override { return fault_.what.c_str(); }
  const Fault& fault() const { return fault_; }

 private:
  Fault fault_;
};

class Nested : public State {
 public:
  struct Options {
    std::string finished{};  // the outer state after a final inner one; empty: Decide() decides
    // When re-entered, the inner machine continues in the state in which it was left, and re-enters
    // it. After a final or a safe state it starts from its start state anyway.
    bool resumes = false;
    // The states inside decide before Decide(): in a tick in which one of them goes elsewhere or
    // handles the command, Decide() is not called. Otherwise Decide() comes first, and the machine
    // inside gets what it leaves.
    bool inner_first = false;
  };

  struct Region {
    std::unique_ptr<Machine> machine;
    std::string start;
  };

  // `inner` has its states and is not built: Build() of the outer machine builds it.
  Nested(std::unique_ptr<Machine> inner, std::string start);
  Nested(std::unique_ptr<Machine> inner, std::string start, Options options);
  Nested(std::vector<Region> regions, Options options);
  ~Nested() override;

  void Declare(Transitions& transitions) override;
  void OnEnter(const Tick& tick) override;
  void Run(const Tick& tick) override;
  Next CheckTransition(const Tick& tick) final;
  void OnExit(const Tick& tick) override;
  void Persist(Archive& archive) override;
  std::span<const std::unique_ptr<Machine>> inside() final { return machines_; }

 protected:
  // The decision of the outer state itself; before the inner machine, unless that is first.
  virtual Next Decide(const Tick& /*tick*/) { return Next::Stay(); }
  // The inner machine is in a final state; all of them, where there are several.
  bool finished() const;
  const Machine& inner() const { return *machines_.front(); }

 private:
  struct Place {
    std::string start;
    bool built = false;
    std::optional<StateId> left_in{};
  };

  void RefuseSameNames(Transitions& transitions) const;
  Next Pass(EventId command);
  Machine::Use DecideInside(const Tick& tick);
  static Role RoleOf(const Machine& machine);
  static void ThrowIfStopped(const Machine& machine);

  std::vector<std::unique_ptr<Machine>> machines_;
  std::vector<Place> places_;  // of each machine
  const Options options_;
  StateId finished_transition_ = kNoState;
};

}  // namespace musher::fsm
