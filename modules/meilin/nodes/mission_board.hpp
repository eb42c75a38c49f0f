#pragma once
// The blackboard of a match, as nodes and the mission use it: keys of the main tree, which are
// found once, when the tree is built. The keys are those of docs and trees: "execution_state".
//
// Threads: one at a time, like the tree.

#include <cstdint>
#include <memory>
#include <string>

#include "musher/behavior/tree/board.hpp"
#include "musher/behavior/tree/port.hpp"
#include "musher/modules/meilin/nodes/settings.hpp"
#include "musher/modules/meilin/plan/segment_queue.hpp"

namespace musher::meilin {

using QueuePtr = std::shared_ptr<SegmentQueue>;

// Values of execution_state.
inline constexpr const char* kWaitingStart = "WAITING_START";
inline constexpr const char* kPaused = "PAUSED";
inline constexpr const char* kWaitingPlan = "WAITING_PLAN";
inline constexpr const char* kWaitingSequence = "WAITING_MF_ACTION_SEQ";
inline constexpr const char* kPlanReady = "MF_PLAN_READY";
inline constexpr const char* kSegmentLoaded = "SEGMENT_LOADED";
inline constexpr const char* kActionRunning = "ACTION_RUNNING";
inline constexpr const char* kActionSuccess = "ACTION_SUCCESS";
inline constexpr const char* kActionFailed = "ACTION_FAILED";
inline constexpr const char* kActionRetrying = "ACTION_RETRYING";
inline constexpr const char* kMeilinSuccess = "MEILIN_SUCCESS";
inline constexpr const char* kMissionSuccess = "MISSION_SUCCESS";
inline constexpr const char* kMissionFailed = "MISSION_FAILED";
inline constexpr const char* kPlanRejected = "PLAN_REJECTED";
inline constexpr const char* kConfigLoaded = "CONFIG_LOADED";
inline constexpr const char* kConfigError = "CONFIG_ERROR";
inline constexpr const char* kIdle = "IDLE";

// One key. A value that was set with another type is converted.
template <class T>
class Slot {
 public:
  Slot(tree::Board& board, std::string_view key) : entry_(&board.At("@" + std::string(key))) {}

  T Get() const {
    if (const T* value = entry_->value.template As<T>()) return *value;
    tree::Value made;
    if (entry_->value.empty() || !made.SetAs(*tree::TypeOf<T>(), entry_->value)) return T{};
    return *made.template As<T>();
  }
  void Set(const T& value) {
    const Result<> set = entry_->Set(value);
    if (!set) tree::internal::FailWrite(entry_->key, *entry_, set.error());
  }
  bool empty() const { return entry_->value.empty(); }

 private:
  tree::Entry* entry_;
};

struct MissionBoard {
  explicit MissionBoard(tree::Board& board);

  // The values at the start of a match; the queue is empty. The reason of a refused plan stays.
  void Begin(const Settings& settings);
  void SetState(const char* state) { execution_state.Set(state); }
  // last_error and ACTION_FAILED.
  void Fail(const std::string& error);
  void Take(Cell cell) { taken.Set(taken.Get() | 1 << (cell.row * kCols + cell.col)); }

  Slot<QueuePtr> queue;
  Slot<std::string> plan_id;
  Slot<int> segment_index;
  Slot<std::string> segment_type;
  Slot<std::string> segment_name;
  Slot<std::string> segment_json;
  Slot<Segment> current_segment;  // that was taken from the queue last
  Slot<bool> segment_open;        // it is not done
  Slot<std::string> active_action;
  Slot<int> retry_count;
  Slot<std::string> last_error;
  Slot<std::string> refused_plan;  // why the last plan was refused; "": it was not
  Slot<std::string> execution_state;
  Slot<bool> arm_state;
  // Where the robot is by what it has done. Used when no fresh pose is there.
  Slot<int> row;
  Slot<int> col;
  Slot<double> height_mm;  // of the platform below it
  Slot<double> yaw_rad;
  Slot<bool> is_cell_center;
  Slot<double> suspension_offset_mm;  // of the wheels, above their normal height
  Slot<bool> climbing;                // a climb was begun, and has not ended
  Slot<int> taken;       // bits of the cells whose boxes were taken: 1 << (3 row + col)
  Slot<int> dock_trues;  // messages of a ready partner before the dock; -1: no dock
  // The live pose.
  Slot<bool> pose_received;
  Slot<double> pose_x_m;
  Slot<double> pose_y_m;
  Slot<double> pose_yaw_rad;
  Slot<double> pose_last_update_s;
};

}  // namespace musher::meilin
