// Sequence, Fallback and their variants: children in order.

#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {
namespace {

// Goes on from child to child while they return `kGoesOn`; ends with the first other result.
template <Status kGoesOn>
class InOrder : public Control {
 public:
  // `yields`: RUNNING between two children, so that the tree can react.
  explicit InOrder(bool keeps_place = false, bool yields = false)
      : keeps_place_(keeps_place), yields_(yields) {}

 private:
  Status OnTick(Tick& tick) override {
    if (!running()) skipped_ = 0;
    const std::vector<Node*>& nodes = children();
    while (at_ < nodes.size()) {
      Node& child = *nodes[at_];
      const bool fresh = !child.running();
      const Status status = child.Execute(tick);
      if (status == Status::kRunning) return status;
      if (status == Status::kSkipped) {
        ++skipped_;
        ++at_;
      } else if (status == kGoesOn) {
        ++at_;
        if (yields_ && fresh && at_ < nodes.size()) {
          tick.woken = true;
          return Status::kRunning;
        }
      } else {
        if (!keeps_place_) {
          at_ = 0;
          ResetChildren(tick);
        } else {
          for (std::size_t i = at_; i < nodes.size(); ++i) nodes[i]->Reset(tick);
        }
        return status;
      }
    }
    const bool all_skipped = skipped_ == nodes.size();
    at_ = 0;
    skipped_ = 0;
    ResetChildren(tick);
    return all_skipped ? Status::kSkipped : kGoesOn;
  }
  void OnHalt(Tick& tick) override {
    if (!keeps_place_) at_ = 0;
    ResetChildren(tick);
  }

  const bool keeps_place_;
  const bool yields_;
  std::size_t at_ = 0;
  std::size_t skipped_ = 0;
};

// Begins with the first child in every tick; what runs behind the one that runs now is halted.
template <Status kGoesOn>
class Reactive : public Control {
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    std::size_t skipped = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Status status = nodes[i]->Execute(tick);
      if (status == Status::kRunning) {
        for (std::size_t k = 0; k < nodes.size(); ++k) {
          if (k != i) nodes[k]->Reset(tick);
        }
        return status;
      }
      if (status == Status::kSkipped) {
        ++skipped;
        nodes[i]->Reset(tick);
      } else if (status != kGoesOn) {
        ResetChildren(tick);
        return status;
      }
    }
    ResetChildren(tick);
    return skipped == nodes.size() ? Status::kSkipped : kGoesOn;
  }
};

class IfThenElse : public Control {
 public:
  IfThenElse() : Control(2, 3) {}

 private:
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    if (at_ == 0) {
      const Status condition = nodes[0]->Execute(tick);
      if (condition == Status::kRunning) return condition;
      if (condition == Status::kSkipped) return condition;
      if (condition == Status::kFailure && nodes.size() == 2) {
        ResetChildren(tick);
        return condition;
      }
      at_ = condition == Status::kSuccess ? 1 : 2;
    }
    const Status status = nodes[at_]->Execute(tick);
    if (status == Status::kRunning) return status;
    at_ = 0;
    ResetChildren(tick);
    return status;
  }
  void OnHalt(Tick& tick) override {
    at_ = 0;
    ResetChildren(tick);
  }

  std::size_t at_ = 0;
};

class WhileDoElse : public Control {
 public:
  WhileDoElse() : Control(2, 3) {}

 private:
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    const Status condition = nodes[0]->Execute(tick);
    if (condition == Status::kRunning) {  // what is not ticked must not run
      for (std::size_t i = 1; i < nodes.size(); ++i) nodes[i]->Reset(tick);
      return condition;
    }
    Status status = condition;
    if (condition == Status::kSuccess) {
      if (nodes.size() == 3) nodes[2]->Reset(tick);
      status = nodes[1]->Execute(tick);
    } else if (condition == Status::kFailure && nodes.size() == 3) {
      nodes[1]->Reset(tick);
      status = nodes[2]->Execute(tick);
    }
    if (status != Status::kRunning) ResetChildren(tick);
    return status;
  }
};

template <class N>
Factory::Registered Plain(bool keeps_place, bool yields) {
  return {NodeKind::kControl, yields, [keeps_place, yields](Setup&) -> std::unique_ptr<Node> {
            return std::make_unique<N>(keeps_place, yields);
          }};
}

}  // namespace

void AddParallels(Factory& factory);

void AddControls(Factory& factory) {
  using SequenceNode = InOrder<Status::kSuccess>;
  using FallbackNode = InOrder<Status::kFailure>;
  static_cast<void>(factory.Register("Sequence", Plain<SequenceNode>(false, false)));
  static_cast<void>(factory.Register("SequenceWithMemory", Plain<SequenceNode>(true, true)));
  static_cast<void>(factory.Register("AsyncSequence", Plain<SequenceNode>(false, true)));
  static_cast<void>(factory.Register("Fallback", Plain<FallbackNode>(false, false)));
  static_cast<void>(factory.Register("AsyncFallback", Plain<FallbackNode>(false, true)));
  static_cast<void>(factory.Add<Reactive<Status::kSuccess>>("ReactiveSequence"));
  static_cast<void>(factory.Add<Reactive<Status::kFailure>>("ReactiveFallback"));
  static_cast<void>(factory.Add<IfThenElse>("IfThenElse"));
  static_cast<void>(factory.Add<WhileDoElse>("WhileDoElse"));
  AddParallels(factory);
}

}  // namespace musher::tree
