#pragma once
// The nodes that take a plan apart:
//
//   PopNextMeilinSegment  queue -> segment_type move_row move_col target_height_mm kfs_row kfs_col
//                         height_diff target_yaw
//                         RUNNING as long as there is no segment; execution_state is
//                         WAITING_MF_ACTION_SEQ then, or keeps PLAN_REJECTED
//   PopNextSegment        queue -> the fields of an old plan; an empty queue: MISSION_SUCCESS
//   SwitchSegmentType     segment_type: ticks the child whose attribute `name` is that type, or
//                         else the one with the name "default", to its end
//   ForEachSegment        stop_type (missing: "EXIT" and "PLAN_DONE", with which no plan goes on):
//                         repeats its child until a segment of that type is done
//   RetrySegment          num_attempts 3 (negative: without end): repeats a child that fails
//
// A queue is a std::shared_ptr<SegmentQueue> (plan/segment_queue.hpp). A segment that was taken and
// is not done is on the key "current_segment", and "segment_open" is true.
//
// Threads: one at a time, like the tree.

#include <cstdint>
#include <string>

#include "musher/behavior/tree/document.hpp"
#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"
#include "musher/modules/meilin/nodes/mission_board.hpp"

namespace musher::meilin {

// The plans that a tree can run.
struct PlanForms {
  bool sequences = true;  // of mf_action_seq: it has a PopNextMeilinSegment
  bool segments = true;   // of the old form: it has a PopNextSegment
};
PlanForms FormsOf(const tree::Document& document);

class PopNextMeilinSegment final : public tree::StatefulAction {
 public:
  explicit PopNextMeilinSegment(tree::Setup& setup);

 private:
  tree::Status OnStart(const tree::Tick& tick) override { return OnRunning(tick); }
  tree::Status OnRunning(const tree::Tick& tick) override;

  tree::InPort<QueuePtr> queue_;
  tree::OutPort<std::string> segment_type_;
  tree::OutPort<int> move_row_;
  tree::OutPort<int> move_col_;
  tree::OutPort<double> target_height_mm_;
  tree::OutPort<int> kfs_row_;
  tree::OutPort<int> kfs_col_;
  tree::OutPort<double> height_diff_;
  tree::OutPort<double> target_yaw_;
  MissionBoard board_;
};

class PopNextSegment final : public tree::Action {
 public:
  explicit PopNextSegment(tree::Setup& setup);

 private:
  tree::Status Do(const tree::Tick& tick) override;

  tree::InPort<QueuePtr> queue_;
  tree::OutPort<int> index_;
  tree::OutPort<std::string> segment_type_;
  tree::OutPort<std::string> debug_name_;
  tree::OutPort<double> target_x_;
  tree::OutPort<double> target_y_;
  tree::OutPort<double> target_yaw_;
  tree::OutPort<double> max_speed_;
  tree::OutPort<double> timeout_sec_;
  tree::OutPort<double> suspension_timeout_sec_;
  tree::OutPort<std::uint8_t> climb_mode_;
  tree::OutPort<std::uint8_t> climb_direction_;
  tree::OutPort<double> climb_height_;
  tree::OutPort<double> height_diff_;
  tree::OutPort<std::uint8_t> arm_command_;
  tree::OutPort<bool> wait_result_;
  tree::OutPort<std::uint8_t> spear_command_;
  MissionBoard board_;
};

class SwitchSegmentType final : public tree::Control {
 public:
  explicit SwitchSegmentType(tree::Setup& setup);

 private:
  tree::Status OnTick(tree::Tick& tick) override;
  void OnHalt(tree::Tick& tick) override;

  tree::InPort<std::string> type_;
  MissionBoard board_;
  tree::Node* ticked_ = nullptr;
};

class ForEachSegment final : public tree::Decorator {
 public:
  explicit ForEachSegment(tree::Setup& setup);

 private:
  tree::Status OnTick(tree::Tick& tick) override;

  tree::InPort<std::string> stop_type_;
  MissionBoard board_;
};

class RetrySegment final : public tree::Decorator {
 public:
  explicit RetrySegment(tree::Setup& setup);

 private:
  tree::Status OnTick(tree::Tick& tick) override;

  tree::InPort<int> attempts_;
  MissionBoard board_;
  int failed_ = 0;
};

}  // namespace musher::meilin
