// TryCatch and Finally: a child that brings things in order after others have failed or ended.

#include <stdexcept>

#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {
namespace {

// One tick of a child while its parent is halted. A child that still runs then is halted.
void CleanUpInHalt(Node& child, Tick& tick) {
  try {
    child.Execute(tick);
  } catch (const NodeFault& fault) {
    child.Reset(tick);
    throw std::runtime_error(fault.what);
  }
  child.Reset(tick);
}

// All children but the last in order; the last one when one of them fails.
class TryCatch : public Control {
 public:
  explicit TryCatch(Setup& setup)
      : Control(2),
        catch_on_halt_(setup.Input<bool>("catch_on_halt", false,
                                         "also ticks the last child once when it is halted")) {}

 private:
  Status OnTick(Tick& tick) override {
    if (!running()) Begin();
    const std::vector<Node*>& nodes = children();
    const std::size_t tries = nodes.size() - 1;
    while (!in_catch_ && at_ < tries) {
      const Status status = nodes[at_]->Execute(tick);
      if (status == Status::kRunning) return status;
      if (status == Status::kFailure) {
        ResetChildren(tick);
        in_catch_ = true;
        break;
      }
      if (status == Status::kSkipped) ++skipped_;
      ++at_;
    }
    if (in_catch_ && nodes.back()->Execute(tick) == Status::kRunning) return Status::kRunning;
    ResetChildren(tick);
    if (in_catch_) return Status::kFailure;
    return skipped_ == tries ? Status::kSkipped : Status::kSuccess;
  }
  void OnHalt(Tick& tick) override {
    ResetTries(tick);
    if (!in_catch_ && catch_on_halt_.Get()) CleanUpInHalt(*children().back(), tick);
    ResetChildren(tick);
  }
  void ResetTries(Tick& tick) {
    for (std::size_t i = 0; i + 1 < children().size(); ++i) children()[i]->Reset(tick);
  }
  void Begin() {
    at_ = skipped_ = 0;
    in_catch_ = false;
  }

  InPort<bool> catch_on_halt_;
  std::size_t at_ = 0;
  std::size_t skipped_ = 0;
  bool in_catch_ = false;
};

// The second child when the first has ended, has thrown or is halted.
class Finally : public Control {
 public:
  explicit Finally(Setup& setup) : Control(2, 2) {
    static_cast<void>(
        setup.OptionalInput<unsigned>("halt_timeout_msec", "ignored: a halt takes no time"));
  }

 private:
  Status OnTick(Tick& tick) override {
    if (!running()) {
      in_cleanup_ = false;
      cleaned_up_ = false;
    }
    if (!in_cleanup_) {
      result_ = children()[0]->Execute(tick);
      if (result_ == Status::kRunning) return result_;
      in_cleanup_ = true;
    }
    cleaned_up_ = true;  // also where it throws
    const Status cleanup = children()[1]->Execute(tick);
    if (cleanup == Status::kRunning) {
      cleaned_up_ = false;
      return cleanup;
    }
    ResetChildren(tick);
    return cleanup == Status::kFailure ? cleanup : result_;
  }
  void OnHalt(Tick& tick) override {
    children()[0]->Reset(tick);
    if (!cleaned_up_) CleanUpInHalt(*children()[1], tick);
    ResetChildren(tick);
  }

  Status result_ = Status::kIdle;
  bool in_cleanup_ = false;
  bool cleaned_up_ = false;
};

}  // namespace

void AddCleanups(Factory& factory) {
  static_cast<void>(factory.Add<TryCatch>("TryCatch"));
  static_cast<void>(factory.Add<Finally>("Finally"));
}

}  // namespace musher::tree
