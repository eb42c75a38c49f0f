// RecoveryNode, PipelineSequence, RoundRobin.

#include <utility>

#include "musher/behavior/tree/nav2/register.hpp"

namespace musher::tree::nav2 {
namespace {

// The first child; where it fails, the second one, and then the first one again.
class RecoveryNode : public Control {
 public:
  explicit RecoveryNode(Setup& setup)
      : Control(2, 2),
        retries_(setup.Input<int>("number_of_retries", 1,
                                  "how often the second child may put the first one right")) {}

 private:
  Status OnTick(Tick& tick) override {
    Node& main = *children()[0];
    Node& recovery = *children()[1];
    if (!running()) Begin();
    while (true) {
      if (!recovers_) {
        const Status status = main.Execute(tick);
        if (status == Status::kRunning) return status;
        if (status != Status::kFailure || done_ >= retries_.Get()) return End(status, tick);
        main.Reset(tick);
        recovers_ = true;
      }
      const Status status = recovery.Execute(tick);
      if (status == Status::kRunning) return status;
      // Where the recovery is skipped, nothing was put right.
      if (status != Status::kSuccess) return End(Status::kFailure, tick);
      recovery.Reset(tick);
      recovers_ = false;
      ++done_;
    }
  }
  void OnHalt(Tick& tick) override { ResetChildren(tick); }

  void Begin() {
    recovers_ = false;
    done_ = 0;
  }
  Status End(Status status, Tick& tick) {
    ResetChildren(tick);
    return status;
  }

  InPort<int> retries_;
  bool recovers_ = false;
  int done_ = 0;  // recoveries
};

// A Sequence that ticks the children before the present one again, too.
class PipelineSequence : public Control {
 private:
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    if (!running()) at_ = 0;
    std::size_t skipped = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Status status = nodes[i]->Execute(tick);
      if (status == Status::kFailure) {
        ResetChildren(tick);
        return status;
      }
      if (status == Status::kSkipped) ++skipped;
      if (status == Status::kRunning && i >= at_) {
        at_ = i;
        return status;
      }
    }
    ResetChildren(tick);
    return skipped == nodes.size() ? Status::kSkipped : Status::kSuccess;
  }

  std::size_t at_ = 0;  // the farthest child that was reached
};

// Goes on behind the child that has succeeded last in this run of the tree.
class RoundRobin : public Control {
 public:
  explicit RoundRobin(Setup& setup)
      : wraps_(setup.Input<bool>("wrap_around", false,
                                 "true: behind the last child it goes on with the first; false: it "
                                 "fails there")) {}

 private:
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    if (std::exchange(run_, tick.run) != tick.run) at_ = 0;
    if (!running()) failed_ = 0;
    std::size_t skipped = 0;
    while (failed_ + skipped < nodes.size()) {
      if (at_ == nodes.size()) {
        if (!wraps_.Get()) break;
        at_ = 0;
      }
      const Status status = nodes[at_]->Execute(tick);
      if (status == Status::kRunning) return status;
      ++at_;
      if (status == Status::kSuccess) {
        ResetChildren(tick);
        return status;
      }
      ++(status == Status::kSkipped ? skipped : failed_);
    }
    at_ = 0;
    ResetChildren(tick);
    return skipped == nodes.size() ? Status::kSkipped : Status::kFailure;
  }
  void OnHalt(Tick& tick) override {
    at_ = 0;
    ResetChildren(tick);
  }

  InPort<bool> wraps_;
  std::uint64_t run_ = 0;
  std::size_t at_ = 0;      // kept after a success
  std::size_t failed_ = 0;  // children, since the last success
};

}  // namespace

void AddControlNodes(Factory& factory) {
  AddNode<RecoveryNode>(factory, "RecoveryNode", NodeKind::kControl, false,
                        "Ticks the first child; where it fails, the second one, then the first "
                        "one again. Fails with the second one, or after so many retries.");
  AddNode<PipelineSequence>(factory, "PipelineSequence", NodeKind::kControl, false,
                            "A Sequence that ticks all children up to the present one in each "
                            "tick.");
  AddNode<RoundRobin>(
      factory, "RoundRobin", NodeKind::kControl, false,
      "Ticks its children in order until one succeeds; the next time in this run of the "
      "tree it goes on behind that one. Fails where all have failed.");
}

}  // namespace musher::tree::nav2
