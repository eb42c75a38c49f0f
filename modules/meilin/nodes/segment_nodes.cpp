#include "musher/modules/meilin/nodes/segment_nodes.hpp"

#include <algorithm>
#include <utility>

namespace musher::meilin {
namespace {

bool HasNode(const tree::Element& element, std::string_view name) {
  const tree::Attribute* id = element.Find("ID");  // of <Action ID="…"/>
  if (element.name == name || (id != nullptr && id->value == name)) return true;
  return std::ranges::any_of(element.children,
                             [name](const auto& child) { return HasNode(child, name); });
}

// The next segment of a queue, which becomes the present one of the mission.
std::optional<Segment> TakeFrom(const tree::InPort<QueuePtr>& port, MissionBoard& board) {
  const QueuePtr* queue = port.Find();
  if (queue == nullptr || *queue == nullptr) {
    board.last_error.Set("Missing meilin segment_queue");
    return std::nullopt;
  }
  std::optional<Segment> next = (*queue)->Pop();
  if (!next) return std::nullopt;
  board.active_action.Set("");
  board.retry_count.Set(0);
  board.last_error.Set("");
  board.segment_index.Set(next->index);
  board.segment_name.Set(next->debug_name);
  board.current_segment.Set(*next);
  board.segment_open.Set(true);
  board.SetState(kSegmentLoaded);
  return next;
}

}  // namespace

using tree::Status;

PlanForms FormsOf(const tree::Document& document) {
  const auto has = [&document](std::string_view name) {
    return std::ranges::any_of(document.trees,
                               [name](const auto& tree) { return HasNode(tree.content, name); });
  };
  return {has("PopNextMeilinSegment"), has("PopNextSegment")};
}

PopNextMeilinSegment::PopNextMeilinSegment(tree::Setup& setup)
    : queue_(setup.OptionalInput<QueuePtr>("queue", "{segment_queue}")),
      segment_type_(setup.Output<std::string>("segment_type", "\"move\", \"fetch\", ...")),
      move_row_(setup.Output<int>("move_row")),
      move_col_(setup.Output<int>("move_col")),
      target_height_mm_(setup.Output<double>("target_height_mm", "of the platform; mm")),
      kfs_row_(setup.Output<int>("kfs_row")),
      kfs_col_(setup.Output<int>("kfs_col")),
      height_diff_(setup.Output<double>("height_diff", "mm")),
      target_yaw_(setup.Output<double>("target_yaw", "rad")),
      board_(setup.board()) {}

Status PopNextMeilinSegment::OnRunning(const tree::Tick&) {
  const std::optional<Segment> next = TakeFrom(queue_, board_);
  if (!next) {
    if (board_.execution_state.Get() != kPlanRejected) board_.SetState(kWaitingSequence);
    return Status::kRunning;
  }
  move_row_.Set(next->move_row);
  move_col_.Set(next->move_col);
  target_height_mm_.Set(next->target_height_mm);
  kfs_row_.Set(next->kfs_row);
  kfs_col_.Set(next->kfs_col);
  height_diff_.Set(next->height_diff);
  target_yaw_.Set(next->target_yaw);
  segment_type_.Set(next->segment_type);
  board_.segment_type.Set(next->segment_type);
  return Status::kSuccess;
}

PopNextSegment::PopNextSegment(tree::Setup& setup)
    : queue_(setup.OptionalInput<QueuePtr>("queue", "{segment_queue}")),
      index_(setup.Output<int>("segment_index")),
      segment_type_(setup.Output<std::string>("segment_type", "\"CLIMB\", ...")),
      debug_name_(setup.Output<std::string>("debug_name")),
      target_x_(setup.Output<double>("target_x", "m")),
      target_y_(setup.Output<double>("target_y", "m")),
      target_yaw_(setup.Output<double>("target_yaw", "rad")),
      max_speed_(setup.Output<double>("max_speed", "m/s")),
      timeout_sec_(setup.Output<double>("timeout_sec", "s")),
      suspension_timeout_sec_(setup.Output<double>("suspension_timeout_sec", "s")),
      climb_mode_(setup.Output<std::uint8_t>("climb_mode")),
      climb_direction_(setup.Output<std::uint8_t>("climb_direction")),
      climb_height_(setup.Output<double>("climb_height", "mm")),
      height_diff_(setup.Output<double>("height_diff", "mm")),
      arm_command_(setup.Output<std::uint8_t>("arm_command")),
      wait_result_(setup.Output<bool>("wait_result")),
      spear_command_(setup.Output<std::uint8_t>("spear_command")),
      board_(setup.board()) {}

Status PopNextSegment::Do(const tree::Tick&) {
  const std::optional<Segment> next = TakeFrom(queue_, board_);
  if (!next) {
    const QueuePtr* queue = queue_.Find();
    if (queue == nullptr || *queue == nullptr) return Status::kFailure;
    board_.SetState(kMissionSuccess);
    return Status::kFailure;  // there is nothing to do for the nodes behind it
  }
  index_.Set(next->index);
  debug_name_.Set(next->debug_name);
  target_x_.Set(next->target_x);
  target_y_.Set(next->target_y);
  target_yaw_.Set(next->target_yaw);
  max_speed_.Set(next->max_speed);
  timeout_sec_.Set(next->timeout_sec);
  suspension_timeout_sec_.Set(next->suspension_timeout_sec);
  climb_mode_.Set(static_cast<std::uint8_t>(next->climb_mode));
  climb_direction_.Set(static_cast<std::uint8_t>(next->climb_direction));
  climb_height_.Set(next->climb_height);
  height_diff_.Set(next->height_diff);
  arm_command_.Set(static_cast<std::uint8_t>(next->arm_command));
  wait_result_.Set(next->wait_result);
  spear_command_.Set(static_cast<std::uint8_t>(next->spear_command));
  segment_type_.Set(next->segment_type);
  board_.segment_type.Set(next->segment_type);
  return Status::kSuccess;
}

SwitchSegmentType::SwitchSegmentType(tree::Setup& setup)
    : type_(setup.OptionalInput<std::string>("segment_type", "missing: of the present segment")),
      board_(setup.board()) {}

Status SwitchSegmentType::OnTick(tree::Tick& tick) {
  if (ticked_ == nullptr || !ticked_->running()) {
    const std::string type = type_.Or(board_.segment_type.Get());
    ticked_ = nullptr;
    for (std::size_t i = 0; i < children().size(); ++i) {
      const std::string& name = child_names()[i];
      if (name == type) {
        ticked_ = children()[i];
        break;
      }
      if (name == "default") ticked_ = children()[i];
    }
  }
  if (ticked_ == nullptr) return Status::kFailure;
  const Status status = ticked_->Execute(tick);
  if (status != Status::kRunning) {
    ResetChildren(tick);
    ticked_ = nullptr;
  }
  return status;
}

void SwitchSegmentType::OnHalt(tree::Tick& tick) {
  ticked_ = nullptr;
  ResetChildren(tick);
}

ForEachSegment::ForEachSegment(tree::Setup& setup)
    : stop_type_(setup.OptionalInput<std::string>(
          "stop_type",
          "the type of the segment after which it succeeds; missing: EXIT, PLAN_DONE")),
      board_(setup.board()) {}

Status ForEachSegment::OnTick(tree::Tick& tick) {
  const Status status = TickChild(tick);
  if (status != Status::kSuccess) return status;
  board_.segment_open.Set(false);
  const std::string type = board_.segment_type.Get();
  const std::string* stop_type = stop_type_.Find();
  const bool stops =
      stop_type != nullptr ? type == *stop_type : type == "EXIT" || type == kPlanDoneType;
  return stops ? Status::kSuccess : Status::kRunning;
}

RetrySegment::RetrySegment(tree::Setup& setup)
    : attempts_(setup.Input<int>("num_attempts", 3, "negative: without end")),
      board_(setup.board()) {}

Status RetrySegment::OnTick(tree::Tick& tick) {
  if (!running()) failed_ = 0;
  const Status status = TickChild(tick);
  if (status != Status::kFailure) return status;
  ++failed_;
  board_.retry_count.Set(failed_);
  const int most = attempts_.Get();
  if (most >= 0 && failed_ >= most) {
    board_.SetState(kActionFailed);
    return Status::kFailure;
  }
  board_.SetState(kActionRetrying);
  return Status::kRunning;
}

}  // namespace musher::meilin
