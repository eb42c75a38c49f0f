#pragma once
// The nodes of a behaviour tree. A robot's node derives from one of
//
//   Action          done within its tick: SUCCESS or FAILURE
//   StatefulAction  takes several ticks: OnStart, OnRunning until it is done, OnHalted if it is
//                   stopped before
//   Condition       looks at something: SUCCESS or FAILURE; RUNNING while it can not say
//   Decorator       has one child
//   Control         has several children
//
// and makes its ports in its constructor (setup.hpp). A call returns at once and reads no clock:
// the time is in the tick. What it throws ends the tick: the tree is halted, and the tick fails
// with the path of the node. A node that was RUNNING when it threw is halted, too; one that throws
// in its first tick (OnStart) undoes by itself what it has begun. Below a node that does not run no
// node runs: a child that a Decorator or Control leaves running, when it completes or is halted, is
// halted behind it.
//
//   IDLE ── tick ──→ RUNNING ── tick ──→ SUCCESS | FAILURE ── reset by the parent ──→ IDLE
//                       └── Halt(): OnHalt() once ──→ IDLE
//
// Threads: one at a time.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/behavior/tree/status.hpp"
#include "musher/behavior/tree/trace.hpp"

namespace musher::tree {

class Hooks;  // hooks.hpp

// One tick of the tree.
struct Tick {
  Time now;
  NodeId faulty = 0;    // the node of `fault`
  bool woken = false;   // a node wants to be ticked again at once
  std::string fault{};  // of a node that threw while it was halted
  Trace* trace = nullptr;
  Hooks* hooks = nullptr;  // mostly none
  // Rises by 1 with each tick of the tree, by more where the tree was halted or has completed in
  // between. A condition compares it with the number of its last tick: a reactive control resets
  // its conditions in every tick, so their status does not tell whether they were ticked last time.
  std::uint64_t number = 0;
  // The number of the present run of the tree. Rises by 1 when the tree has completed, was skipped,
  // has failed by a fault, or was halted.
  std::uint64_t run = 0;
};

struct Conditions;  // conditions.hpp
class Node;

// What a node threw, with its path.
struct NodeFault {
  const Node* node = nullptr;
  std::string what;
};

// A node that also derives from this learns of each run of its tree, also where the run never
// reaches it.
class RunObserver {
 public:
  RunObserver() = default;
  RunObserver(const RunObserver&) = delete;
  RunObserver& operator=(const RunObserver&) = delete;
  virtual ~RunObserver() = default;
  // Before the first tick of a run.
  virtual void OnNewRun(const Tick& tick) = 0;
};

class Node {
 public:
  Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  virtual ~Node();

  // For the parent: one tick of this node, with its conditions.
  Status Execute(Tick& tick) {
    if (special_) return ExecuteSpecially(tick);
    const Status status = Run(tick);
    Become(status == Status::kSkipped ? Status::kIdle : status, tick);
    return status;
  }
  // For the parent: stops it where it runs; then it is idle.
  void Reset(Tick& tick) {
    if (status_ == Status::kRunning) {
      Halt(tick);
    } else if (status_ != Status::kIdle) {
      const Status before = std::exchange(status_, Status::kIdle);
      if (tick.trace != nullptr) tick.trace->AddReset({tick.now, id_, before, Status::kIdle});
    }
  }
  Status status() const { return status_; }
  bool running() const { return status_ == Status::kRunning; }
  NodeId id() const { return id_; }

 protected:
  virtual Status OnTick(Tick& tick) = 0;
  virtual void OnHalt(Tick&) {}  // only while it runs

 private:
  friend class Builder;
  friend class Tree;

  Status Run(Tick& tick) {
    try {
      const Status status = OnTick(tick);
      if (status == Status::kIdle || status > Status::kSkipped) FailStatus(status);
      return status;
    } catch (const NodeFault&) {
      Become(Status::kRunning, tick);  // so that a halt reaches the nodes below
      throw;
    } catch (const std::exception& error) {
      Fail(error.what(), tick);
    } catch (...) {
      Fail("an unknown exception", tick);
    }
  }
  void Become(Status status, Tick& tick) {
    if (status_ == status) return;
    const Status before = std::exchange(status_, status);
    if (tick.trace != nullptr) tick.trace->Add({tick.now, id_, before, status});
  }
  [[noreturn]] static void FailStatus(Status status);
  [[noreturn]] void Fail(const char* what, Tick& tick);
  [[noreturn]] void FailAsEnded(const char* what, Tick& tick);
  Status ExecuteSpecially(Tick& tick);
  std::optional<Status> CallHook(Tick& tick);
  Status EndByHook(Status status, Tick& tick);
  Status End(Status status, Tick& tick);
  void Halt(Tick& tick);
  void CallOnHalt(Tick& tick);
  void HaltBelow(Tick& tick);
  void NoteFault(const char* what, Tick& tick) const;

  Status status_ = Status::kIdle;
  bool special_ = false;
  enum class Shape : std::uint8_t { kLeaf, kDecorator, kControl } shape_ = Shape::kLeaf;
  bool held_ = false;  // by a hook, with its result
  NodeId id_ = 0;
  std::unique_ptr<Conditions> conditions_;

  friend class Decorator;
  friend class Control;
};

class Action : public Node {
 protected:
  // SUCCESS or FAILURE.
  virtual Status Do(const Tick& tick) = 0;

 private:
  Status OnTick(Tick& tick) final;
};

class StatefulAction : public Node {
 protected:
  virtual Status OnStart(const Tick& tick) = 0;
  virtual Status OnRunning(const Tick& tick) = 0;
  virtual void OnHalted(const Tick&) {}

 private:
  Status OnTick(Tick& tick) final { return running() ? OnRunning(tick) : OnStart(tick); }
  void OnHalt(Tick& tick) final { OnHalted(tick); }
};

class Condition : public Node {
 protected:
  virtual Status Evaluate(const Tick& tick) = 0;

 private:
  Status OnTick(Tick& tick) final { return Evaluate(tick); }
};

class Decorator : public Node {
 public:
  Node& child() const { return *child_; }

 protected:
  Decorator() { shape_ = Shape::kDecorator; }
  // Ticks the child, and resets it when it has completed.
  Status TickChild(Tick& tick) {
    const Status status = child_->Execute(tick);
    if (IsCompleted(status)) child_->Reset(tick);
    return status;
  }
  // An override halts the child where that matters to it: else the tree does so behind it.
  void OnHalt(Tick& tick) override { child_->Reset(tick); }

 private:
  friend class Builder;
  Node* child_ = nullptr;
};

class Control : public Node {
 public:
  const std::vector<Node*>& children() const { return children_; }
  // Names of the children, in their order: the attribute `name`, or else the name of the class.
  const std::vector<std::string>& child_names() const { return child_names_; }

 protected:
  static constexpr std::size_t kAny = static_cast<std::size_t>(-1);
  // How many children it needs; checked when the tree is built.
  explicit Control(std::size_t least = 1, std::size_t most = kAny) : least_(least), most_(most) {
    shape_ = Shape::kControl;
  }
  void OnHalt(Tick& tick) override { ResetChildren(tick); }
  // Each control does this when it completes. What it leaves running is halted behind it.
  void ResetChildren(Tick& tick) {
    for (Node* child : children_) child->Reset(tick);
  }

 private:
  friend class Builder;
  std::size_t least_;
  std::size_t most_;
  std::vector<Node*> children_;
  std::vector<std::string> child_names_;
};

// Leaves that are a function.
using LeafFunction = std::function<Status(const Tick&)>;

}  // namespace musher::tree
