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
// A derived class that overrides Decide() decides more; its function has to call this class's
// function.
//
// Threads: those of the outer machine, one at a time.

#include <exception>
#include <memory>
#include <optional>
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
  };

  // `inner` has its states and is not built: Build() of the outer machine builds it.
  Nested(std::unique_ptr<Machine> inner, std::string start);
  Nested(std::unique_ptr<Machine> inner, std::string start, Options options);
  ~Nested() override;

  void Declare(Transitions& transitions) override;
  void OnEnter(const Tick& tick) override;
  void Run(const Tick& tick) override;
  Next CheckTransition(const Tick& tick) final;
  void OnExit(const Tick& tick) override;
  void Persist(Archive& archive) override;
  Machine* inside() final { return inner_.get(); }

 protected:
  // Called before the inner machine: the decision of the outer state itself.
  virtual Next Decide(const Tick& /*tick*/) { return Next::Stay(); }
  // The inner machine is in a final state.
  bool finished() const;
  const Machine& inner() const { return *inner_; }

 private:
  Role inner_role() const;
  void ThrowIfStopped() const;

  const std::unique_ptr<Machine> inner_;
  const std::string start_;
  const Options options_;
  bool inner_built_ = false;
  StateId finished_transition_ = kNoState;
  std::vector<EventId> inner_events_;  // by the outer event of the same name
  std::optional<StateId> left_in_;
};

}  // namespace musher::fsm
