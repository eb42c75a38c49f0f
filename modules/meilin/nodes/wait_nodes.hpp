#pragma once
// The nodes that wait or look at the blackboard:
//
//   WaitArmIdle        timeout_sec 30 -> message: the arm has nothing to do: a message of the arm
//                      says so, of the last second or a new one
//   WaitForR1Signal    timeout_sec 60: the partner is ready: a true came after the dock was begun
//                      (SpearAction with command 3), else after the node has started, and no false
//                      after it. RUNNING until then, FAILURE after the limit
//   WaitSeconds        seconds
//   SetDebugStatus     execution_state active_action last_error retry_count: those that are given
//   IsSegmentType      segment_type expected_type
//   IsStringEmpty, IsStringNonEmpty   value
//
// Limits are seconds of the tree's clock; 0 is none. Which topics the two signals are is said by
// the mission's config: a port signal_topic is accepted where it is that of the config.
//
// Threads: one at a time, like the tree.

#include <cstdint>
#include <string>

#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"
#include "musher/modules/meilin/nodes/mission_board.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin {

class WaitArmIdle final : public tree::StatefulAction {
 public:
  WaitArmIdle(tree::Setup& setup, Robot& robot);

 private:
  tree::Status OnStart(const tree::Tick& tick) override;
  tree::Status OnRunning(const tree::Tick& tick) override { return Look(tick.now); }
  tree::Status Look(Time now);

  tree::InPort<double> timeout_s_;
  tree::OutPort<std::string> message_;
  Robot& robot_;
  MissionBoard board_;
  Time begun_{};
};

class WaitForR1Signal final : public tree::Condition {
 public:
  WaitForR1Signal(tree::Setup& setup, Robot& robot);

 private:
  tree::Status Evaluate(const tree::Tick& tick) override;

  tree::InPort<std::string> topic_;
  tree::InPort<double> timeout_s_;
  Robot& robot_;
  MissionBoard board_;
  Time begun_{};
  std::uint64_t trues_ = 0;  // that do not count
};

class WaitSeconds final : public tree::StatefulAction {
 public:
  explicit WaitSeconds(tree::Setup& setup);

 private:
  tree::Status OnStart(const tree::Tick& tick) override;
  tree::Status OnRunning(const tree::Tick& tick) override;

  tree::InPort<double> seconds_;
  Time begun_{};
};

class SetDebugStatus final : public tree::Action {
 public:
  explicit SetDebugStatus(tree::Setup& setup);

 private:
  tree::Status Do(const tree::Tick& tick) override;

  tree::InPort<std::string> execution_state_;
  tree::InPort<std::string> active_action_;
  tree::InPort<std::string> last_error_;
  tree::InPort<int> retry_count_;
  MissionBoard board_;
};

class IsSegmentType final : public tree::Condition {
 public:
  explicit IsSegmentType(tree::Setup& setup);

 private:
  tree::Status Evaluate(const tree::Tick& tick) override;

  tree::InPort<std::string> type_;
  tree::InPort<std::string> expected_;
};

template <bool kEmpty>
class IsString final : public tree::Condition {
 public:
  explicit IsString(tree::Setup& setup)
      : value_(setup.OptionalInput<std::string>("value", "missing: empty")) {}

 private:
  tree::Status Evaluate(const tree::Tick&) override {
    const std::string* value = value_.Find();
    const bool empty = value == nullptr || value->empty();
    return empty == kEmpty ? tree::Status::kSuccess : tree::Status::kFailure;
  }

  tree::InPort<std::string> value_;
};

}  // namespace musher::meilin
