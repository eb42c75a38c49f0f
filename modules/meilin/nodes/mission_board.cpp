#include "musher/modules/meilin/nodes/mission_board.hpp"

namespace musher::meilin {

MissionBoard::MissionBoard(tree::Board& board)
    : queue(board, "segment_queue"),
      plan_id(board, "plan_id"),
      segment_index(board, "current_segment_index"),
      segment_type(board, "segment_type"),
      segment_name(board, "segment_debug_name"),
      segment_json(board, "segment_json"),
      current_segment(board, "current_segment"),
      segment_open(board, "segment_open"),
      active_action(board, "active_action"),
      retry_count(board, "retry_count"),
      last_error(board, "last_error"),
      refused_plan(board, "refused_plan"),
      execution_state(board, "execution_state"),
      arm_state(board, "arm_state"),
      row(board, "meilin_current_row"),
      col(board, "meilin_current_col"),
      height_mm(board, "meilin_current_height"),
      yaw_rad(board, "meilin_current_yaw"),
      is_cell_center(board, "meilin_pose_is_cell_center"),
      suspension_offset_mm(board, "meilin_suspension_offset"),
      climbing(board, "meilin_climbing"),
      taken(board, "meilin_taken"),
      dock_trues(board, "meilin_dock_trues"),
      pose_received(board, "meilin_pose_received"),
      pose_x_m(board, "meilin_pose_x"),
      pose_y_m(board, "meilin_pose_y"),
      pose_yaw_rad(board, "meilin_pose_yaw"),
      pose_last_update_s(board, "meilin_pose_last_update_sec") {}

void MissionBoard::Begin(const Settings& settings) {
  queue.Set(std::make_shared<SegmentQueue>());
  plan_id.Set("");
  segment_index.Set(-1);
  segment_type.Set("");
  segment_name.Set("");
  segment_json.Set("");
  segment_open.Set(false);
  active_action.Set("");
  retry_count.Set(0);
  last_error.Set("");
  SetState(kWaitingPlan);
  arm_state.Set(false);
  row.Set(settings.initial_cell.row);
  col.Set(settings.initial_cell.col);
  height_mm.Set(settings.initial_height_mm);
  yaw_rad.Set(settings.initial_yaw_rad);
  is_cell_center.Set(true);
  suspension_offset_mm.Set(0);
  climbing.Set(false);
  taken.Set(0);
  dock_trues.Set(-1);
  pose_received.Set(false);
  pose_x_m.Set(0);
  pose_y_m.Set(0);
  pose_yaw_rad.Set(0);
  pose_last_update_s.Set(0);
}

void MissionBoard::Fail(const std::string& error) {
  last_error.Set(error);
  SetState(kActionFailed);
}

}  // namespace musher::meilin
