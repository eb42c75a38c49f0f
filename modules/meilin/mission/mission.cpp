#include "musher/modules/meilin/mission/mission.hpp"

#include <utility>

#include "musher/modules/meilin/nodes/place.hpp"

namespace musher::meilin {

using tree::Status;

Result<> Mission::Fill(tree::Board& board) {
  root_ = &board;
  board_.emplace(board);
  for (const auto& [key, value] : match_.entries) {
    if (Result<> set = board.Set(key, value); !set) return set;
  }
  const Pose2 enter = settings_.grid.CentrePose(settings_.initial_cell, settings_.initial_yaw_rad);
  const std::pair<const char*, double> entry[] = {{"enter_target_x", enter.x_m},
                                                  {"enter_target_y", enter.y_m},
                                                  {"enter_target_yaw", enter.yaw_rad},
                                                  {"enter_max_speed", 0.3},
                                                  {"enter_timeout_sec", settings_.align_timeout_s}};
  for (const auto& [key, value] : entry) {
    if (Result<> set = board.Set(key, value); !set) return set;
  }
  Begin();
  return Ok();
}

void Mission::Begin() {
  board_->Begin(settings_);
  static_cast<void>(root_->Set("prepare_done", false));
  ended_ = failed_ = restart_ = stop_ = false;
}

void Mission::BeforeTick() {
  const std::optional<PoseFix> pose = robot_.pose();
  board_->pose_received.Set(pose.has_value());
  board_->arm_state.Set(robot_.arm_idle().value.value_or(false));
  if (!pose) return;
  board_->pose_x_m.Set(pose->x_m);
  board_->pose_y_m.Set(pose->y_m);
  board_->pose_yaw_rad.Set(pose->yaw_rad);
  const std::chrono::duration<double> at = pose->at.time_since_epoch();
  board_->pose_last_update_s.Set(at.count());
}

void Mission::AfterTick(Status status, const std::string& fault) {
  if (status == Status::kIdle || status == Status::kRunning) return;
  ended_ = true;
  if (status == Status::kSuccess) board_->last_error.Set("");
  if (status == Status::kFailure && state() != kMissionSuccess) {
    Fail(fault.empty() ? "the tree has failed" : fault);
  }
}

void Mission::Fail(const std::string& otherwise) {
  failed_ = true;
  if (board_->last_error.Get().empty()) board_->last_error.Set(otherwise);
  board_->segment_open.Set(false);
  board_->SetState(kMissionFailed);
}

void Mission::OnPause() {
  if (!board_ || ended_ || !board_->segment_open.Get()) return;
  if (state() == kActionFailed) {  // halted during a climb
    ended_ = stop_ = true;
    return Fail("");
  }
  board_->segment_open.Set(false);
  const QueuePtr queue = board_->queue.Get();
  if (queue == nullptr) return;
  std::vector<Segment> segments = {board_->current_segment.Get()};
  while (auto next = queue->Pop()) segments.push_back(*std::move(next));
  queue->Replace(std::move(segments), queue->plan_id());
}

PlanStart Mission::StartAt(Time now) const {
  const MissionBoard& board = *board_;
  if (!ended_ && board.segment_open.Get()) {
    const Segment segment = board.current_segment.Get();
    if (segment.segment_type == kMoveType) {
      return {{segment.move_row, segment.move_col}, segment.target_height_mm, segment.target_yaw};
    }
    const bool fetches = segment.segment_type == kFetchType;
    return {{board.row.Get(), board.col.Get()},
            board.height_mm.Get(),
            fetches ? segment.target_yaw : board.yaw_rad.Get(),
            !fetches};
  }
  const PlanStart initial{settings_.initial_cell, settings_.initial_height_mm,
                          settings_.initial_yaw_rad, true};
  std::optional<Pose2> live;
  if (const auto pose = FreshPose(robot_, settings_, now)) {
    live = Pose2{pose->x_m, pose->y_m, pose->yaw_rad};
  }
  return StartOf(settings_.grid, initial, live);
}

bool Mission::OfferPlan(const msg::Float32MultiArray& plan, Time now) {
  PlanRules rules;
  rules.grid = settings_.grid;
  rules.yaw_tolerance_rad = settings_.yaw_tolerance_rad;
  rules.height_tolerance_mm = settings_.height_tolerance_mm;
  rules.normal_height_mm = settings_.normal_height_mm;
  PlanReading reading = ReadActionSequence(plan, rules, StartAt(now));
  if (!reading.ok()) {
    RefusePlan(reading.message());
    return false;
  }
  Accept(std::move(reading.segments), PlanIdOf(++plans_));
  return true;
}

void Mission::OfferSegments(std::vector<Segment> segments, const std::string& plan_id) {
  Accept(std::move(segments), plan_id);
}

void Mission::RefusePlan(const std::string& why) {
  board_->last_error.Set(why);
  board_->SetState(kPlanRejected);
}

void Mission::Accept(std::vector<Segment> segments, const std::string& plan_id) {
  board_->queue.Set(std::make_shared<SegmentQueue>(std::move(segments), plan_id));
  board_->plan_id.Set(plan_id);
  board_->segment_index.Set(-1);
  board_->last_error.Set("");
  board_->SetState(kPlanReady);
  restart_ = ended_;
  ended_ = failed_ = stop_ = false;
}

Result<> Mission::Command(const std::string& command) {
  if (command != "RESET") {
    return Error{kCodeFailed, "there is no command '" + command + "'; expected RESET"};
  }
  Begin();
  restart_ = true;
  return Ok();
}

bool Mission::WantsPlan() const {
  if (failed_) return true;
  if (board_ && board_->segment_open.Get()) return false;  // also while a refused one is named
  const std::string now = state();
  return now == kWaitingSequence || now == kWaitingPlan || now == kIdle || now == kPlanRejected;
}

std::string Mission::state() const {
  return board_ ? board_->execution_state.Get() : kIdle;
}
std::string Mission::last_error() const {
  return board_ ? board_->last_error.Get() : "";
}
std::string Mission::plan_id() const {
  return board_ ? board_->plan_id.Get() : "";
}

}  // namespace musher::meilin
