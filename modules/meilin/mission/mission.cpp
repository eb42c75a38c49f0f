#include "musher/modules/meilin/mission/mission.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "musher/modules/meilin/nodes/edge.hpp"
#include "musher/modules/meilin/nodes/place.hpp"
#include "musher/modules/meilin/plan/segments_json.hpp"

namespace musher::meilin {
namespace {

constexpr double kMovedMm = 15;  // of a wheel

using tree::Status;

// The parts of a full match, in their order: keys of the blackboard that its tree sets.
constexpr std::array<const char*, 12> kParts = {
    "prepare_spear_done", "prepare_grasp_done", "prepare_align_done", "prepare_dock_done",
    "prepare_done",       "meilin_done",        "final_move2_done",   "final_rack_done",
    "final_mid_done",     "final_high_done",    "final_rest_done",    "final_done"};
constexpr std::size_t kPrepareParts = 5;  // the first ones
constexpr const char* kPrepared = "prepare_done";
constexpr const char* kMeilinDone = "meilin_done";

bool Waits(const std::string& state) {
  return state == kWaitingSequence || state == kWaitingPlan || state == kIdle ||
         state == kPlanRejected;
}

// For a file of UTF-8.
std::string Plain(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

}  // namespace

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
  board_->SetState(kWaitingStart);
  SetDone({});
  ForgetPlan();
  progress_.wheels_mm.clear();
  begun_ = ended_ = failed_ = restart_ = stop_ = false;
}

void Mission::SetDone(const std::set<std::string>& done) {
  for (const char* part : kParts) static_cast<void>(root_->Set(part, done.count(part) > 0));
}

std::set<std::string> Mission::DoneNow() const {
  std::set<std::string> done;
  for (const char* part : kParts) {
    const Result<bool> set = root_->Get<bool>(part);
    if (set && set.value()) done.insert(part);
  }
  return done;
}

void Mission::ForgetPlan() {
  old_.clear();
  progress_.segments.clear();
  progress_.plan.clear();
  progress_.next = 0;
  progress_.begun = false;
}

std::int64_t Mission::steps() const {
  return static_cast<std::int64_t>(old_.empty() ? progress_.plan.size() : old_.size());
}

// Each change is written to the disk: only what has visibly moved.
void Mission::NoteWheels(Time now) {
  const std::optional<Wheels> wheels = FreshWheels(robot_, now);
  if (!wheels) return;
  std::vector<double>& noted = progress_.wheels_mm;
  bool moved = noted.empty();
  for (std::size_t i = 0; i < noted.size(); ++i) {
    moved = moved || std::abs(noted[i] - wheels->mm.at(i)) >= kMovedMm;
  }
  if (!moved) return;
  noted.clear();
  for (const double mm : wheels->mm) noted.push_back(std::round(mm));
}

void Mission::BeforeTick(Time now) {
  NoteWheels(now);
  UpdateStart(now);
  const std::optional<PoseFix> pose = robot_.pose();
  board_->pose_received.Set(pose.has_value());
  board_->arm_state.Set(robot_.arm_idle().value.value_or(false));
  if (!pose) return;
  board_->pose_x_m.Set(pose->x_m);
  board_->pose_y_m.Set(pose->y_m);
  board_->pose_yaw_rad.Set(pose->yaw_rad);
  const std::chrono::duration<double> at = pose->at.time_since_epoch();
  board_->pose_last_update_s.Set(at.count());
  const bool outside = pose->IsFresh(now, settings_.pose_timeout_s) && !PlaceOf(*pose, settings_);
  if (autostart_ && !begun_ && outside && SavedProgress().empty()) {
    static_cast<void>(Start(kFullRegion, now));  // else with the next tick
  }
}

void Mission::AfterTick(Status status, const std::string& fault, Time now) {
  if (!IsRunning()) return;
  NoteProgress();
  if (status == Status::kIdle || status == Status::kRunning) return;
  ended_ = true;
  if (status == Status::kFailure && state() != kMissionSuccess) {
    return Fail(fault.empty() ? "the tree has failed" : fault);
  }
  board_->last_error.Set("");
  if (state() == kSegmentLoaded) board_->SetState(kMissionSuccess);  // PLAN_DONE was the last one
  if (!old_.empty()) ForgetPlan();
  const std::optional<Wheels> wheels = FreshWheels(robot_, now);
  if (wheels && LongestMm(*wheels) > std::max(kOutWheelMm, settings_.normal_height_mm + 40)) {
    return Fail("the match has come to its end with its wheels out: " + WheelsText(*wheels));
  }
  progress_.last_end = state();
}

// The first step of the plan that is not done.
void Mission::NoteProgress() {
  const std::int64_t index = board_->segment_index.Get();
  const bool open = board_->segment_open.Get();
  if (index < 0 || steps() == 0) return;
  progress_.next = std::clamp<std::int64_t>(open ? index : index + 1, 0, steps());
  progress_.begun = true;
}

void Mission::Fail(const std::string& otherwise) {
  failed_ = true;
  std::string error = board_->last_error.Get();
  if (error.empty()) error = otherwise;
  if (board_->segment_open.Get() && steps() > 0) {
    error = fmt::format("segment {} of {}, {}: {}", board_->segment_index.Get() + 1, steps(),
                        board_->segment_name.Get(), error);
  }
  board_->last_error.Set(error);
  board_->segment_open.Set(false);
  board_->SetState(kMissionFailed);
  progress_.last_end = std::string(kMissionFailed) + ": " + error;
}

void Mission::RefuseLateStart(const char* why) {
  if (auto late = std::exchange(late_start_, std::nullopt)) {
    late->done(Error{kCodeStateInvalid, why});
  }
}

void Mission::OnPause() {
  RefuseLateStart("the robot left Active before the match could begin");
  if (!board_ || !IsRunning()) return;
  // Halted during a climb, or on the way off the edge behind a segment that has failed.
  if (board_->segment_open.Get() && !board_->last_error.Get().empty()) {
    ended_ = stop_ = true;
    return Fail("");
  }
  board_->SetState(kPaused);
  if (!board_->segment_open.Get()) return;
  board_->segment_open.Set(false);
  board_->segment_index.Set(board_->segment_index.Get() - 1);  // of those that are done
  const QueuePtr queue = board_->queue.Get();
  if (queue == nullptr) return;
  std::vector<Segment> segments = {board_->current_segment.Get()};
  while (auto next = queue->Pop()) segments.push_back(*std::move(next));
  queue->Replace(std::move(segments), queue->plan_id());
}

void Mission::Stand(const char* why) {
  RefuseLateStart(why);
  const bool ran = IsRunning();
  OnPause();
  begun_ = autostart_ = false;
  progress_.stands = true;
  if (ran && !failed_) board_->SetState(kWaitingStart);
}

// --- the start ---

std::set<std::string> Mission::DoneFor(const std::string& region) const {
  if (region.empty()) return DoneNow();
  if (region == kFullRegion) return {};
  std::set<std::string> done(kParts.begin(), kParts.begin() + kPrepareParts);
  if (region == kFinalRegion) done.insert(kMeilinDone);
  return done;
}

// Where the first drive of a full match goes; nothing: it does not begin with one.
std::optional<Point2> Mission::NextTarget(const std::set<std::string>& done) const {
  const auto at = [this](const std::string& prefix) -> std::optional<Point2> {
    const Result<double> x_m = root_->Get<double>(prefix + "_target_x");
    const Result<double> y_m = root_->Get<double>(prefix + "_target_y");
    if (!x_m || !y_m) return std::nullopt;
    return Point2{x_m.value(), y_m.value()};
  };
  const auto open = [&done](const char* part) { return done.count(part) == 0; };
  if (open(kPrepared)) {
    if (open("prepare_spear_done")) return at("prepare_spear_prep");
    if (open("prepare_grasp_done")) return std::nullopt;
    if (open("prepare_align_done")) return at("prepare_align");
    return open("prepare_dock_done") ? std::nullopt : at("enter");
  }
  if (open(kMeilinDone)) return std::nullopt;
  if (open("final_move2_done")) return at("final_move2");
  return open("final_rack_done") ? at("final_final_move2") : std::nullopt;
}

// Of where the robot is, for a match that goes on behind these parts.
std::string Mission::WhyNotThere(const std::set<std::string>& done, Time now) const {
  if (const int sequence = robot_.suspension_state(); sequence != 0) {
    return fmt::format("the suspension is in state {} of a sequence, which must end first",
                       sequence);
  }
  const std::optional<Wheels> wheels = FreshWheels(robot_, now);
  if (!wheels && !progress_.wheels_mm.empty()) {
    Wheels last;
    std::ranges::copy(progress_.wheels_mm, last.mm.begin());
    if (LongestMm(last) > kOutWheelMm) {
      return "the wheels do not report, and the last that they reported is " + WheelsText(last);
    }
  }
  const std::optional<PoseFix> pose = FreshPose(robot_, settings_, now);
  const bool field =
      match_.entries.empty() || (done.count(kPrepared) > 0 && done.count(kMeilinDone) == 0);
  if (!pose)
    return board_->climbing.Get() ? "a climb was not ended, and there is no fresh pose" : "";
  const Point2 here{pose->x_m, pose->y_m};
  const OffEdge way = PlanOffEdge(settings_, *pose, wheels);
  if (!way.unclear.empty()) return way.unclear;
  if (!forms_.sequences) return "";  // no drive begins without a plan, whose ways are checked
  const std::optional<RobotPlace> place = PlaceOf(*pose, settings_);
  if (field) {
    if (place) return "";
    return fmt::format("the robot is outside the field, x {:.2f} m, y {:.2f} m: put it on a cell",
                       pose->x_m, pose->y_m);
  }
  if (way.on_edge) {
    return way.text + ": it comes off with the region " + kMeilinRegion;
  }
  const std::optional<Point2> target = NextTarget(done);
  if (!target) return "";
  const double height_mm = place ? place->height_mm : 0;
  const auto other =
      settings_.grid.OtherHeightOnLine(here, *target, height_mm, settings_.height_tolerance_mm);
  if (!other && height_mm <= settings_.height_tolerance_mm) return "";
  return fmt::format(
      "the robot stands at x {:.2f} m, y {:.2f} m, {:g} mm high: the way to x {:.2f} "
      "m, y {:.2f} m crosses {}",
      pose->x_m, pose->y_m, height_mm, target->x_m, target->y_m,
      CellText(other.value_or(place ? place->cell : Cell{})));
}

bool Mission::HasRest() const {
  if (!old_.empty()) return true;
  return progress_.next < steps() && DoneNow().count(kMeilinDone) == 0;
}

Result<std::vector<Segment>> Mission::RemainingSegments(Time now) const {
  if (!old_.empty()) return OldRest(now);
  PlanReading reading = CheckRest(now);
  if (!reading.ok()) return Error{kCodeFailed, reading.message()};
  return std::move(reading.segments);
}

// Without a climb whose end is where the robot is, or to where it comes off the edge.
Result<std::vector<Segment>> Mission::OldRest(Time now) const {
  const Result<std::optional<Point2>> at = PointAt(now);
  if (!at) return at.error();
  std::vector<Segment> rest(old_.begin() + progress_.next, old_.end());
  const bool there =
      at.value() && !rest.empty() && IsClimbTo(rest.front(), settings_.grid, *at.value());
  if (there) rest.erase(rest.begin());
  const std::string why = WhyNoWay(rest, settings_.grid, settings_.height_tolerance_mm, at.value());
  if (!why.empty()) return Error{kCodeFailed, why};
  return rest;
}

PlanReading Mission::CheckRest(Time now) const {
  PlanReading reading;
  const Result<PlanStart> start = StartAt(now);
  if (!start) {
    reading.faults.push_back({0, start.error().message});
    return reading;
  }
  std::vector<PlanStep> rest(progress_.plan.begin() + progress_.next, progress_.plan.end());
  int base = static_cast<int>(progress_.next);
  if (!rest.empty() && rest.front().fetch && !start.value().at_centre) {
    const PlanStart& here = start.value();
    rest.insert(rest.begin(), {false, here.cell, here.height_mm, here.yaw_rad});
    --base;
  }
  reading = ReadActionSequence(ToActionSequence(rest), Rules(), start.value());
  for (Segment& segment : reading.segments) segment.index = std::max(0, segment.index + base);
  return reading;
}

std::string Mission::WhyNot(const std::string& region, Time now) const {
  if (IsRunning()) return "the match runs: " + state() + "; RESET it first";
  const bool known = region == kFullRegion || region == kMeilinRegion || region == kFinalRegion;
  if (!known && !region.empty()) {
    return "there is no region '" + region.substr(0, 40) + "'; expected full, meilin or final";
  }
  if (region.empty() && GoesOnWith().empty()) {
    return "there is nothing to go on with; expected full, meilin or final";
  }
  const std::set<std::string> done = DoneFor(region);
  if (std::string why = WhyNotThere(done, now); !why.empty()) return why;
  if (!region.empty() || !HasRest()) return "";
  const Result<std::vector<Segment>> rest = RemainingSegments(now);
  if (rest) return "";
  return "the rest of plan " + progress_.plan_id +
         " does not fit where the robot is: " + rest.error().message +
         "; start meilin, and send another plan";
}

std::string Mission::GoesOnWith() const {
  if (!board_ || IsRunning()) return "";
  const std::set<std::string> done = DoneNow();
  if (done.count("final_done") > 0) return "";
  const bool field = match_.entries.empty() || !old_.empty() || done.count(kPrepared) > 0;
  if (HasRest() && field) {
    const auto next = static_cast<std::size_t>(progress_.next);
    const std::string plan = "plan " + progress_.plan_id;
    if (progress_.next >= steps()) return plan + ", all of whose segments are done";
    std::string step;
    if (old_.empty()) {
      step = (progress_.plan.at(next).fetch ? "fetch " : "move ") +
             CellText(progress_.plan.at(next).cell);
    } else {
      step = old_.at(next).segment_type;
    }
    return fmt::format("{} at segment {} of {}, {}", plan, next + 1, steps(), step);
  }
  if (done.empty()) return "";
  const auto* part =
      std::ranges::find_if(kParts, [&done](const char* each) { return done.count(each) == 0; });
  const std::string name = part == kParts.end() ? "" : *part;
  return "the match before " + name.substr(0, name.rfind("_done"));
}

std::vector<std::string> Mission::CanStart(Time now) const {
  std::vector<std::string> regions;
  if (!board_) return regions;
  for (const char* region : {"", kFullRegion, kMeilinRegion, kFinalRegion}) {
    if (WhyNot(region, now).empty()) regions.emplace_back(region);
  }
  return regions;
}

Result<std::string> Mission::Start(const std::string& region, Time now) {
  if (!board_) return Error{kCodeStateInvalid, "the match is not set up"};
  if (std::string why = WhyNot(region, now); !why.empty()) return Error{kCodeFailed, why};
  const std::string goes_on = GoesOnWith();
  if (region == kFullRegion) {
    board_->taken.Set(0);
    board_->dock_trues.Set(-1);
  }
  SetDone(DoneFor(region));
  if (!region.empty()) {
    if (progress_.begun || region == kFinalRegion) ForgetPlan();
    board_->plan_id.Set("");
  }
  QueueRest(now);
  board_->segment_index.Set(static_cast<int>(progress_.next) - 1);
  board_->last_error.Set("");
  board_->SetState(kWaitingPlan);
  begun_ = restart_ = true;
  progress_.stands = false;
  autostart_ = ended_ = failed_ = stop_ = false;
  return region.empty() ? "goes on with " + goes_on : "begins with the region " + region;
}

// What is left of the plan, also where it has waited for the start, perhaps in an earlier process.
void Mission::QueueRest(Time now) {
  const auto queue = std::make_shared<SegmentQueue>();
  board_->queue.Set(queue);
  if (!HasRest()) return;
  const std::string& id = progress_.plan_id;
  Result<std::vector<Segment>> rest = RemainingSegments(now);
  if (!rest) {
    const std::string why = "plan " + id +
                            " does not fit where the robot is: " + rest.error().message +
                            "; send another one";
    board_->refused_plan.Set(why);
    robot_.Warn(why);
    return ForgetPlan();
  }
  queue->Replace(std::move(rest).value(), id);
  board_->plan_id.Set(id);
}

// Why a start waits; empty: it does not.
std::string Mission::AwaitedForStart(Time now) const {
  if (!FreshPose(robot_, settings_, now)) return "no fresh pose";
  if (!progress_.wheels_mm.empty() && !FreshWheels(robot_, now)) return "the wheels do not report";
  return robot_.suspension_state() == 0 ? "" : "the suspension";
}

void Mission::StartSoon(const std::string& region, Time now, OnStart done) {
  if (late_start_) {
    return done(Error{kCodeStateInvalid, "another start waits for the first pose of the robot"});
  }
  late_start_ = LateStart{region, now + kStartWait, std::move(done)};
  UpdateStart(now);
}

void Mission::UpdateStart(Time now) {
  if (!late_start_) return;
  const std::string awaited = AwaitedForStart(now);
  if (!awaited.empty() && now < late_start_->until) return;
  const LateStart late = *std::exchange(late_start_, std::nullopt);
  Result<std::string> begun = Start(late.region, now);
  if (!begun && !awaited.empty()) {
    begun = Error{begun.error().code,
                  fmt::format("{} (after {} s of waiting: {})", begun.error().message,
                              kStartWait / std::chrono::seconds(1), awaited)};
  }
  late.done(begun);
}

// --- plans ---

PlanRules Mission::Rules() const {
  PlanRules rules;
  rules.grid = settings_.grid;
  rules.yaw_tolerance_rad = settings_.yaw_tolerance_rad;
  rules.height_tolerance_mm = settings_.height_tolerance_mm;
  rules.normal_height_mm = settings_.normal_height_mm;
  if (boxes_ && boxes_->side == settings_.grid.side) rules.boxes = boxes_;
  for (int i = 0; i < kRows * kCols; ++i) {
    if ((board_->taken.Get() & 1 << i) != 0) rules.taken.push_back({i / kCols, i % kCols});
  }
  return rules;
}

Result<PlanStart> Mission::StartAt(Time now) const {
  const MissionBoard& board = *board_;
  if (!ended_ && board.segment_open.Get()) {
    const Segment segment = board.current_segment.Get();
    if (segment.segment_type == kMoveType) {
      return PlanStart{
          {segment.move_row, segment.move_col}, segment.target_height_mm, segment.target_yaw};
    }
    const bool fetches = segment.segment_type == kFetchType;
    return PlanStart{{board.row.Get(), board.col.Get()},
                     board.height_mm.Get(),
                     fetches ? segment.target_yaw : board.yaw_rad.Get(),
                     !fetches};
  }
  // The cell that it enters, while it prepares; else where it is by what it has done.
  const PlanStart known{{board.row.Get(), board.col.Get()},
                        board.height_mm.Get(),
                        board.yaw_rad.Get(),
                        board.is_cell_center.Get()};
  const std::optional<PoseFix> pose = FreshPose(robot_, settings_, now);
  if (!pose) return known;
  const OffEdge way = PlanOffEdge(settings_, *pose, FreshWheels(robot_, now));
  if (!way.unclear.empty()) return Error{kCodeFailed, way.unclear};
  if (way.on_edge) {
    return PlanStart{way.to, static_cast<double>(settings_.grid.HeightMm(way.to)),
                     NormalizeYaw(pose->yaw_rad), true};
  }
  return StartOf(settings_.grid, known, Pose2{pose->x_m, pose->y_m, pose->yaw_rad});
}

// A climb that was ended in the middle begins where the robot comes off the edge.
Result<std::optional<Point2>> Mission::PointAt(Time now) const {
  const Segment segment = board_->current_segment.Get();
  if (!ended_ && board_->segment_open.Get() && DrivesToPose(segment.segment_type)) {
    return std::optional(Point2{segment.target_x, segment.target_y});
  }
  const std::optional<PoseFix> pose = FreshPose(robot_, settings_, now);
  if (!pose) return std::optional<Point2>();
  const OffEdge way = PlanOffEdge(settings_, *pose, FreshWheels(robot_, now));
  if (!way.unclear.empty()) return Error{kCodeFailed, way.unclear};
  return std::optional(way.on_edge ? settings_.grid.Centre(way.to) : Point2{pose->x_m, pose->y_m});
}

bool Mission::OfferPlan(const msg::Float32MultiArray& plan, Time now, std::int64_t written_ns) {
  if (!forms_.sequences) {
    RefusePlan(
        "the tree of tree_file runs no plans of mf_action_seq: no node of it is "
        "PopNextMeilinSegment");
    return false;
  }
  if (DoneNow().count(kMeilinDone) > 0) {
    RefusePlan("the part of the field is done; a plan needs RESET, or the region meilin");
    return false;
  }
  const Result<PlanStart> start = StartAt(now);
  if (!start) {
    RefusePlan(start.error().message);
    return false;
  }
  PlanReading reading = ReadActionSequence(plan, Rules(), start.value());
  if (!reading.ok()) {
    RefusePlan(reading.message());
    return false;
  }
  Accept(std::move(reading.segments), PlanIdOf(static_cast<std::uint64_t>(progress_.plans + 1)));
  progress_.plan = StepsOf(plan);
  progress_.Take(written_ns);
  progress_.Take(NumberOf(plan));  // a service may hand out the same one
  return true;
}

bool Mission::OfferHandedOut(const msg::Float32MultiArray& plan, Time now) {
  const std::int64_t number = NumberOf(plan);
  if (WasTaken(number)) return false;
  progress_.Take(number);  // also a plan that is refused: it would be offered twice a second
  return OfferPlan(plan, now);
}

bool Mission::OfferSegments(const std::string& text, Time now, std::int64_t written_ns) {
  SegmentsReading reading = ReadSegmentsJson(text);
  std::string why = reading.message();
  if (!forms_.segments) {
    why =
        "the tree of tree_file runs no plans of planning/segments: no node of it is "
        "PopNextSegment";
  }
  if (why.empty()) {
    const Result<std::optional<Point2>> at = PointAt(now);
    why = at ? WhyNoWay(reading.segments, settings_.grid, settings_.height_tolerance_mm, at.value())
             : at.error().message;
  }
  if (!why.empty()) {
    RefusePlan(why);
    return false;
  }
  for (const std::string& warning : reading.warnings) robot_.Warn(warning);
  Accept(reading.segments, reading.plan_id.empty() ? fmt::format("segments_{}", progress_.plans + 1)
                                                   : reading.plan_id);
  old_ = std::move(reading.segments);
  progress_.segments = std::move(reading.text);
  progress_.Take(written_ns);
  return true;
}

void Mission::RefuseLate(const msg::Float32MultiArray& plan, const std::string& why) {
  progress_.Take(NumberOf(plan));
  RefusePlan(why);
}

void Mission::RefusePlan(const std::string& why) {
  ++refusals_;
  board_->refused_plan.Set(why);
  const bool idle =
      begun_ && !board_->segment_open.Get() && (Waits(state()) || (ended_ && !failed_));
  if (!idle) return;  // what runs, or why nothing does, is not hidden
  board_->last_error.Set(why);
  board_->SetState(kPlanRejected);
}

void Mission::Accept(std::vector<Segment> segments, const std::string& plan_id) {
  ++progress_.plans;
  progress_.plan_id = plan_id;
  ForgetPlan();
  board_->queue.Set(std::make_shared<SegmentQueue>(std::move(segments), plan_id));
  board_->plan_id.Set(plan_id);
  board_->segment_index.Set(-1);
  board_->refused_plan.Set("");
  if (!begun_) {  // it waits for its start
    if (!failed_) board_->SetState(kWaitingStart);
    return;
  }
  board_->last_error.Set("");
  board_->SetState(kPlanReady);
  restart_ = restart_ || ended_;
  ended_ = failed_ = stop_ = false;
}

Result<> Mission::Command(const std::string& command) {
  if (command != "RESET") {
    return Error{kCodeFailed, "there is no command '" + command + "'; expected RESET"};
  }
  const bool climbing = board_->climbing.Get();  // the robot may stand on an edge
  Begin();
  board_->climbing.Set(climbing);
  board_->refused_plan.Set("");
  stop_ = true;
  return Ok();
}

bool Mission::WantsPlan() const {
  if (!begun_) return false;  // a plan that is handed out once is not for a robot that waits
  if (board_ && board_->segment_open.Get()) return false;  // also while a refused one is named
  return Waits(state());
}

// --- what outlives the process ---

Progress Mission::SavedProgress() const {
  Progress saved = progress_;
  if (!board_) return saved;
  saved.plan_id = Plain(saved.plan_id);
  saved.last_end = Plain(saved.last_end);
  saved.done = DoneNow();
  saved.cell = {board_->row.Get(), board_->col.Get()};
  saved.height_mm = board_->height_mm.Get();
  saved.yaw_rad = board_->yaw_rad.Get();
  saved.at_centre = board_->is_cell_center.Get();
  saved.offset_mm = board_->suspension_offset_mm.Get();
  saved.climbing = board_->climbing.Get();
  saved.taken = board_->taken.Get();
  saved.side = SideText(settings_.grid.side);
  return saved;
}

Result<> Mission::Restore(const Progress& progress) {
  if (progress.side != SideText(settings_.grid.side)) {
    return Error{kCodeFailed, "the progress is that of the " + progress.side + " side"};
  }
  std::vector<Segment> old;
  if (!progress.segments.empty()) {
    SegmentsReading reading = ReadSegmentsJson(progress.segments);
    const auto steps = static_cast<std::int64_t>(reading.segments.size());
    if (!reading.ok() || progress.next > steps) {
      return Error{kCodeFailed, "segments: " + (reading.ok() ? "next is none" : reading.message())};
    }
    old = std::move(reading.segments);
  }
  progress_ = progress;
  old_ = std::move(old);
  const bool runs = old_.empty() ? forms_.sequences : forms_.segments;
  if (!runs) ForgetPlan();  // another tree has run it
  SetDone(progress.done);
  board_->row.Set(progress.cell.row);
  board_->col.Set(progress.cell.col);
  board_->height_mm.Set(progress.height_mm);
  board_->yaw_rad.Set(progress.yaw_rad);
  board_->is_cell_center.Set(progress.at_centre);
  board_->suspension_offset_mm.Set(progress.offset_mm);
  board_->climbing.Set(progress.climbing);
  board_->taken.Set(static_cast<int>(progress.taken));
  board_->SetState(kWaitingStart);
  return Ok();
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
std::string Mission::refused_plan() const {
  return board_ ? board_->refused_plan.Get() : "";
}

}  // namespace musher::meilin
