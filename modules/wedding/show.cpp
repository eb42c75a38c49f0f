#include "musher/modules/wedding/show.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "musher/modules/wedding/faces.hpp"
#include "musher/modules/wedding/recording.hpp"
#include "musher/modules/wedding/show_states.hpp"

namespace musher::wedding {
namespace {

constexpr Duration kLogPeriod = std::chrono::seconds(2);  // of each kind of fault

constexpr std::string_view kInvalid = "INVALID";       // as on the robot it models
constexpr std::size_t kMostShown = 40;                 // of an unknown word
constexpr double kFarthestRad = 4 * std::numbers::pi;  // no joint of a body turns further

std::string Shown(std::string_view word) {
  return "'" + std::string(word.substr(0, kMostShown)) + "'";
}

}  // namespace

Show::Show(const ShowConfig& config, ShowOutputs& outputs)
    : config_(config),
      outputs_(outputs),
      perception_(config.perception, config.gaze),
      log_([&outputs](const std::string& line) { outputs.Log(line); }, kLogPeriod) {
  data_.follow = config.gaze.follow;
  if (config.actions) actions_.emplace(config.actions->seed);
}

Show::~Show() {
  if (machine_ == nullptr) return;
  machine_->Forget(this);
  machine_->ForgetInputs(this);
}

Result<> Show::Build(fsm::Machine& machine) {
  AddStates(machine, data_, config_, actions_ ? &*actions_ : nullptr);
  if (Result<> built = machine.Build(state::kIdle); !built) return built;
  machine_ = &machine;
  machine.Listen(this);
  machine.ListenToInputs(this);
  return Ok();
}

std::string_view Show::state() const {
  const bool running = machine_ != nullptr && machine_->running();
  return running ? machine_->Name(machine_->current()) : kInvalid;
}

void Show::Note(Time now) {
  if (now < now_) perception_.Forget();
  now_ = now;
}

void Show::Refuse(std::string_view kind, const Result<>& result) {
  if (!result) log_.Log(kind, result.error().message, now_);
}

// The time in a recording of an input received at now_.
void Show::Record(std::string_view input, std::initializer_list<double> numbers) {
  if (recorder_ == nullptr || !first_start_) return;
  recorder_->Input(input, InputText(now_ - *first_start_, numbers));
}

void Show::OnTarget(const Target& target, Time now) {
  Note(now);
  const Result<> taken = perception_.OnTarget(target, now);
  if (!taken) return Refuse("target", taken);
  Record(input::kTarget, {target.point.x, target.point.y, target.distance_m,
                          static_cast<double>(target.stamp.count())});
}

void Show::OnGesture(std::string_view word, Time now) {
  Note(now);
  const Result<> taken = perception_.OnGesture(word, now);
  if (!taken) return Refuse("gesture", taken);
  if (recorder_ != nullptr && first_start_) {
    recorder_->Input(input::kGesture, InputText(now - *first_start_, word));
  }
}

void Show::OnTooClose(bool too_close, Time now, PublisherId publisher) {
  Note(now);
  perception_.OnTooClose(too_close, publisher, now);
  RecordTooClose();
}

void Show::OnTooClosePublisherLost(PublisherId publisher, Time now) {
  Note(now);
  const bool before = perception_.too_close();
  perception_.OnTooClosePublisherLost(publisher, now);
  if (perception_.too_close() != before) RecordTooClose();
}

// A recording has one publisher, with the merged value of all.
void Show::RecordTooClose() {
  Record(input::kTooClose, {perception_.too_close() ? 1.0 : 0.0});
}

void Show::OnFaces(std::string_view json, Time now) {
  Note(now);
  const Result<Faces> faces = ReadFaces(json);
  if (!faces) return Refuse("faces", faces.error());
  perception_.OnFaces(faces.value(), now);
  const auto count = static_cast<double>(faces.value().count);
  const auto id = static_cast<double>(faces.value().largest_frontal);
  if (const auto& center = faces.value().center) {
    Record(input::kFace,
           {count, id, center->x, center->y, static_cast<double>(faces.value().stamp.count())});
  } else {
    Record(input::kFaces, {count, id});
  }
}

void Show::OnCommand(std::string_view word, Time now, const Result<>& timely) {
  Note(now);
  const std::string command = Tidy(word);
  const bool only_ends =
      command == command::kStop || command == command::kIdle || command == command::kReset;
  if (!timely && !only_ends) return Refuse("late", timely);
  if (command == command::kReset) return Refuse("command", Reset(now));
  const auto event = machine_ == nullptr ? std::nullopt : machine_->FindEvent(command);
  if (!event) {
    return log_.Log("command", "command " + Shown(command) + ": not in this show", now);
  }
  if (resting_) {
    return log_.Log("resting", "command " + command + " is refused: the show is paused", now);
  }
  Refuse("no room", machine_->Send(*event));
}

void Show::OnVoiceCommand(std::string_view word, Time now, const Result<>& timely) {
  Note(now);
  const std::string voice = Tidy(word);
  for (const std::string_view known :
       {std::string_view("none"), command::kStop, command::kPhoto, command::kInterview}) {
    if (voice != known) continue;
    if (!timely && known != "none" && known != command::kStop) return Refuse("late", timely);
    data_.audio.voice_command = known;
    if (known != "none") OnCommand(known, now, timely);
    return;
  }
  log_.Log("voice", "voice command " + Shown(voice) + ": none, stop, photo or interview are known",
           now);
}

void Show::OnVoiceLevel(double level, Time now) {
  Note(now);
  if (!(level >= 0 && level <= 1)) {
    return log_.Log("voice", "voice level " + std::to_string(level) + ": it is 0 to 1", now);
  }
  perception_.OnVoice(level, now);
  Record(input::kVoiceLevel, {level});
}

Result<> Show::TakeJoints(JointAngles& joints, std::span<const std::string> names,
                          std::span<const double> positions) {
  const std::size_t count = names.empty() ? kJointCount : names.size();
  if (positions.size() != count) {
    return Error{kCodeFailed, "joints: " + std::to_string(positions.size()) + " positions for " +
                                  std::to_string(count) + " joints"};
  }
  JointAngles taken = joints;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(std::abs(positions[i]) <= kFarthestRad)) {  // so is NaN
      return Error{kCodeFailed, "joints: a position of " + std::to_string(positions[i]) +
                                    " rad: at most two turns to each side"};
    }
    std::size_t joint = i;
    if (!names.empty()) {
      const auto* known = std::find(kJointNames.begin(), kJointNames.end(), names[i]);
      if (known == kJointNames.end()) {
        return Error{kCodeFailed, "joints: there is no " + Shown(names[i])};
      }
      joint = static_cast<std::size_t>(known - kJointNames.begin());
    }
    taken.at(joint) = positions[i];
  }
  joints = taken;
  return Ok();
}

void Show::OnJointStates(std::span<const std::string> names, std::span<const double> positions,
                         Duration stamp, Time now) {
  Note(now);
  const Result<> taken = TakeJoints(data_.motion.joint_positions, names, positions);
  if (!taken) return Refuse("joints", taken);
  const double yaw_rad = LookYaw(data_.motion.joint_positions);
  perception_.OnHead(stamp, yaw_rad, now);
  if (config_.gaze.camera == Mount::kBody) return;  // not needed there
  Record(input::kHead, {static_cast<double>(stamp.count()), yaw_rad});
}

void Show::OnLookAt(Gaze gaze, Time now) {
  Note(now);
  Refuse("target", perception_.OnLookAt(gaze, now));
}

void Show::OnCamera(double width, double height, double focal_length, Time now) {
  Note(now);
  const Result<bool> news = perception_.OnCamera(width, height, focal_length);
  if (!news) return Refuse("target", news.error());
  if (news.value()) Record(input::kCamera, {width, height, focal_length});
}

void Show::OnJointCommands(std::span<const std::string> names, std::span<const double> positions,
                           Time now) {
  Note(now);
  Refuse("joints", TakeJoints(data_.motion.joint_commands, names, positions));
}

void Show::AfterTick() {
  MotionData& motion = data_.motion;
  if (motion.target_pose != motion.current_pose) {
    motion.current_pose = motion.target_pose;
    outputs_.TakePose(motion.current_pose);
  }
  if (motion.target_motion != motion.current_motion) {
    motion.current_motion = motion.target_motion;
    outputs_.SetMotion(motion.current_motion);
  }
  while (const auto sound = data_.audio.pending_speech.Pop()) outputs_.Play(*sound);
  if (std::exchange(data_.photo_requested, false)) outputs_.TakePhoto();
  if (const auto video = std::exchange(data_.video_wanted, std::nullopt)) {
    outputs_.RecordVideo(*video);
  }
  outputs_.LookAt(motion.look_at_target);
}

void Show::Pause(Time now, bool frozen) {
  Note(now);
  Record(input::kRest, {});
  Clear();
  resting_ = true;
  // In IDLE already: no transition, so that pauses do not fill the history.
  const bool home = state() == state::kIdle && machine_->waiting_commands() == 0;
  if (machine_ != nullptr && machine_->running() && !home) {
    Refuse("fault", machine_->Reset());
  }
  if (actions_) actions_->Stop(data_);
  if (!frozen) AfterTick();
}

void Show::Resume(Time now) {
  Note(now);
  Record(input::kResume, {});
  Clear();
  resting_ = false;
}

// As if nothing had been seen, said or done.
void Show::Clear() {
  perception_.Forget();
  data_.audio.pending_speech.Clear();
  data_.photo_requested = false;
  data_.left_alone = false;
  data_.too_close_warned = 0;
  data_.motion.target_pose = pose::kNeutral;
  data_.motion.look_at_target = Gaze{};
  if (actions_) actions_->Stop(data_);
  ticked_at_.reset();
  data_.motion.current_motion = {};
  data_.motion.current_pose = {};  // published again: its subscriber may have been restarted
}

Result<> Show::Reset(Time now) {
  Note(now);
  return machine_ == nullptr ? Error{kCodeFailed, "there is no machine"} : machine_->Reset();
}

Result<> Show::Force(std::string_view state, Time now) {
  Note(now);
  return machine_ == nullptr ? Error{kCodeFailed, "there is no machine"} : machine_->Force(state);
}

void Show::OnInput(const fsm::Machine& /*machine*/, const fsm::Input& input) {
  if (input.kind == fsm::Input::Kind::kStart && !first_start_) first_start_ = input.time;
  if (input.kind != fsm::Input::Kind::kTick) return;
  Note(input.time);
  // A recording begins with the start; a guest who was too close before it still is.
  if (!std::exchange(initial_inputs_recorded_, true) && perception_.too_close())
    Record(input::kTooClose, {1});
  log_.Tick(input.time);
  perception_.OnGaze(data_.motion.look_at_target, input.time);
  perception_.Refresh(input.time, data_);
  // SEARCH tracks a face that it sees, and scans without one.
  if (actions_ && state() == state::kSearch) {
    actions_->Start(*ActionOnEntering(state::kSearch, data_), data_);
  }
  if (actions_) actions_->Tick(ticked_at_ ? input.time - *ticked_at_ : Duration(0), data_);
  ticked_at_ = input.time;
}

void Show::OnChange(const fsm::Machine& machine, const fsm::Change& change) {
  const std::string_view to = machine.Name(change.to);
  if (to == state::kIdle && change.cause == fsm::Cause::kForced) data_.LeaveAlone();
  const bool again = change.cause == fsm::Cause::kReset || change.cause == fsm::Cause::kStarted;
  if (again || (to != state::kIdle && to != state::kSafeStop)) data_.left_alone = false;
  if (actions_) {
    const auto action = ActionOnEntering(to, data_);
    action ? actions_->Start(*action, data_) : actions_->Stop(data_);
  }
  if (change.from != change.to) outputs_.ShowState(to.empty() ? kInvalid : to);
}

}  // namespace musher::wedding
