#include "musher/modules/race/runner.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/modules/race/printable.hpp"

namespace musher::race {
namespace {

// Phases of a step; 0: it has not begun.
constexpr int kLook = 1;
constexpr int kCorrect = 2;
constexpr int kRetry = 2;
constexpr int kStepBack = 3;
constexpr int kReturn = 4;  // to the place of a check that has stepped back

// Of a sighting: something is before the thing; and the thing has left the picture.
constexpr std::string_view kHidden = "hidden", kDisappeared = "disappeared";

// Of the lane in which a walk keeps.
constexpr int kUnseenTimes = 4;
constexpr Duration kLongestUnseen = Milliseconds(3000);

// Of a pause: the body comes to rest within the first, and its pose has to be known within the
// second after the end.
constexpr Duration kToRest = Milliseconds(1000);
constexpr Duration kLatestPose = Milliseconds(1000);

// How far the body has been moved; empty: not.
std::string MovedText(const OdometryRules& rules, const navigation::Pose& from,
                      const navigation::Pose& to) {
  const double shift_m = std::hypot(to.at.x_m - from.at.x_m, to.at.y_m - from.at.y_m);
  const double shift_rad = std::abs(navigation::Wrapped(to.yaw_rad - from.yaw_rad));
  const bool shifted = rules.most_moved_m > 0 && shift_m > rules.most_moved_m;
  const bool turned = rules.most_moved_rad > 0 && shift_rad > rules.most_moved_rad;
  if (!shifted && !turned) return {};
  char text[100];
  std::snprintf(text, sizeof text, "it was moved by %.2f m and turned by %.0f degrees in the pause",
                shift_m, shift_rad * 180 / M_PI);
  return text;
}

// The value that a text is, in upper or lower case.
std::optional<Index> ValueOf(const ResultRule& result, const std::string& text) {
  const auto is_text = [&](const std::string& value) { return SameWord(value, text); };
  const auto value = std::ranges::find_if(result.values, is_text);
  if (value == result.values.end()) return std::nullopt;
  return static_cast<Index>(value - result.values.begin());
}

std::string MetresText(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f m", metres);
  return text;
}

// Of a detector that says none it is 0.
std::string ConfidenceText(double confidence) {
  if (confidence <= 0) return {};
  char text[32];
  std::snprintf(text, sizeof text, " (confidence %.2f)", confidence);
  return text;
}

std::string Steps(int count) {
  return std::to_string(count) + (count == 1 ? " step" : " steps");
}

// Of a walk: its steps by odometry, and by time where that differs.
std::string Steps(int count, int by_time) {
  return Steps(count) + (count == by_time ? "" : " (" + std::to_string(by_time) + " by time)");
}

}  // namespace

Runner::Runner(const Course& course, RaceOutputs& outputs)
    : course_(course),
      outputs_(outputs),
      memory_(course),
      perception_(course, outputs),
      locomotion_(course, outputs),
      lane_walker_(course, outputs),
      voice_(course, outputs),
      state_(course.start),
      previous_(course.start) {
  if (course.light) light_.emplace(*course.light);
}

void Runner::Enter(Index state, bool by_decision, Duration now) {
  const bool back = by_decision && returns_ && interrupted_ && interrupted_->state == state;
  const bool begins = by_decision && state_ == course_.start;
  light_stops_ = returns_ = skips_ = false;
  SeesAgain();
  unseen_since_.reset();
  if (!by_decision) {  // by a command that knows where it is
    ahead_since_ = aside_since_ = {};
    checks_pose_from_.reset();
    moved_.clear();
    place_checked_ = true;
  }
  unknown_.clear();
  outside_fault_.clear();
  if (back) {
    const Interrupted interrupted = *std::exchange(interrupted_, std::nullopt);
    state_ = state;
    previous_ = interrupted.previous;
    at_ = interrupted.activity;
    // Also after a pause in the light's states.
    unsure_ = unsure_ || unsure_before_ || interrupted.unsure;
    unsure_before_ = interrupted.unsure_before;
    by_command_ = interrupted.by_command;
    if (interrupted.lane) {
      const auto& step = std::get<WalkStep>(rule().steps[at_.step]);
      lane_walker_.Begin(step.walk, *interrupted.lane);
      static_cast<void>(locomotion_.Rise(now));
    } else {
      locomotion_.Continue(interrupted.walk);
    }
    light_->Continue(now);
    return;
  }
  if (begins) {
    ahead_since_ = aside_since_ = {};
    memory_.BeginRun();
    locomotion_.ForgetSlip();
    reason_.clear();
    by_time_ = false;
    if (light_) light_->Reset();
  }
  if (!by_decision && light_) light_->Reset();  // the stopped movement does not continue
  if (!by_decision || state == course_.error || begins) interrupted_.reset();
  unsure_before_ = by_decision && unsure_;
  unsure_ = false;
  by_command_ = !by_decision;
  previous_ = state_;
  state_ = state;
  at_ = {};
  at_.since = now;
  // A command that leads back into the course begins another run.
  if (state != course_.start) memory_.SetCompleted(state == course_.end);
  if (state == course_.end || state == course_.error) ReportReservations();
}

void Runner::ReportReservations() {
  if (const std::string slip = locomotion_.SlipText(); !slip.empty()) {
    Log("of the way of the steps odometry has shown " + slip);
  }
  const std::size_t count = memory_.reserved();
  if (count == 0) return Log("without a reservation");
  Log("with " + std::to_string(count) + (count == 1 ? " reservation:" : " reservations:"));
  const std::vector<Reservation>& kept = memory_.reservations();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const bool last = i + 1 == kept.size();
    outputs_.Log("  " + std::to_string(last ? count : i + 1) + ". " + kept[i].Text());
  }
}

void Runner::Leave() {
  static_cast<void>(locomotion_.Stop());
  lane_walker_.Stop();
  voice_.Stop();
  if (light_) light_->Interrupt();
}

void Runner::SkipSteps() {
  Leave();
  skips_ = true;
}

void Runner::Pause(Time time) {
  if (!paused_at_) {
    paused_at_ = time;
    keeps_rest_pose_ = !std::exchange(place_checked_, false);
    if (!keeps_rest_pose_) rest_pose_.reset();
  }
  checks_pose_from_.reset();
  locomotion_.Pause();
  lane_walker_.Pause();
  voice_.Pause();
  at_.agreed = {};  // a picture from before the pause and one from after it do not agree
  at_.sampled_since.reset();
  perception_.Close();
  SeesAgain();
  unseen_since_.reset();
  if (light_) light_->Interrupt();
}

void Runner::Resume(Duration now) {
  const bool under_way = !idle() && state_ != course_.error;
  locomotion_.Resume(under_way, now);
  const bool was_paused = std::exchange(paused_at_, std::nullopt).has_value();
  if (!under_way) moved_.clear();
  if (!was_paused || !under_way || !course_.odometry.used()) return;
  if (!rest_pose_) ReservePose();
  ComparePose(now);
}

void Runner::ComparePose(Duration now) {
  if (rest_pose_) {
    checks_pose_from_ = now;
  } else {
    place_checked_ = true;  // it cannot be
  }
}

void Runner::GoOn(Duration now, Duration held) {
  at_.since += held;
  if (at_.stale_since) *at_.stale_since += held;
  if (at_.hidden_since) *at_.hidden_since += held;
  voice_.Prolong(held);
  ComparePose(now);
}

void Runner::ReservePose() {
  const std::string reason =
      "whether it was moved in the pause is not known: no odometry on " + course_.odometry.topic;
  Reserve(reason);
  Log(reason);
  unsure_ = true;
}

bool Runner::PoseOfRestAt(Time time) const {
  return paused_at_ && !keeps_rest_pose_ && time - *paused_at_ <= kToRest;
}

void Runner::OnOdometry(std::int64_t stamp_ns, const navigation::Pose& pose, Duration age,
                        Time time) {
  locomotion_.OnOdometry(stamp_ns, pose, age);
  if (age > course_.odometry.fresh) return;
  if (!paused_at_) lane_walker_.OnOdometry(pose, time);
  if (PoseOfRestAt(time)) rest_pose_ = pose;
  if (paused_at_ || !checks_pose_from_ || !rest_pose_) return;
  checks_pose_from_.reset();
  moved_ = MovedText(course_.odometry, *rest_pose_, pose);
}

bool Runner::ChecksPose(Duration now) {
  if (!checks_pose_from_) return false;
  if (now - *checks_pose_from_ < kLatestPose) return true;
  checks_pose_from_.reset();
  if (moved_.empty()) ReservePose();
  return false;
}

std::optional<Index> Runner::Advance(Duration now, Time time, bool held) {
  perception_.BeginTick();
  std::optional<Index> next;
  locomotion_.ExpireCall(now);
  blind_ = false;
  if (!held) next = RunSteps(now, time);
  if (!blind_) SeesAgain();
  const std::optional<Index> silent = perception_.EndTick(now, time);
  if (next || !silent) return next;
  const std::string& doubt = perception_.DoubtOf(*silent);
  return Fail("no sample of the detector " + course_.detectors[*silent].name + " for " +
              std::to_string(ToMilliseconds(course_.check.silent)) + " ms: " +
              (doubt.empty() ? "its camera or the detector is lost"
                             : "it is in doubt about each picture: " + doubt));
}

std::optional<Index> Runner::RunSteps(Duration now, Time time) {
  if (ChecksPose(now)) return std::nullopt;
  place_checked_ = true;
  if (!moved_.empty()) return Fail(std::exchange(moved_, {}));
  if (!outside_fault_.empty()) return Fail(std::exchange(outside_fault_, {}));
  if (skips_) {
    if (locomotion_.busy()) return std::nullopt;
    at_.step = rule().steps.size();
  }
  if (locomotion_.standing_up()) {
    const bool stands = locomotion_.AdvanceStanding(now);
    if (const auto fault = locomotion_.Fault(now)) return Fail(*fault);
    if (!stands) return std::nullopt;
    at_.after = std::max(at_.after, time + course_.check.settle);
    if (at_.phase == kLook) at_.since = now;  // it begins to look now
  }
  while (at_.step < rule().steps.size()) {
    fault_.clear();
    WantLight();
    const Outcome outcome =
        std::visit([&](const auto& step) { return Run(step, now, time); }, rule().steps[at_.step]);
    if (!fault_.empty()) return Fail(fault_);
    if (const auto fault = locomotion_.Fault(now)) return Fail(*fault);
    if (outcome == Outcome::kTarget) return target_;
    if (outcome == Outcome::kRunning) return std::nullopt;
    at_ = {.step = at_.step + 1, .since = now};
    unseen_since_.reset();
    if (outcome == Outcome::kDone) return std::nullopt;  // a new stream begins in the next tick
  }
  if (idle() || state_ == course_.error) return std::nullopt;
  return ChooseTransition();
}

// In the error state itself a fault only drops the step: it has nowhere else to go.
std::optional<Index> Runner::Fail(const std::string& reason) {
  Log(reason);
  if (state_ == course_.error) {
    Reserve(reason);
    Leave();
    ++at_.step;
    at_.phase = 0;
    return std::nullopt;
  }
  reason_ = rule().name + ": " + reason;
  return rule().on_fault;
}

bool Runner::Holds(const TransitionRule& transition) const {
  if (transition.result && memory_.Value(*transition.result) != transition.is) return false;
  return HoldsBesideResult(transition);
}

bool Runner::HoldsBesideResult(const TransitionRule& transition) const {
  if (!transition.from.empty() &&
      std::ranges::find(transition.from, previous_) == transition.from.end())
    return false;
  if (!transition.counter) return true;
  const int count = memory_.Count(*transition.counter);
  return (!transition.below || count < *transition.below) &&
         (!transition.at_least || count >= *transition.at_least);
}

std::optional<Index> Runner::ChooseTransition() {
  for (const TransitionRule& transition : rule().transitions) {
    // A way for all other values is none for a value that is not known.
    const bool is_unknown = transition.result && !memory_.Value(*transition.result);
    if (is_unknown && HoldsBesideResult(transition)) {
      const ResultRule& result = course_.results[*transition.result];
      return Fail(result.name + " is not known" +
                  (result.command.empty() ? "" : ": set it by " + result.command));
    }
    if (!Holds(transition)) continue;
    if (transition.to != kInterrupted) return transition.to;
    if (!interrupted_) return Fail("no movement was interrupted, to which it could go back");
    returns_ = true;
    return interrupted_->state;
  }
  std::string known;
  for (const TransitionRule& transition : rule().transitions) {
    if (!transition.result) continue;
    const std::string& name = course_.results[*transition.result].name;
    if (known.find(name) == std::string::npos) {
      known += (known.empty() ? ": " : ", ") + name + " is " + memory_.Text(*transition.result);
    }
  }
  return Fail("none of its transitions can be taken" + known);
}

// --- the steps of a state ---

Runner::Outcome Runner::Advance(Duration now, Time time) {
  if (Blind(now, time)) {
    unseen_since_.reset();  // its cameras have a fault of their own
    locomotion_.Wait();
    return Outcome::kRunning;
  }
  if (Unseen(now)) {
    if (NeedsLight()) perception_.Want(course_.light->detector);
    locomotion_.Wait();
    return Outcome::kRunning;
  }
  const bool done = locomotion_.Advance(now, time);
  ReserveDistances();
  if (done) return Outcome::kDone;
  if (!StoppedByLight(now, time)) return Outcome::kRunning;
  Interrupt();
  interrupted_->walk = locomotion_.Halt(time);
  Log("a yellow light: it stops with " +
      Steps(static_cast<int>(interrupted_->walk.left() / course_.step)) + " left");
  return Outcome::kTarget;
}

void Runner::Interrupt() {
  interrupted_ = Interrupted{state_, previous_, at_, {}, {}, unsure_, unsure_before_, by_command_};
  light_stops_ = true;
  target_ = course_.light->state;
}

void Runner::ReserveDistances() {
  if (const auto difference = locomotion_.TakeDifference()) {
    Reserve(*difference);
    Log(*difference);
    unsure_ = true;
  }
  if (!locomotion_.streaming() || locomotion_.doubt().empty()) return;
  unsure_ = true;
  if (std::exchange(by_time_, true)) return;
  const std::string reason = "walks without odometry, by their time: " + locomotion_.doubt();
  Reserve(reason);
  Log(reason);
}

// The same along a lane: the line walker gets a STOP, and walks on after the countdown. A walk that
// has come to its end has nothing left to stop.
Runner::Outcome Runner::AdvanceLane(const LaneWalk& walk, Duration now, Time time) {
  if (lane_walker_.arrived()) return EndLane(walk, time);
  if (Blind(now, time)) {
    lane_walker_.Pause();
    return Outcome::kRunning;
  }
  if (StoppedByLight(now, time)) {
    Interrupt();
    interrupted_->lane = lane_walker_.Interrupt();
    Log("a yellow light: the line walker stops");
    return Outcome::kTarget;
  }
  std::string reason;
  const LaneWalker::End end = lane_walker_.Advance(now, reason);
  if (!reason.empty() && end == LaneWalker::End::kNone) {  // it is started once more
    Reserve(reason);
    Log(reason);
  }
  if (end == LaneWalker::End::kGood) return EndLane(walk, time);
  const std::optional<double> way_m = lane_walker_.WayM(time);
  if (end == LaneWalker::End::kNone && walk.most_m > 0 && way_m > walk.most_m) {
    lane_walker_.Stop();
    return GiveUp(walk.otherwise, "the line walker has come " + MetresText(*way_m) +
                                      " by odometry, more than " + MetresText(walk.most_m) +
                                      ": it has passed the end of its lane");
  }
  if (end == LaneWalker::End::kNone) return Outcome::kRunning;
  lane_walker_.Stop();
  if (end == LaneWalker::End::kOther) return GiveUp(walk.otherwise, reason);
  fault_ = reason;
  return Outcome::kRunning;
}

// A state that a command has entered may begin anywhere in the lane: then it is nearer to the end.
Runner::Outcome Runner::EndLane(const LaneWalk& walk, Time time) {
  const std::optional<double> way_m = lane_walker_.WayM(time);
  lane_walker_.Stop();
  ahead_since_ = aside_since_ = {};  // its way is none of straight walks
  const bool checks = walk.least_m > 0 && !by_command_ && course_.odometry.used();
  if (!checks || (way_m && *way_m >= walk.least_m)) return Outcome::kDone;
  if (way_m) {
    return GiveUp(walk.otherwise, "the line walker has ended with " + walk.end + " after " +
                                      MetresText(*way_m) + " by odometry, less than " +
                                      MetresText(walk.least_m) +
                                      ": another line was taken for the end of its lane");
  }
  const std::string reason = "the line walker has ended with " + walk.end +
                             ", and how far it has come is not known: no odometry on " +
                             course_.odometry.topic;
  Reserve(reason);
  Log(reason);
  unsure_ = true;
  return Outcome::kDone;
}

bool Runner::InLane() const {
  return at_.step < rule().steps.size() && at_.phase != 0 &&
         std::holds_alternative<WalkStep>(rule().steps[at_.step]);
}

bool Runner::NeedsLight() const {
  return light_ && rule().light && (InLane() || locomotion_.walking());
}

bool Runner::StopsByLight() const {
  return NeedsLight() && (InLane() || locomotion_.ahead());
}

// A check may walk, too.
bool Runner::Walks(const Step& step) const {
  if (const auto* move = std::get_if<MoveStep>(&step)) {
    return course_.movements[move->movement].walks;
  }
  return std::holds_alternative<WalkStep>(step) || std::holds_alternative<UntilStep>(step) ||
         std::holds_alternative<CheckStep>(step);
}

void Runner::WantLight() {
  if (!light_ || !rule().light) return;
  const std::size_t next = at_.step + 1;
  const bool is_check = std::holds_alternative<CheckStep>(rule().steps[at_.step]);
  const bool now_walks = (at_.phase == 0 || is_check) && Walks(rule().steps[at_.step]);
  const bool soon_walks = next < rule().steps.size() && Walks(rule().steps[next]) &&
                          (!locomotion_.walking() || WalkEndsSoon());
  if (now_walks || soon_walks) perception_.Want(course_.light->detector);
}

// Until the first picture it stands without a word: the detector has to start. The fault is one of
// pictures that are late: where none comes at all, Perception::EndTick() has found that before.
bool Runner::Blind(Duration now, Time time) {
  if (!NeedsLight()) return false;
  const Index detector = course_.light->detector;
  const std::string& name = course_.detectors[detector].name;
  const std::string blind = std::to_string(ToMilliseconds(course_.light->blind)) + " ms";
  blind_ = perception_.SightingSince(detector, time - course_.light->blind) == nullptr;
  if (!blind_) return false;
  perception_.Want(detector);
  if (!blind_since_) blind_since_ = now;
  if (perception_.HasStarted(detector) && !std::exchange(blind_said_, true)) {
    Log("no picture for the detector " + name + " for " + blind + ": it stands until one comes");
  }
  if (now - *blind_since_ > course_.check.silent) {
    fault_ = "all pictures for the detector " + name + " are older than " + blind + ", for " +
             std::to_string(ToMilliseconds(course_.check.silent)) +
             " ms: its camera or the detector is late";
    SeesAgain();  // in the error state it goes on
  }
  return true;
}

bool Runner::StoppedByLight(Duration now, Time time) {
  if (!NeedsLight()) return false;
  perception_.Want(course_.light->detector);
  if (!StopsByLight()) return false;
  const Time since = time - course_.light->blind;
  return light_->Stops(perception_.SightingSince(course_.light->detector, since), now);
}

// Where only one line is seen its middle may not be known: straight on.
void Runner::Steer(const std::optional<Index>& keep, Duration now, Time time) {
  keep_ = keep;
  if (!keep) return;
  const Keep& rule = course_.keeps[*keep];
  perception_.Want(rule.detector);
  const Lines* lines = perception_.LinesSince(rule.detector, time - rule.fresh);
  const bool seen = lines != nullptr && lines->contours >= 1 && lines->doubt.empty() &&
                    std::isfinite(lines->middle_offset);
  const bool has_middle = seen && (lines->contours >= 2 || rule.one_line);
  const double yaw_rad_s = has_middle ? -rule.yaw_rad_s * lines->middle_offset : 0;
  locomotion_.Steer(std::clamp(yaw_rad_s, -rule.most_rad_s, rule.most_rad_s));
  if (seen) {
    unseen_since_.reset();
    return;
  }
  unseen_why_ = lines == nullptr        ? "no picture is new enough"
                : !lines->doubt.empty() ? lines->doubt
                : lines->contours == 0  ? "no line is seen"
                                        : "its middle is not known";
  if (unseen_since_) return;
  unseen_since_ = now;
  unseen_said_ = false;
}

bool Runner::Unseen(Duration now) {
  if (!keep_ || !unseen_since_) return false;
  const Keep& rule = course_.keeps[*keep_];
  const Duration most = kUnseenTimes * rule.fresh;
  const Duration unseen = now - *unseen_since_;
  if (unseen < most) return false;
  const std::string what =
      "the lane is not seen by the detector " + course_.detectors[rule.detector].name + " for ";
  if (!std::exchange(unseen_said_, true)) {
    Log(what + std::to_string(ToMilliseconds(most)) + " ms: " + unseen_why_ +
        "; it stands until it is");
  }
  if (unseen >= most + kLongestUnseen) {
    fault_ = what + std::to_string(ToMilliseconds(most + kLongestUnseen)) + " ms: " + unseen_why_;
    unseen_since_.reset();  // in the error state it goes on
  }
  return true;
}

bool Runner::WalkEndsSoon() const {
  return locomotion_.walk() && locomotion_.walk()->left() <= course_.check.open;
}

// A detector needs a moment to start.
void Runner::WantNext() {
  const Index next = at_.step + 1;
  if (next >= rule().steps.size()) return;
  const Step& step = rule().steps[next];
  if (const auto* check = std::get_if<CheckStep>(&step)) {
    WantForCheck(course_.checks[check->check]);
  } else if (const auto* wait = std::get_if<WaitStep>(&step)) {
    if (const auto detector = course_.waits[wait->wait].detector) perception_.Want(*detector);
  } else if (const auto* until = std::get_if<UntilStep>(&step)) {
    perception_.Want(course_.untils[until->until].detector);
  }
}

void Runner::WantForCheck(const Check& check) {
  perception_.Want(check.detector);
  if (check.agrees_with) perception_.Want(course_.checks[*check.agrees_with].detector);
}

Runner::Outcome Runner::Run(const MoveStep& step, Duration now, Time time) {
  const bool walks = course_.movements[step.movement].walks;
  if (at_.phase == 0) {
    const std::string& name = course_.movements[step.movement].name;
    if (LeftOut(step.only, name)) return Outcome::kSkipped;
    const int counted = step.less ? memory_.Count(*step.less) - step.beyond : 0;
    const int made = std::max(counted, 0);
    if (walks && step.count <= made) {
      Log(name + " " + std::to_string(step.count) + " - " + std::to_string(made) +
          ": no step is left");
      return Outcome::kSkipped;
    }
    if (walks) {
      locomotion_.Walk({step.movement, step.count - made});
    } else {
      locomotion_.Move(step.movement, now);
    }
    Phase(1, now);
  }
  Steer(step.keep, now, time);
  const Outcome outcome = Advance(now, time);
  if (walks && outcome == Outcome::kDone) CountWay(locomotion_.ended_walk());
  // Also in its last tick: a detector that is closed for a tick has to start once more.
  if (walks && (outcome == Outcome::kDone || WalkEndsSoon())) WantNext();
  return outcome;
}

Runner::Outcome Runner::Run(const CheckStep& step, Duration now, Time time) {
  keep_.reset();
  const Check& check = course_.checks[step.check];
  if (at_.phase == 0) {
    at_.after = std::max(at_.after, locomotion_.walked_until() + course_.check.settle);
    Phase(kLook, now);
  }
  WantForCheck(check);
  if (at_.phase == kLook) return Look(check, step.after_turn, now);
  const Outcome outcome = Advance(now, time);
  if (outcome != Outcome::kDone) return outcome;
  if (at_.phase == kReturn) {
    return at_.given_up.empty() ? Outcome::kDone : GiveUpCheck(check, at_.given_up);
  }
  at_.after = locomotion_.walked_until() + course_.check.settle;
  Phase(kLook, now);
  return Outcome::kRunning;
}

// By pictures that are new enough; nothing where they show no line, or not the thing.
std::optional<LineWord> Runner::Word(const Check& check, bool after_turn) {
  std::optional<LineWord> word;
  bool clear = true;
  if (check.by == Check::By::kBox) {
    const Sighting* sighting = perception_.SightingSince(check.detector, at_.after);
    if (sighting == nullptr) return std::nullopt;
    word = BoxWord(check, *sighting);
  } else {
    const Lines* lines = perception_.LinesSince(check.detector, at_.after);
    if (lines == nullptr) return std::nullopt;
    clear = lines->doubt.empty();
    if (clear && lines->contours > 0) word = check.by == Check::By::kDy ? lines->dy : lines->ycy;
    if (word) at_.contradiction = Contradiction(check, *word, after_turn);
    if (word && !at_.contradiction.empty()) {
      clear = false;
      word.reset();
    }
  }
  const auto index = word ? std::optional(static_cast<Index>(*word)) : std::nullopt;
  return Agreed(check.detector, index, clear) ? word : std::nullopt;
}

std::string Runner::Contradiction(const Check& check, LineWord word, bool after_turn) const {
  if (!check.agrees_with) return {};
  const Check& other = course_.checks[*check.agrees_with];
  const Lines* lines = perception_.LinesSince(other.detector, at_.after);
  if (lines == nullptr || !lines->doubt.empty() || lines->contours == 0) return {};
  const LineWord other_word = other.by == Check::By::kDy ? lines->dy : lines->ycy;
  const auto twist_of = [&](const Check& each, LineWord its_word) -> std::optional<Twist> {
    if (its_word == LineWord::kCenter) return std::nullopt;
    const Corrections& corrections = after_turn ? each.after_turn : each.usual;
    const auto& correction = corrections.at(static_cast<std::size_t>(its_word));
    return correction ? std::optional(course_.movements[correction->movement].twist) : std::nullopt;
  };
  const auto one = twist_of(check, word), two = twist_of(other, other_word);
  if (!one || !two) return {};
  const double product = one->forward_m_s * two->forward_m_s + one->left_m_s * two->left_m_s +
                         one->yaw_rad_s * two->yaw_rad_s;
  if (product >= 0) return {};
  return "two cameras do not agree: " + std::string(Name(word)) + " by " +
         course_.detectors[check.detector].name + ", " + std::string(Name(other_word)) + " by " +
         course_.detectors[other.detector].name;
}

std::optional<LineWord> Runner::BoxWord(const Check& check, const Sighting& sighting) const {
  if (!sighting.seen || !std::isfinite(sighting.offset)) return std::nullopt;
  const auto finds = [&](const Wait& wait) {
    return wait.detector == check.detector && ValueOf(course_.results[wait.result], sighting.text);
  };
  const auto reads = [&](const Wait& wait) { return wait.detector == check.detector; };
  if (std::ranges::any_of(course_.waits, reads) && std::ranges::none_of(course_.waits, finds)) {
    return std::nullopt;  // another board
  }
  if (sighting.offset > check.threshold) return LineWord::kLeft;
  return sighting.offset < -check.threshold ? LineWord::kRight : LineWord::kCenter;
}

std::optional<Index> Runner::Agreed(Index detector, std::optional<Index> word, bool clear) {
  Agreement& so_far = at_.agreed;
  const std::uint64_t picture = perception_.Pictures(detector);
  if (so_far.picture == picture) return std::nullopt;
  so_far.picture = picture;
  ++so_far.pictures;
  if (clear) ++so_far.clear;
  if (!word) return std::nullopt;
  so_far.in_row = so_far.word == word ? so_far.in_row + 1 : 1;
  so_far.word = word;
  const bool agrees =
      so_far.in_row >= course_.check.agreeing && 2 * so_far.clear >= so_far.pictures;
  return agrees ? word : std::nullopt;
}

bool Runner::HasSample(const Check& check) const {
  return check.by == Check::By::kBox
             ? perception_.SightingSince(check.detector, at_.after) != nullptr
             : perception_.LinesSince(check.detector, at_.after) != nullptr;
}

// Pictures without the thing are no reason to wait on. Without any picture it stands, as by
// Perception::EndTick(), until that is a fault.
Runner::Outcome Runner::Look(const Check& check, bool after_turn, Duration now) {
  const CheckRules& rules = course_.check;
  const std::optional<LineWord> word = Word(check, after_turn);
  if (!word) {
    const bool has_sample = HasSample(check);
    if (has_sample && !at_.sampled_since) at_.sampled_since = now;
    if (now - at_.since < rules.settle + rules.picture) return Outcome::kRunning;
    // The first one came late: a second one has to agree with it.
    if (has_sample && now - *at_.sampled_since < rules.settle) return Outcome::kRunning;
    if (!has_sample) {
      if (now - at_.since < rules.settle + rules.silent) return Outcome::kRunning;
      fault_ = "check " + check.name + ": all pictures for the detector " +
               course_.detectors[check.detector].name +
               " are older than the movement before it, for " +
               std::to_string(ToMilliseconds(rules.silent)) + " ms";
      return Outcome::kRunning;
    }
    const Lines* lines = perception_.LinesSince(check.detector, at_.after);
    const bool in_doubt = lines != nullptr && !lines->doubt.empty();
    const std::string& doubt = in_doubt ? lines->doubt : at_.contradiction;
    return LookFromBehind(check, after_turn,
                          "check " + check.name + ": no picture of it within " +
                              std::to_string(ToMilliseconds(rules.picture)) + " ms" +
                              (doubt.empty() ? "" : ": " + doubt),
                          now);
  }
  const Corrections& corrections = after_turn ? check.after_turn : check.usual;
  if (*word == LineWord::kCenter) {
    for (const auto& each : corrections) {
      if (each) PlaceIsRight(course_.movements[each->movement].twist);
    }
    return EndCheck(check, after_turn, "", now);
  }
  const auto index = static_cast<std::size_t>(*word);
  if (check.accepted.at(index)) return EndCheck(check, after_turn, "", now);
  const auto& correction = corrections.at(index);
  const std::string found = "check " + check.name + ": " + std::string(Name(*word));
  const auto give_up = [&](const std::string& why) {
    return EndCheck(check, after_turn, found + why, now);
  };
  if (!correction) return give_up(", for which it has no correction");
  if (at_.tries >= check.max_corrections.value_or(rules.max_corrections)) {
    return give_up(" after " + std::to_string(at_.tries) + " corrections");
  }
  if (const std::string against = AgainstOdometry(*correction); !against.empty()) {
    return TakeBack(check, after_turn, found + against, now);
  }
  ++at_.tries;
  if (!at_.correction) at_.correction = course_.movements[correction->movement].twist;
  at_.corrected_m += MetresAlong(*correction);
  Log(found + ", correction " + std::to_string(at_.tries) + ": " +
      course_.movements[correction->movement].name + " " + std::to_string(correction->count));
  locomotion_.Walk(*correction);
  Phase(kCorrect, now);
  return Outcome::kRunning;
}

void Runner::CountWay(const WalkProgress& walk) {
  const Movement& movement = course_.movements[walk.movement];
  const Twist& twist = movement.twist;
  if (twist.turns()) {  // what was ahead of it is aside of it then
    const WaySince all{std::max(ahead_since_.m, aside_since_.m),
                       ahead_since_.known && aside_since_.known};
    ahead_since_ = aside_since_ = all;
    return;
  }
  const double way_m = std::hypot(twist.forward_m_s, twist.left_m_s) * movement.odometry_share *
                       std::abs(ToSeconds(walk.measured));
  ahead_since_.m += way_m;
  aside_since_.m += way_m;
}

void Runner::PlaceIsRight(const Twist& twist) {
  if (twist.forward_m_s != 0) ahead_since_ = {0, true};
  if (twist.left_m_s != 0) aside_since_ = {0, true};
}

double Runner::MetresAlong(const Stretch& correction) const {
  const Movement& movement = course_.movements[correction.movement];
  const Twist& twist = movement.twist;
  const Twist first = at_.correction.value_or(twist);
  const double along = twist.forward_m_s * first.forward_m_s + twist.left_m_s * first.left_m_s;
  const double way_m = std::hypot(twist.forward_m_s, twist.left_m_s) * movement.odometry_share *
                       ToSeconds(correction.count * course_.step);
  return along > 0 ? way_m : along < 0 ? -way_m : 0;
}

std::string Runner::AgainstOdometry(const Stretch& correction) const {
  const CheckRules& rules = course_.check;
  const Twist& twist = course_.movements[correction.movement].twist;
  if (rules.most_off_m == 0 || twist.turns()) return {};
  const WaySince& since = twist.forward_m_s != 0 ? ahead_since_ : aside_since_;
  const bool believed = course_.odometry.used() && locomotion_.doubt().empty() && !by_time_;
  if (!since.known || !believed) return {};
  const double off_m = std::abs(at_.corrected_m + MetresAlong(correction));
  const double most_m = rules.most_off_m + rules.most_off_share * since.m;
  if (off_m <= most_m) return {};
  return ", but corrections by " + MetresText(off_m) + " are more than odometry can be off after " +
         MetresText(since.m) + " (" + MetresText(most_m) + "): it may be another line";
}

Runner::Outcome Runner::TakeBack(const Check& check, bool after_turn, const std::string& why,
                                 Duration now) {
  const Corrections& corrections = after_turn ? check.after_turn : check.usual;
  const auto leads_back = [&](const auto& each) {
    return each && MetresAlong(*each) * at_.corrected_m < 0;
  };
  const auto back = std::ranges::find_if(corrections, leads_back);
  if (at_.corrected_m == 0 || at_.is_behind || back == corrections.end())
    return EndCheck(check, after_turn, why, now);
  Log(why + "; it takes its corrections back");
  const Stretch step{(*back)->movement, 1};
  const double steps = std::abs(at_.corrected_m / MetresAlong(step));
  locomotion_.Walk({step.movement, std::max(1, static_cast<int>(std::lround(steps)))});
  at_.given_up = why;
  Phase(kReturn, now);
  return Outcome::kRunning;
}

// One that is required is of a place that the robot may not be at: it does not move there.
Runner::Outcome Runner::LookFromBehind(const Check& check, bool after_turn, const std::string& why,
                                       Duration now) {
  const auto& step_back = course_.check.step_back;
  if (!step_back || check.required || at_.stepped_back) {
    return EndCheck(check, after_turn, why, now);
  }
  Log(why + "; it steps back once, and looks again");
  at_.stepped_back = at_.is_behind = true;
  at_.contradiction.clear();
  locomotion_.Walk(step_back->away);
  Phase(kStepBack, now);
  return Outcome::kRunning;
}

Runner::Outcome Runner::EndCheck(const Check& check, bool after_turn, const std::string& why,
                                 Duration now) {
  const bool is_corrected = why.empty() && CorrectsTheWay(check, after_turn);
  if (at_.is_behind && !is_corrected) {
    at_.is_behind = false;
    at_.given_up = why;
    locomotion_.Walk(course_.check.step_back->back);
    Phase(kReturn, now);
    return Outcome::kRunning;
  }
  return why.empty() ? Outcome::kDone : GiveUpCheck(check, why);
}

bool Runner::CorrectsTheWay(const Check& check, bool after_turn) const {
  const Corrections& corrections = after_turn ? check.after_turn : check.usual;
  return std::ranges::any_of(corrections, [&](const auto& correction) {
    return correction && course_.movements[correction->movement].twist.forward_m_s != 0;
  });
}

// The race goes on with a reservation, but not with too many of them: then it is lost.
Runner::Outcome Runner::GiveUpCheck(const Check& check, const std::string& why) {
  if (check.required) {
    fault_ = why;
    return Outcome::kRunning;
  }
  Reserve(why);
  memory_.GiveUpCheck();
  unsure_ = true;
  const int most = course_.check.most_given_up;
  const int count = memory_.given_up();
  if (most == 0 || count <= most) {
    Log(why + "; it continues");
    return Outcome::kDone;
  }
  const std::size_t name_end = why.find(':');
  fault_ = std::to_string(count) + (count == 1 ? " check was" : " checks were") +
           " given up, the last: " + why.substr(0, name_end) + " in " + rule().name +
           why.substr(name_end);
  return Outcome::kRunning;
}

Runner::Outcome Runner::Run(const WaitStep& step, Duration now, Time time) {
  keep_.reset();
  const Wait& wait = course_.waits[step.wait];
  if (!wait.detector) {
    return now - at_.since >= wait.limit ? Outcome::kDone : Outcome::kRunning;
  }
  return FindResult(wait, now, time);
}

Runner::Outcome Runner::FindResult(const Wait& wait, Duration now, Time time) {
  const ResultRule& result = course_.results[wait.result];
  if (at_.phase == 0) {
    at_.after = std::max(at_.after, time);
    Phase(kLook, now);
  }
  if (at_.phase == kRetry) {
    perception_.Want(*wait.detector);
    const Outcome outcome = Advance(now, time);
    if (outcome != Outcome::kDone) return outcome;
    if (wait.adds) memory_.SetCount(*wait.adds, memory_.Count(*wait.adds) + wait.retry.count);
    at_.after = time;
    Phase(kLook, now);
  }
  if (memory_.Value(wait.result)) return Outcome::kSkipped;  // also by a command meanwhile
  perception_.Want(*wait.detector);
  const Sighting* sighting = perception_.SightingSince(*wait.detector, at_.after);
  if (sighting != nullptr && sighting->seen) {
    const auto value = ValueOf(result, sighting->text);
    // A detector of words says its word once.
    const bool once = course_.detectors[*wait.detector].kind == Detector::Kind::kText;
    if (value && (once || Agreed(*wait.detector, value, true))) {
      memory_.Set(wait.result, *value);
      Log(result.name + " is " + result.values[*value] + ConfidenceText(sighting->confidence));
      return Outcome::kDone;
    }
    if (!value) ReportUnknown(wait, sighting->text);
  }
  if (now - at_.since < wait.limit) return Outcome::kRunning;
  const std::string none =
      "no " + result.name + " within " + std::to_string(ToMilliseconds(wait.limit)) + " ms";
  if (at_.tries < wait.retries) {
    ++at_.tries;
    Log(none + ", retry " + std::to_string(at_.tries) + " of " + std::to_string(wait.retries));
    locomotion_.Walk(wait.retry);
    Phase(kRetry, now);
    return Outcome::kRunning;
  }
  if (wait.otherwise.kind != Otherwise::Kind::kDefault) return GiveUp(wait.otherwise, none);
  memory_.SetDefault(wait.result);
  unsure_ = true;
  const std::string taken = none + ": its default " + result.values[*result.by_default];
  Reserve(taken);
  Log(taken);
  return Outcome::kDone;
}

void Runner::ReportUnknown(const Wait& wait, const std::string& text) {
  constexpr std::size_t kMostReported = 5;
  const bool known = std::ranges::find(unknown_, text) != unknown_.end();
  if (text.empty() || known || unknown_.size() >= kMostReported) return;
  unknown_.push_back(text);
  const ResultRule& result = course_.results[wait.result];
  const std::string shown = Printable(text);
  Log("the detector " + course_.detectors[*wait.detector].name + " reads '" + shown + "'; " +
      NoSuch(result.name, shown, result.values));
}

Runner::Outcome Runner::Run(const UntilStep& step, Duration now, Time time) {
  const Until& until = course_.untils[step.until];
  const Stretch most{until.most.movement, step.most.value_or(until.most.count)};
  if (at_.phase == 0) {
    locomotion_.WalkAtMost(most);
    at_.after = time;
    Phase(1, now);
  }
  perception_.Want(until.detector);
  Steer(step.keep, now, time);
  const auto store = [&](const WalkProgress& walk) {
    const int made = std::min(StepsOf(walk.made), most.count);  // the last tick may be beyond
    if (step.stores) memory_.SetCount(*step.stores, made);
    return Steps(made, std::min(StepsOf(walk.walked), most.count));
  };
  const Sighting* sighting = perception_.SightingSince(until.detector, time - blind());
  const bool of_walk = perception_.SightingSince(until.detector, at_.after) != nullptr;
  if (sighting != nullptr && of_walk && Ends(until, *sighting)) {
    memory_.SetMissed(step.until, false);
    const WalkProgress walk = locomotion_.Halt(time);
    CountWay(walk);
    Log(until.name + " after " + store(walk) + ConfidenceText(sighting->confidence));
    return Outcome::kDone;
  }
  if (WaitsForSight(until, sighting, now)) {
    if (NeedsLight()) perception_.Want(course_.light->detector);
    unseen_since_.reset();
    locomotion_.Wait();
    return Outcome::kRunning;
  }
  const Outcome outcome = Advance(now, time);
  if (outcome != Outcome::kDone) return outcome;
  CountWay(locomotion_.ended_walk());
  memory_.SetMissed(step.until, true);
  return GiveUp(until.otherwise, "no " + until.name + " within " + store(locomotion_.ended_walk()));
}

// A detector that others have kept open may still report what disappeared before this walk.
bool Runner::Ends(const Until& until, const Sighting& sighting) {
  const bool is_phase = SameWord(sighting.phase, until.phase);
  if (!is_phase) at_.other_phase = true;
  return is_phase && (at_.other_phase || !SameWord(until.phase, kDisappeared));
}

bool Runner::WaitsForSight(const Until& until, const Sighting* sighting, Duration now) {
  if (sighting == nullptr) {
    if (!perception_.HasStarted(until.detector)) return true;  // at most CheckRules::silent
    if (!at_.stale_since) at_.stale_since = now;
    if (now - *at_.stale_since >= course_.check.silent) {
      fault_ = "all pictures for the detector " + course_.detectors[until.detector].name +
               " are older than " + std::to_string(ToMilliseconds(blind())) + " ms, for " +
               std::to_string(ToMilliseconds(course_.check.silent)) + " ms";
      at_.stale_since.reset();  // in the error state it goes on
    }
    return true;
  }
  at_.stale_since.reset();
  if (!SameWord(sighting->phase, kHidden)) {
    at_.hidden_since.reset();
    at_.hidden_over = false;
    return false;
  }
  if (at_.hidden_over) return false;
  if (!at_.hidden_since) at_.hidden_since = now;
  if (now - *at_.hidden_since < kLongestHidden) return true;
  at_.hidden_over = true;
  const std::string reason =
      until.name + " has been hidden for " + std::to_string(ToMilliseconds(kLongestHidden)) + " ms";
  Reserve(reason);
  Log(reason + "; it walks on");
  return false;
}

Runner::Outcome Runner::Run(const WalkStep& step, Duration now, Time time) {
  if (at_.phase == 0) {
    lane_walker_.Begin(step.walk);
    Phase(1, now);
    if (locomotion_.Rise(now)) return Outcome::kRunning;
  }
  return AdvanceLane(course_.walks[step.walk], now, time);
}

Runner::Outcome Runner::Run(const SayStep& step, Duration now, Time /*time*/) {
  if (at_.phase == 0) {
    const std::string& name = course_.speeches[step.speech].name;
    if (LeftOut(step.only, name)) return Outcome::kSkipped;
    const auto result = course_.speeches[step.speech].result;
    const bool unsure =
        step.unsure && (result ? memory_.IsDefault(*result) : unsure_ || unsure_before_);
    if (unsure && !result)
      Log("it is not sure of the place: a check on the way was given up, or a walk or a pause not "
          "confirmed");
    voice_.Begin(unsure ? *step.unsure : step.speech, memory_, now);
    Phase(1, now);
  }
  return voice_.Advance(now) ? Outcome::kDone : Outcome::kRunning;
}

bool Runner::LeftOut(const std::optional<Index>& only, const std::string& what) {
  if (!only || !memory_.Missed(*only)) return false;
  Log(what + " is left out: no " + course_.untils[*only].name + " was found");
  return true;
}

Runner::Outcome Runner::Run(const CountStep& step, Duration /*now*/, Time /*time*/) {
  if (LeftOut(step.only, course_.counters[step.counter])) return Outcome::kSkipped;
  const int before = step.adds ? memory_.Count(step.counter) : 0;
  memory_.SetCount(step.counter, before + step.number);
  return Outcome::kSkipped;
}

Runner::Outcome Runner::GiveUp(const Otherwise& otherwise, const std::string& what) {
  if (otherwise.kind != Otherwise::Kind::kState || otherwise.state != course_.error) Reserve(what);
  if (otherwise.kind != Otherwise::Kind::kState) {
    Log(what + "; it continues");
    return Outcome::kDone;
  }
  if (otherwise.state == course_.error) {
    fault_ = what;
    return Outcome::kRunning;
  }
  Log(what);
  target_ = otherwise.state;
  return Outcome::kTarget;
}

}  // namespace musher::race
