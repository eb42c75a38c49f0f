// RecoveryNode, PipelineSequence, NonblockingSequence, PersistentSequence, RoundRobin,
// PauseResumeController.

#include <array>
#include <stdexcept>
#include <string>
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

// Ticks all children in each tick, also those that have succeeded before.
class NonblockingSequence : public Control {
 private:
  Status OnTick(Tick& tick) override {
    std::size_t run = 0;
    std::size_t skipped = 0;
    for (Node* child : children()) {
      const Status status = child->Execute(tick);
      if (status == Status::kFailure) {
        ResetChildren(tick);
        return status;
      }
      if (status == Status::kRunning) ++run;
      if (status == Status::kSkipped) ++skipped;
    }
    if (run > 0) return Status::kRunning;
    ResetChildren(tick);
    return skipped == children().size() ? Status::kSkipped : Status::kSuccess;
  }
};

// A Sequence whose place is an entry: a halt, a failure and the end of a run of the tree keep it,
// and another node may set it.
class PersistentSequence : public Control {
 public:
  explicit PersistentSequence(Setup& setup)
      : place_(setup.InOut<int>("current_child_idx", FromEntry{"current_child_idx"},
                                "which child is the present one, from 0")) {}

 private:
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    const std::size_t begin = Place();
    if (!running()) skipped_ = 0;
    if (running() && begin != at_) nodes[at_]->Reset(tick);  // another node has set its place
    for (at_ = begin; at_ < nodes.size();) {
      const Status status = nodes[at_]->Execute(tick);
      if (status == Status::kRunning) return status;
      if (status == Status::kFailure) {
        ResetChildren(tick);
        return status;
      }
      if (status == Status::kSkipped) ++skipped_;
      ++at_;
      place_.Set(at_ == nodes.size() ? 0 : static_cast<int>(at_));
    }
    ResetChildren(tick);
    return skipped_ == nodes.size() ? Status::kSkipped : Status::kSuccess;
  }

  std::size_t Place() const {
    const int place = place_.Or(0);
    if (place < 0 || static_cast<std::size_t>(place) >= children().size()) {
      throw std::runtime_error("port 'current_child_idx': there is no child " +
                               std::to_string(place) + "; expected 0 to " +
                               std::to_string(children().size() - 1));
    }
    return static_cast<std::size_t>(place);
  }

  InOutPort<int> place_;
  std::size_t at_ = 0;       // of the last tick
  std::size_t skipped_ = 0;  // children, since its begin
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

// Ticks one child at a time, which the services choose:
//
//   RESUMED ── pause ──→ ON_PAUSE ── SUCCESS ──→ PAUSED ── resume ──→ ON_RESUME ── SUCCESS ──→ RESUMED
//
// A call during a transition counts behind it. The next state is ticked in the next tick. Children
// that are left out have succeeded; PAUSED then only waits.
class PauseResumeController : public Control {
 public:
  PauseResumeController(Setup& setup, const Robot& robot)
      : Control(1, 4),
        pause_(setup.Input<std::string>("pause_service_name", "the service that pauses it")),
        resume_(setup.Input<std::string>("resume_service_name", "the service that resumes it")),
        robot_(robot) {}

 private:
  enum Phase : std::uint8_t { kResumed, kPaused, kOnPause, kOnResume };  // as its children

  Status OnTick(Tick& tick) override {
    if (!running()) Begin();
    TakeCalls();
    if (phase_ == kResumed && wants_pause_) GoTo(kOnPause, tick);
    if (phase_ == kPaused && !wants_pause_) GoTo(kOnResume, tick);
    const Status status = TickChild(tick);
    if (status == Status::kFailure || (status == Status::kSuccess && phase_ == kResumed)) {
      ResetChildren(tick);
      return status;
    }
    if (status == Status::kRunning) return status;
    // A child that is skipped has nothing to do.
    if (phase_ == kResumed) return status;
    if (phase_ == kOnPause) GoTo(kPaused, tick);
    if (phase_ == kOnResume) GoTo(kResumed, tick);
    if (phase_ == kPaused) ResetChildren(tick);
    return Status::kRunning;
  }

  void Begin() {
    phase_ = kResumed;
    wants_pause_ = false;
    calls_ = {robot_.Calls(pause_.Get()), robot_.Calls(resume_.Get())};
  }
  // Where both are called in one tick, the pause counts.
  void TakeCalls() {
    const std::array<std::uint64_t, 2> now = {robot_.Calls(pause_.Get()),
                                              robot_.Calls(resume_.Get())};
    if (now[1] != calls_[1]) wants_pause_ = false;
    if (now[0] != calls_[0]) wants_pause_ = true;
    calls_ = now;
  }
  void GoTo(Phase phase, Tick& tick) {
    ResetChildren(tick);
    phase_ = phase;
  }
  Status TickChild(Tick& tick) {
    return phase_ < children().size() ? children()[phase_]->Execute(tick) : Status::kSuccess;
  }

  InPort<std::string> pause_;
  InPort<std::string> resume_;
  const Robot& robot_;
  Phase phase_ = kResumed;
  bool wants_pause_ = false;
  std::array<std::uint64_t, 2> calls_{};  // of pause, of resume
};

}  // namespace

void AddControlNodes(Factory& factory, Robot& robot) {
  AddNode<RecoveryNode>(factory, "RecoveryNode", NodeKind::kControl, false,
                        "Ticks the first child; where it fails, the second one, then the first "
                        "one again. Fails with the second one, or after so many retries.");
  AddNode<PipelineSequence>(factory, "PipelineSequence", NodeKind::kControl, false,
                            "A Sequence that ticks all children up to the present one in each "
                            "tick.");
  AddNode<NonblockingSequence>(factory, "NonblockingSequence", NodeKind::kControl, false,
                               "Ticks all its children in each tick, until all succeed in one. "
                               "Fails with any of them.");
  AddNode<PersistentSequence>(factory, "PersistentSequence", NodeKind::kControl, false,
                              "A Sequence that keeps its place in an entry: it goes on there after "
                              "a halt or a failure.");
  AddNode<RoundRobin>(
      factory, "RoundRobin", NodeKind::kControl, false,
      "Ticks its children in order until one succeeds; the next time in this run of the "
      "tree it goes on behind that one. Fails where all have failed.");
  AddNode<PauseResumeController>(
      factory, "PauseResumeController", NodeKind::kControl, true,
      "Ticks its first child; after a call of the one service its third and then its second, of "
      "the other its fourth and then its first again. Ends with the first; fails with any.",
      robot);
}

}  // namespace musher::tree::nav2
