#include "musher/behavior/tree/node.hpp"

#include <stdexcept>
#include <utility>

#include "musher/behavior/tree/conditions.hpp"
#include "musher/behavior/tree/hooks.hpp"

namespace musher::tree {

Node::Node() = default;
Node::~Node() = default;

void Node::FailStatus(Status status) {
  const std::string returned = status == Status::kIdle
                                   ? "IDLE"
                                   : "no status (" + std::to_string(static_cast<int>(status)) + ")";
  throw std::runtime_error("its tick returned " + returned +
                           "; expected SUCCESS, FAILURE, RUNNING or SKIPPED");
}

// In its tick. A node with children is halted from the root, for those.
void Node::Fail(const char* what, Tick& tick) {
  if (shape_ == Shape::kLeaf) {
    if (running()) CallOnHalt(tick);
    FailAsEnded(what, tick);
  }
  Become(Status::kRunning, tick);
  throw NodeFault{this, what};
}

// Neither it nor what is below it runs: it must not be halted again.
void Node::FailAsEnded(const char* what, Tick& tick) {
  Become(Status::kFailure, tick);
  throw NodeFault{this, what};
}

Status Node::ExecuteSpecially(Tick& tick) {
  if (std::exchange(held_, false) && IsCompleted(status_)) return EndByHook(status_, tick);
  if (conditions_ != nullptr) {
    try {
      if (!running()) {
        if (const auto instead = conditions_->BeforeStart()) {
          if (*instead == Status::kSkipped) return *instead;
          conditions_->AfterCompleted(*instead);
          Become(*instead, tick);
          return *instead;
        }
      } else if (!conditions_->MayContinue()) {
        Halt(tick);
        return Status::kSkipped;
      }
    } catch (const std::exception& error) {
      if (running()) CallOnHalt(tick);
      FailAsEnded(error.what(), tick);
    }
  }
  if (tick.hooks != nullptr) {
    if (const auto instead = CallHook(tick)) {
      return *instead == Status::kRunning ? *instead : End(*instead, tick);
    }
  }
  const Status status = Run(tick);
  if (status != Status::kRunning) HaltBelow(tick);
  return tick.hooks != nullptr ? EndByHook(status, tick) : End(status, tick);
}

Status Node::EndByHook(Status status, Tick& tick) {
  if (tick.hooks != nullptr && IsCompleted(status)) {
    const Status instead = tick.hooks->After(id_, status);
    if (instead == Status::kRunning) {
      held_ = true;
      Become(status, tick);
      return instead;
    }
    status = instead;
  }
  return End(status, tick);
}

Status Node::End(Status status, Tick& tick) {
  if (IsCompleted(status) && conditions_ != nullptr) {
    try {
      conditions_->AfterCompleted(status);
    } catch (const std::exception& error) {
      FailAsEnded(error.what(), tick);
    }
  }
  Become(status == Status::kSkipped ? Status::kIdle : status, tick);
  return status;
}

// RUNNING: it is held, and stays as it is; SUCCESS, FAILURE: instead of its tick.
std::optional<Status> Node::CallHook(Tick& tick) {
  const Status instead = tick.hooks->Before(id_, running());
  if (instead == Status::kSkipped) return std::nullopt;
  if (IsCompleted(instead) && running()) Halt(tick);
  return instead;
}

// The first one is reported; the others are halted all the same.
void Node::NoteFault(const char* what, Tick& tick) const {
  if (!tick.fault.empty()) return;
  tick.fault = what;
  tick.faulty = id_;
}

void Node::Halt(Tick& tick) {
  Become(Status::kIdle, tick);
  CallOnHalt(tick);
}

void Node::CallOnHalt(Tick& tick) {
  // What is ticked within a halt, to clean up, is neither held nor replaced.
  Hooks* const hooks = std::exchange(tick.hooks, nullptr);
  try {
    OnHalt(tick);
    if (conditions_ != nullptr) conditions_->AfterHalt();
  } catch (const std::exception& error) {
    NoteFault(error.what(), tick);
  } catch (...) {
    NoteFault("an unknown exception", tick);
  }
  HaltBelow(tick);
  tick.hooks = hooks;
}

// The children that a node has left running. Those of the library leave none.
void Node::HaltBelow(Tick& tick) {
  const auto halt = [&tick](Node& child) {
    if (child.running()) child.Reset(tick);
  };
  if (shape_ == Shape::kDecorator) halt(static_cast<Decorator*>(this)->child());
  if (shape_ != Shape::kControl) return;
  for (Node* child : static_cast<Control*>(this)->children()) halt(*child);
}

Status Action::OnTick(Tick& tick) {
  const Status status = Do(tick);
  if (status == Status::kRunning) {
    throw std::runtime_error("an action must not return RUNNING; derive from StatefulAction");
  }
  return status;
}

std::optional<Status> Conditions::BeforeStart() const {
  constexpr std::array<Status, 3> kThen = {Status::kFailure, Status::kSuccess, Status::kSkipped};
  for (std::size_t i = 0; i < kThen.size(); ++i) {
    if (scripts[i] != nullptr && scripts[i]->True()) return kThen[i];
  }
  if (scripts[3] != nullptr && !scripts[3]->True()) return Status::kSkipped;
  return std::nullopt;
}

bool Conditions::MayContinue() const {
  return scripts[3] == nullptr || scripts[3]->True();
}

void Conditions::AfterCompleted(Status status) const {
  const auto& script = scripts[status == Status::kSuccess ? 4 : 5];
  if (script != nullptr) script->Run();
  if (scripts[7] != nullptr) scripts[7]->Run();
}

void Conditions::AfterHalt() const {
  if (scripts[6] != nullptr) scripts[6]->Run();
}

}  // namespace musher::tree
