#include "musher/modules/race/race.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/modules/race/command_words.hpp"
#include "musher/modules/race/course_state.hpp"
#include "musher/modules/race/printable.hpp"
#include "musher/modules/race/recording.hpp"

namespace musher::race {
namespace {

constexpr Duration kLogPeriod = std::chrono::seconds(2);  // of each kind of refusal
constexpr std::size_t kMostText = 200;                    // of a command or a sighting
constexpr std::size_t kMostLine = 2000;                   // of the log
constexpr std::size_t kMostEarly = 64;
// A camera's clock: that much of it is recorded.
constexpr Duration kMostAhead = std::chrono::hours(24);
// Of a sample of the odometry.
constexpr double kMostMetres = 1e6;
constexpr std::int64_t kMostStampNs = 4'000'000'000'000'000'000;  // 126 years

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

std::string Shown(std::string_view text) {
  return "'" + Printable(text) + "'";
}

bool IsWord(std::string_view text) {
  return text.size() <= kMostText &&
         std::ranges::all_of(text, [](char c) { return c > ' ' && c < 0x7f; });
}

}  // namespace

Race::Race(Course course, RaceOutputs& outputs)
    : course_(std::move(course)),
      outputs_(outputs),
      runner_(course_, outputs),
      log_([&outputs](const std::string& line) { outputs.Log(line); }, kLogPeriod) {}

void Race::Refuse(std::string_view kind, const std::string& why) {
  log_.Log(kind, Printable(why, kMostLine), now_);
}

Race::~Race() {
  if (machine_ == nullptr) return;
  machine_->Forget(this);
  machine_->ForgetInputs(this);
}

Result<> Race::Build(fsm::Machine& machine) {
  machine.AddEvent(std::string(command::kStart));
  machine.AddEvent(std::string(command::kStop), fsm::Urgency::kUrgent);
  for (Index i = 0; i < course_.states.size(); ++i) {
    const fsm::Role role = i == course_.error ? fsm::Role::kSafe
                           : i == course_.end ? fsm::Role::kFinal
                                              : fsm::Role::kNormal;
    machine.Add(course_.states[i].name, std::make_unique<CourseState>(*this, i), role);
  }
  if (Result<> built = machine.Build(course_.states[course_.start].name); !built) return built;
  machine_ = &machine;
  machine.Listen(this);
  machine.ListenToInputs(this);
  return Ok();
}

std::string_view Race::state() const {
  return running() ? machine_->Name(machine_->current()) : "";
}

int Race::state_number() const {
  return course_.states[running() ? runner_.state() : course_.start].number;
}

std::string Race::InfoText() const {
  std::string text = "CurrentState:" + std::to_string(state_number()) +
                     ",QRResult:" + memory().Shown() +
                     ",TaskCompleted:" + (memory().completed() ? "True" : "False");
  text += DefaultsText();
  const bool failed = running() && runner_.state() == course_.error && !runner_.reason().empty();
  if (waits_for_start()) text += ",Waits:START";
  if (memory().completed() || failed) text += ReservationsText();
  return failed ? text + ",Reason:" + runner_.reason() : text;
}

// The results that were not found.
std::string Race::DefaultsText() const {
  std::string names;
  for (Index i = 0; i < course_.results.size(); ++i) {
    if (memory().IsDefault(i)) names += (names.empty() ? "" : ";") + course_.results[i].name;
  }
  return names.empty() ? "" : ",Default:" + names;
}

// A comma separates keys: there is none in a value.
std::string Race::ReservationsText() const {
  std::string text = ",Reservations:" + std::to_string(memory().reserved());
  const auto add = [&text](const char* key, const Reservation& reservation) {
    std::string value = reservation.Text();
    std::ranges::replace(value, ',', ';');
    text += "," + std::string(key) + ":" + value;
  };
  const std::vector<Reservation>& kept = memory().reservations();
  if (!kept.empty()) add("FirstReservation", kept.front());
  if (kept.size() > 1) add("LastReservation", kept.back());
  return text;
}

// The time in a recording of an input received at now_.
void Race::Record(std::string_view input, std::initializer_list<std::string> words) {
  if (recorder_ == nullptr || !first_start_) return;
  recorder_->Input(input, InputText(now_ - *first_start_, words));
}

void Race::OnSighting(Index detector, Sighting sighting, Time taken, Time now) {
  now_ = now;
  if (detector >= course_.detectors.size()) return;
  Clean(detector, sighting);
  taken = std::min(taken, now + kMostAhead);
  if (first_start_) {
    Record(input::kSighting,
           {std::to_string(detector), std::to_string((taken - *first_start_).count()),
            sighting.seen ? "1" : "0", NumberText(sighting.distance_m), sighting.phase,
            sighting.text, NumberText(sighting.offset), NumberText(sighting.confidence)});
  }
  runner_.perception().OnSighting(detector, std::move(sighting), taken, now);
}

void Race::OnText(Index detector, std::string_view text, Time now) {
  const std::string word(Trimmed(text));
  OnSighting(detector, {!word.empty(), std::numeric_limits<double>::quiet_NaN(), "", word}, now,
             now);
}

// What makes no sense is left out and logged. The rest counts, so that a detector that works is not
// taken for a silent one.
void Race::Clean(Index detector, Sighting& sighting) {
  const auto refuse = [&](const std::string& what) {
    Refuse("sighting", "a sighting of the detector " + course_.detectors[detector].name +
                           " counts without its " + what);
  };
  if (!IsWord(sighting.phase)) {
    refuse("phase, which is no word of at most " + std::to_string(kMostText) + " characters");
    sighting.phase.clear();
  }
  if (sighting.text.size() > kMostText) {
    refuse("text of " + std::to_string(sighting.text.size()) + " bytes; expected at most " +
           std::to_string(kMostText));
    sighting.text.clear();
  }
  if (sighting.distance_m < 0 || std::isinf(sighting.distance_m)) {
    refuse("distance of " + NumberText(sighting.distance_m) + " m");
    sighting.distance_m = std::numeric_limits<double>::quiet_NaN();
  }
  if (!(sighting.confidence >= 0 && sighting.confidence <= 1)) {
    refuse("confidence of " + NumberText(sighting.confidence) + "; expected 0 to 1");
    sighting.confidence = 0;
  }
}

void Race::OnLines(Index detector, std::uint32_t contours, std::string_view ycy,
                   std::string_view dy, double middle_offset, Time taken, Time now,
                   std::string_view doubt) {
  now_ = now;
  if (detector >= course_.detectors.size()) return;
  taken = std::min(taken, now + kMostAhead);
  const auto ycy_word = LineWordOf(ycy);
  const auto dy_word = LineWordOf(dy);
  if (!ycy_word || !dy_word) {
    return Refuse("lines", "a picture of the detector " + course_.detectors[detector].name +
                               " is refused: " + Shown(ycy) + " and " + Shown(dy) +
                               "; expected left, right, front, back or center");
  }
  const std::string why = Printable(doubt, kMostText);
  if (first_start_) {
    Record(input::kLines,
           {std::to_string(detector), std::to_string((taken - *first_start_).count()),
            std::to_string(contours), std::string(ycy), std::string(dy), NumberText(middle_offset),
            why});
  }
  runner_.perception().OnLines(detector, {contours, *ycy_word, *dy_word, middle_offset, why}, taken,
                               now);
}

// Each picture in doubt says the same: recorded is what is new.
void Race::OnDoubt(Index detector, std::string_view why, Time now) {
  now_ = now;
  if (detector >= course_.detectors.size()) return;
  const std::string text = Printable(why, kMostText);
  if (runner_.perception().DoubtOf(detector) == text) return;
  Record(input::kDoubt, {std::to_string(detector), text});
  runner_.perception().OnDoubt(detector, text);
}

// Where odometry does not count it is not recorded.
void Race::OnOdometry(std::int64_t stamp_ns, const navigation::Pose& pose, Time taken, Time now) {
  if (!course_.odometry.used() || !runner_.WantsOdometry(now)) return;
  now_ = now;
  const auto fits = [](double number, double most) { return std::abs(number) <= most; };
  const bool is_pose = fits(pose.at.x_m, kMostMetres) && fits(pose.at.y_m, kMostMetres) &&
                       fits(pose.yaw_rad, 2 * M_PI) && stamp_ns >= 0 && stamp_ns <= kMostStampNs;
  if (!is_pose) {
    return Refuse("odometry", "a sample of the odometry on " + course_.odometry.topic +
                                  " is refused: its position, rotation or stamp makes no sense");
  }
  taken = std::min(taken, now);
  if (first_start_) {
    Record(input::kOdometry,
           {std::to_string(stamp_ns), std::to_string((taken - *first_start_).count()),
            NumberText(pose.at.x_m), NumberText(pose.at.y_m), NumberText(pose.yaw_rad)});
  }
  runner_.OnOdometry(stamp_ns, pose, now - taken, now);
}

void Race::OnWalkerStatus(Index walk, std::string_view status, Time now) {
  now_ = now;
  const std::string_view text = Trimmed(status.substr(0, kMostText));
  if (text.empty()) return Refuse("walker", "an empty status of the line walker is refused");
  Record(input::kWalker, {std::to_string(walk), std::string(text)});
  runner_.lane_walker().OnStatus(walk, text);
}

void Race::OnMotionDone(std::uint64_t number, const Result<>& done, Time now) {
  now_ = now;
  Record(input::kMotionDone, {std::to_string(number), std::to_string(done ? 0 : done.error().code),
                              done ? "" : done.error().message});
  runner_.locomotion().OnMotionDone(number, done);
  ExecuteJump();
}

void Race::OnSpoken(std::uint64_t number, const Result<>& spoken, Time now) {
  now_ = now;
  Record(input::kSpoken, {std::to_string(number), std::to_string(spoken ? 0 : spoken.error().code),
                          spoken ? "" : spoken.error().message});
  runner_.voice().OnSpoken(number, spoken);
}

void Race::OnBody(int switch_status, int motion_id, Time now) {
  now_ = now;
  Record(input::kBody, {std::to_string(switch_status), std::to_string(motion_id)});
  runner_.locomotion().OnBody(switch_status, motion_id);
}

// In the pause it is led up after it, or lifted off its charger: it waits for START.
void Race::OnCharger(bool on, Time now) {
  if (!on && !on_charger_) return;
  now_ = now;
  Record(input::kCharger, {on ? "1" : "0"});
  on_charger_ = on;
  if (!on || !under_way()) return;
  if (resting_) {
    charged_ = true;
  } else if (!waits_for_start()) {
    runner_.OnFault("it is on a charger");
  }
}

void Race::OnTwoPublishers(std::string_view topic, Time now) {
  if (!under_way() || resting_) return;
  now_ = now;
  Record(input::kTwoPublishers, {std::string(topic)});
  runner_.OnFault("two publishers of " + Printable(topic, kMostText) +
                  ": both are believed in turn; end one of them, or give each robot its namespace");
}

void Race::OnServoReply(bool accepted, std::int32_t code, Time now) {
  now_ = now;
  Record(input::kServo, {accepted ? "1" : "0", std::to_string(code)});
  runner_.locomotion().OnServoReply(accepted, code);
}

void Race::OnCommand(std::string_view text, Time now, const Result<>& timely) {
  now_ = now;
  const std::string_view typed = Trimmed(text);
  if (typed.empty() || typed.size() > kMostText) {
    return Refuse("command", "a command is refused: it is empty or too long");
  }
  const Result<std::string> meant = CommandOf(course_, typed);
  if (!meant) return Refuse("command", "the command is refused: " + meant.error().message);
  const std::string& word = meant.value();
  const bool only_ends = word == command::kStop || word == command::kReset;
  if (!timely && !only_ends) {
    return Refuse("late", word + " is refused: " + timely.error().message);
  }
  if (word != command::kStart) {
    if (!first_start_ && early_commands_.size() < kMostEarly) early_commands_.push_back(word);
    Record(input::kCommand, {word});
    return Execute(word);
  }
  // The machine records its own commands.
  if (!running() || resting_) {
    return Refuse("START", "START is refused: the robot is not in a state that runs the race");
  }
  if (const Result<> sent = machine_->Send(command::kStart); !sent) {
    Refuse("START", sent.error().message);
  }
}

void Race::Execute(std::string_view word) {
  constexpr std::string_view kGoTo = "START:";
  if (ExecuteSet(word) || ExecuteOwn(word)) return;
  if (word == command::kStop || word == command::kReset) {
    start_counts_ = false;
    return word == command::kStop ? Stop() : JumpTo({course_.start, true});
  }
  if (word.starts_with(kGoTo)) return GoTo(Trimmed(word.substr(kGoTo.size())));
  std::vector<std::string> known = {"START", "STOP", "RESET"};
  for (const ResultRule& result : course_.results) known.push_back(result.command + "_DEFAULT");
  for (const CourseCommand& own : course_.commands) known.push_back(own.name);
  Refuse("command", "the command is refused: " + NoSuch("command", word, known));
}

// Also by a STOP in the machine's queue, which has dropped what was queued before. A reset that
// waits for the body stays one.
void Race::Stop() {
  if (runner_.state() == course_.start && !jump_) return;
  JumpTo({course_.start, jump_ && jump_->reset});
}

bool Race::ExecuteSet(std::string_view word) {
  for (Index i = 0; i < course_.results.size(); ++i) {
    const ResultRule& result = course_.results[i];
    if (result.command.empty() || !word.starts_with(result.command)) continue;
    const std::string_view rest = word.substr(result.command.size());
    if (rest == "_DEFAULT" && result.by_default) {
      SetResult(i, *result.by_default);
      return true;
    }
    if (!rest.starts_with(":")) continue;
    const auto value = std::ranges::find(result.values, Trimmed(rest.substr(1)));
    if (value == result.values.end()) {
      Refuse("command", std::string(word.substr(0, 60)) + " is refused: " +
                            NoSuch("value", Trimmed(rest.substr(1)), result.values));
    } else {
      SetResult(i, static_cast<Index>(value - result.values.begin()));
    }
    return true;
  }
  return false;
}

void Race::SetResult(Index result, Index value) {
  const ResultRule& rule = course_.results[result];
  if (rule.once && memory().Value(result)) {
    return Refuse("command", rule.command + " is refused: " + rule.name + " is already " +
                                 memory().Text(result));
  }
  runner_.memory().Set(result, value, true);
  outputs_.Log(rule.name + " is " + rule.values[value] + ", by command");
}

bool Race::ExecuteOwn(std::string_view word) {
  const auto found = FindByName(course_.commands, word);
  if (!found) return false;
  const CourseCommand& own = course_.commands[*found];
  const auto has = [this](const std::vector<Index>& states) {
    return std::ranges::find(states, runner_.state()) != states.end();
  };
  if (!running() || jump_ || !has(own.accepted)) {
    Refuse("command", own.name + " is refused in " + course_.states[runner_.state()].name);
    return true;
  }
  if (own.counter) runner_.memory().SetCount(*own.counter, own.value);
  if (has(own.leaves)) runner_.SkipSteps();
  return true;
}

void Race::GoTo(std::string_view target) {
  std::optional<Index> state = FindByName(course_.states, target);
  int number = -1;
  const auto [end, error] = std::from_chars(target.data(), target.data() + target.size(), number);
  for (Index i = 0; i < course_.states.size() && !state; ++i) {
    const bool whole = error == std::errc() && end == target.data() + target.size();
    if (whole && course_.states[i].number == number) state = i;
  }
  if (!state) {
    std::vector<std::string> names;
    for (const StateRule& rule : course_.states) names.push_back(rule.name);
    return Refuse("command", "START: is refused: " + NoSuch("state", target, names));
  }
  if (resting_ || !running()) {
    return Refuse("START", "START:" + course_.states[*state].name +
                               " is refused: the robot is not in a state that runs the race");
  }
  start_counts_ = false;
  JumpTo({*state, false});
}

// At once where the body is free, else after the reply of its motion; until then it stands still.
void Race::JumpTo(const Jump& jump) {
  if (!running()) {
    if (jump.reset) runner_.memory().Forget();
    return;
  }
  jump_ = jump;
  runner_.Leave();
  ExecuteJump();
}

// Not inside of a tick, where it fails and is repeated after it.
void Race::ExecuteJump() {
  if (!jump_ || replays_ || !running() || runner_.locomotion().busy()) return;
  const Jump jump = *jump_;
  const Result<> done =
      jump.reset ? machine_->Reset() : machine_->Force(course_.states[jump.state].name);
  static_cast<void>(done);
}

void Race::Pause(Time now) {
  now_ = now;
  Record(input::kRest, {});
  if (!std::exchange(resting_, true)) rested_at_ = now;
  start_counts_ = false;
  DropJump("the race is paused before the body was free for it");
  runner_.Pause(now);
  ExecuteJump();
}

void Race::DropJump(const std::string& why) {
  if (!jump_ || jump_->state == course_.start) return;
  outputs_.Log("START:" + course_.states[jump_->state].name + " is dropped: " + why);
  jump_ = Jump{course_.start, false};
}

void Race::Resume(Time now) {
  now_ = now;
  Record(input::kResume, {});
  resting_ = false;
  if (!std::exchange(has_run_, true)) {  // a walk of a process before, which has crashed
    for (const LaneWalk& walk : course_.walks) outputs_.CommandWalker(walk, false);
  }
  runner_.Resume(machine_ == nullptr ? Duration(0) : machine_->time());
  // In a long pause people come near, or put the robot on its charger.
  const std::optional<Time> rested_at = std::exchange(rested_at_, std::nullopt);
  const Duration within = course_.robot.resume_within;
  const bool charged = std::exchange(charged_, false) || on_charger_;
  const Duration asleep = std::exchange(rest_breaks_, {});
  const bool was_long = rested_at && within > Duration(0) && now - *rested_at + asleep > within;
  if (!under_way() || (!charged && !was_long)) return;
  Hold(charged ? "it was, or is, on a charger"
               : "the pause was longer than " + std::to_string(ToMilliseconds(within)) + " ms");
}

// The body has stood without frames. Its place is not known, as no odometry was received.
void Race::OnBreak(Duration length, Time now) {
  const bool holds = under_way() && !waits_for_start();
  const bool drops = start_counts_ || (jump_ && jump_->state != course_.start);
  if (!resting_ && !holds && !drops) return;
  now_ = now;
  Record(input::kBreak, {std::to_string(length.count())});
  if (resting_) {
    rest_breaks_ += length;
    return;
  }
  start_counts_ = false;
  DropJump("this process could not run");
  if (!holds) return;
  runner_.Pause(now);
  runner_.Resume(machine_->time());
  ExecuteJump();
  if (!under_way()) return;
  Hold("this process could not run for " + std::to_string(ToMilliseconds(length)) + " ms");
}

void Race::Hold(const std::string& why) {
  if (!held_from_) held_from_ = machine_->time();
  outputs_.Log(course_.states[runner_.state()].name + ": " + why + ": it goes on after START");
}

void Race::GoOn() {
  const Duration now = machine_->time();
  outputs_.Log(course_.states[runner_.state()].name + ": goes on by START");
  runner_.GoOn(now, now - *std::exchange(held_from_, std::nullopt));
}

void Race::OnInput(const fsm::Machine& machine, const fsm::Input& input) {
  if (input.kind == fsm::Input::Kind::kStart) {
    now_ = input.time;
    if (!first_start_) first_start_ = input.time;
  }
  const bool is_start =
      input.kind == fsm::Input::Kind::kCommand && machine.Name(input.command) == command::kStart;
  if (is_start) start_counts_ = true;
  if (input.kind != fsm::Input::Kind::kTick) return;
  now_ = input.time;
  for (const std::string& word : std::exchange(early_commands_, {})) {
    Record(input::kCommand, {word});
  }
  log_.Tick(input.time);
}

void Race::OnChange(const fsm::Machine& machine, const fsm::Change& change) {
  decided_ = change.cause == fsm::Cause::kDecided;
  if (change.cause != fsm::Cause::kDecided) {
    jump_.reset();
    held_from_.reset();
  }
  if (change.cause == fsm::Cause::kReset) {
    runner_.memory().Forget();
    runner_.ForgetReason();
  }
  if (change.to == fsm::kNoState) return runner_.perception().Close();
  if (change.from == change.to) return;
  const auto state = FindByName(course_.states, machine.Name(change.to));
  if (state) outputs_.ShowState(course_.states[*state].number);
}

}  // namespace musher::race
