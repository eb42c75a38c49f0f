#include "musher/modules/motion/lcm_link.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "musher/modules/motion/motion_code.hpp"

namespace musher::motion {
namespace {

// Of this process; a frame is due all the time.
constexpr Duration kHang = kNoResponse - 2 * kHeartbeatPeriod;

constexpr std::int8_t kModeNone = -1;  // of a frame that is a heartbeat and no command
constexpr std::int8_t kModeOff = 0;
constexpr std::int8_t kModeDamping = 7;
constexpr std::int8_t kModeWalk = 11;
constexpr std::int8_t kModeStand = 12;
constexpr std::array<std::int8_t, 3> kModesOfWalks = {kModeWalk, 81, 82};
constexpr std::int8_t kGaitStand = 1;  // of kModeWalk
constexpr std::int8_t kGaitOfUser = 110;
// Of kModeWalk: with zero speed the body stays in its place. It does not in pronks, bounds and the
// gaits of users.
constexpr std::array<std::int8_t, 9> kGaitsInPlace = {1, 3, 10, 26, 27, 28, 29, 30, 31};

bool IsEmergencyStop(const BodyCommand& command) {
  return command.mode == kModeOff;
}
bool IsRecoveryStand(const BodyCommand& command) {
  return command.mode == kModeStand && command.gait == 0;
}
bool HasSpeed(const BodyCommand& command) {
  return std::any_of(command.vel.begin(), command.vel.end(), [](float v) { return v != 0; });
}
// Other motions do not use the speed that their request may have; the gait of a user has its own.
bool Walks(const BodyCommand& command) {
  const bool is_walk = std::ranges::find(kModesOfWalks, command.mode) != kModesOfWalks.end();
  return command.gait == kGaitOfUser || (is_walk && HasSpeed(command));
}
// After it the body moves no further.
bool Stops(const BodyCommand& command) {
  return IsEmergencyStop(command) || command.mode == kModeDamping ||
         (command.mode == kModeWalk && command.gait == kGaitStand && !HasSpeed(command));
}

bool IsStatus(const BodyReport& report, SwitchStatus status) {
  return report.switch_status == static_cast<std::int8_t>(status);
}
// The board goes off when the body tilts, and keeps ori_error until the body walks again, also when
// it has stood up or lain down since.
bool IsTilted(const BodyReport& report) {
  return report.ori_error != 0 && report.mode == kModeOff;
}
// Nothing but recovery stand may follow.
bool NeedsRecovery(const BodyReport& report) {
  return IsStatus(report, SwitchStatus::kEstop) || IsStatus(report, SwitchStatus::kEdamp) ||
         report.mode == kModeOff;
}

// A status of the motion manager: the board reports some faults beside its status.
std::int8_t StatusWithFaults(const BodyReport& report) {
  const bool fine = IsStatus(report, SwitchStatus::kNormal);
  const auto status = [](SwitchStatus s) { return static_cast<std::int8_t>(s); };
  if (fine && IsTilted(report)) return status(SwitchStatus::kOrientation);
  if (fine && report.footpos_error != 0) return status(SwitchStatus::kFootPosition);
  return report.switch_status;
}

// "192.168.44.233" of "192.168.44.233:40000".
std::string_view HostOf(std::string_view sender) {
  return sender.substr(0, sender.rfind(':'));
}

// Any two numbers of a board, of which the second is the lower one: their difference need not fit.
std::uint64_t MillisecondsBack(Duration from, Duration to) {
  constexpr std::uint64_t kNanosecondsInOne = 1'000'000;
  return (static_cast<std::uint64_t>(from.count()) - static_cast<std::uint64_t>(to.count())) /
         kNanosecondsInOne;
}

std::string Number(int value) {
  return std::to_string(value);
}
std::string MotionText(const BodyCommand& command) {
  return "mode " + Number(command.mode) + " gait " + Number(command.gait) + ", life count " +
         Number(static_cast<std::uint8_t>(command.life_count));
}

}  // namespace

NewestOnly::Age NewestOnly::Take(std::uint32_t number, Time now) {
  const bool first = !newest_;
  const bool newer = first || static_cast<std::int32_t>(number - *newest_) > 0;
  if (!newer && now - newest_at_ < kRestartPause) return Age::kOld;
  newest_ = number;
  newest_at_ = now;
  return newer ? Age::kNew : Age::kRestarted;
}

// --- commands ---

bool LcmLink::MaySend(const BodyCommand& command, Time now) const {
  if (IsEmergencyStop(command)) return true;
  if (stopped_ && !IsRecoveryStand(command)) return false;
  if (Held(now) || looking_ || Silent(now)) return Stops(command);
  if (NeedsRecovery(body_.report)) return IsRecoveryStand(command);
  if (IsStatus(body_.report, SwitchStatus::kLifted) && Walks(command)) return false;
  return counted_ || IsRecoveryStand(command) || Stops(command);
}

LinkOutput LcmLink::OnCommand(const BodyCommand& command, Time now) {
  LinkOutput output;
  if (HasHung(now)) Look(std::nullopt);
  kept_at_ = now;
  if (command.life_count == wanted_) return output;  // repeated: the link does so by itself
  taken_ = 0;
  if (!WaitsForStop()) unconfirmed_.reset();
  if (!MaySend(command, now)) {
    wanted_ = 0;
    return output;
  }
  wanted_ = command.life_count;
  stopped_ = IsEmergencyStop(command);
  if (stopped_) looking_ = false;
  recounts_ = counted_ ? 0 : 1;  // a stop or recovery stand, which may be taken twice
  Begin(command, now, output, stopped_ ? kStopCopies : 1);
  own_ = false;
  return output;
}

Duration LcmLink::Period(Time now) const {
  const bool repeated = unconfirmed_ || ambiguous_;
  return repeated && now - begun_at_ < kRepeatTime ? kUntilTaken : kHeartbeatPeriod;
}

void LcmLink::Begin(const BodyCommand& command, Time now, LinkOutput& output, int copies) {
  begun_at_ = now;
  unconfirmed_ = now;
  ambiguous_ = body_.report.mode == command.mode && body_.report.gait == command.gait;
  bar_ = body_.report.bar;
  begun_ = false;
  was_changing_ = IsStatus(body_.report, SwitchStatus::kTransitioning);
  frame_ = command;
  Renew(now, output, copies);
}

// The frame is new to the board, again.
void LcmLink::Renew(Time now, LinkOutput& output, int copies) {
  frame_->life_count = static_cast<std::int8_t>(++life_);
  counted_ = true;
  tick_at_ = now + Period(now);
  output.frames.insert(output.frames.end(), static_cast<std::size_t>(copies), *frame_);
}

// `end` nullopt: 100 ms after the next response.
void LcmLink::Look(std::optional<Time> end) {
  looking_ = true;
  look_end_ = end;
  frame_.reset();
  unconfirmed_.reset();
  counted_ = false;
}

// The board may have left it meanwhile.
void LcmLink::RenewStop(Time now) {
  recounts_ = 1;
  unconfirmed_ = now;
}

void LcmLink::OnSuspended(Duration duration) {
  if (duration < kHang) return;
  if (stopped_) return RenewStop(tick_at_);
  Look(std::nullopt);
}

// This process hung: the board may have let the body lie down, which it does after 500 ms without a
// frame, and may have had another commander since. An emergency stop is kept.
bool LcmLink::HasHung(Time now) {
  if (now - tick_at_ < kHang) return false;
  tick_at_ = now;
  if (stopped_) RenewStop(now);
  return !stopped_;
}

// The body goes on as it is, where it is.
void LcmLink::Hold(Time now, LinkOutput& output) {
  const BodyReport& report = body_.report;
  if (NeedsRecovery(report)) return;
  BodyCommand hold;
  hold.mode = report.mode;
  hold.gait = report.gait;
  const bool in_place = std::ranges::find(kGaitsInPlace, hold.gait) != kGaitsInPlace.end();
  if (hold.mode == kModeWalk && !in_place) hold.gait = kGaitStand;
  if (hold.mode != kModeDamping && hold.mode != kModeWalk && !IsRecoveryStand(hold)) return;
  constexpr std::int8_t kAllFeet = 0x0F;
  constexpr float kStepHeightM = 0.05F;
  hold.contact = kAllFeet;
  hold.step_height = {kStepHeightM, kStepHeightM};
  recounts_ = 1;
  Begin(hold, now, output, 1);
  own_ = true;
}

// --- the board ---

// Positions and temperatures are those of the board whose responses are believed. A restart changes
// its port, not its host.
bool LcmLink::IsBoard(const Stream& stream, const Sender& sender) const {
  const std::string_view host = HostOf(sender.name);
  if (!options_.board.empty()) return host == options_.board;
  const bool first = &stream == &responses_ && responses_.sender.empty();
  return first || IsOnHostOfBoard(sender);
}

bool LcmLink::IsHostOfBoard(const std::string& sender) const {
  const std::string& board = options_.board;
  return HostOf(sender) == (board.empty() ? HostOf(responses_.sender) : std::string_view(board));
}

bool LcmLink::IsOnHostOfBoard(const Sender& sender) const {
  const bool here = sender.place == transport::HostPlace::kThisComputer;
  return IsHostOfBoard(sender.name) || (options_.board.empty() && on_this_computer_ && here);
}

// A host that was away for a while begins again, unless the board has responded since its begin.
void LcmLink::NoteOtherHost(const Sender& sender, Time now) {
  const std::string host(HostOf(sender.name));
  auto found = other_hosts_.find(host);
  if (found == other_hosts_.end()) {
    if (other_hosts_.size() > kMostOtherHosts) return;
    found = other_hosts_.emplace(host, OtherHost{now, now}).first;
  }
  OtherHost& other = found->second;
  const bool beside = responses_.at && *responses_.at - other.first_at >= kRestartPause;
  if (!beside && now - other.last_at >= kRestartPause) other.first_at = now;
  other.last_at = now;
}

// Whether the board has that address now. Its last datagrams from the old one may come late.
bool LcmLink::HasMovedTo(const Sender& sender, Time now) const {
  if (!options_.board.empty() || other_hosts_.size() > kMostOtherHosts) return false;
  if (sender.place == transport::HostPlace::kElsewhere) return false;
  const auto candidate = other_hosts_.find(HostOf(sender.name));
  if (candidate == other_hosts_.end() || now - *responses_.at < kNewAddress) return false;
  const Time since = candidate->second.first_at;
  if (now - since < kNewAddress || *responses_.at - since >= kRestartPause) return false;
  return std::ranges::all_of(other_hosts_, [&](const auto& other) {
    return other.first == candidate->first || now - other.second.last_at >= kNewAddress;
  });
}

// It takes the commands of the same group, so that they would move two bodies.
void LcmLink::NoteSecondBoard(const Stream& stream, const std::string& board, const Sender& second,
                              Time now, LinkOutput& output) {
  if (&stream != &responses_) return;
  const bool same_host = HostOf(board) == HostOf(second.name);
  Yield("two motion boards take these commands: " + board + ", " + second.name +
            (same_host ? ", or the board has restarted" : "") +
            "; switch one of them off, or give it other multicast groups",
        now, output);
  second_board_at_ = now;
}

NewestOnly::Age LcmLink::Take(Stream& stream, const Sender& sender, Time now, LinkOutput& output) {
  using Age = NewestOnly::Age;
  if (!IsBoard(stream, sender)) {
    const std::string board = options_.board.empty() ? responses_.sender : options_.board;
    if (board.empty()) return Age::kOld;  // none has responded yet
    if (&stream == &responses_) NoteOtherHost(sender, now);
    if (&stream != &responses_ || !HasMovedTo(sender, now)) {
      Fault("another host",
            {MotionCode(KeyCode::kTargetBusy), "messages of a motion board from " + sender.name +
                                                   " are ignored: the motion board is " + board},
            now, output);
      NoteSecondBoard(stream, board, sender, now, output);
      return Age::kOld;
    }
    other_hosts_.erase(std::string(HostOf(sender.name)));
  }
  const bool lost = !stream.at || now - *stream.at >= kRestartPause;
  if (sender.name != stream.sender && !lost) {
    Fault("second board",
          {MotionCode(KeyCode::kTargetBusy),
           "a second motion board answers from " + sender.name +
               " and is ignored, or the board has restarted; the first one is at " + stream.sender},
          now, output);
    NoteSecondBoard(stream, stream.sender, sender, now, output);
    return Age::kOld;
  }
  const bool another = !stream.sender.empty() && sender.name != stream.sender;
  if (sender.name != stream.sender) stream.order = NewestOnly();
  if (&stream == &responses_ && !IsHostOfBoard(sender.name)) {
    on_this_computer_ = sender.place == transport::HostPlace::kThisComputer;
  }
  stream.sender = sender.name;
  const Age age = stream.order.Take(sender.sequence, now);
  if (age != Age::kOld) stream.at = now;
  return another ? Age::kRestarted : age;
}

void LcmLink::Restart(Time now, LinkOutput& output) {
  output.restarted = true;
  if (stopped_) {  // which is kept
    RenewStop(now);
  } else {
    wanted_ = taken_ = 0;
    Look(now + kLookTime);
  }
}

LinkOutput LcmLink::OnResponse(const Sender& sender, const BodyReport& report, Time now) {
  LinkOutput output;
  WatchRate(now, output);  // a stream of commands puts OnTime() off
  ++in_second_;
  const bool was_silent = responses_.at && Silent(now);
  const std::string before = responses_.sender;
  const bool moved = !before.empty() && !IsOnHostOfBoard(sender);
  const NewestOnly::Age age = Take(responses_, sender, now, output);
  if (age == NewestOnly::Age::kOld) return output;
  const bool returns = was_silent && !stopped_ && !WaitsForStop();
  if (age == NewestOnly::Age::kRestarted) {
    Restart(now, output);
    if (moved) {  // its process may be the same: it may still be moved by its motors
      output.faults.push_back(
          {MotionCode(MotionKey::kBoardSilent), "the motion board answers from " + sender.name +
                                                    " now, as no other host does; " + before +
                                                    " is silent: what it was commanded is void"});
    } else {
      motors_taken_ = false;
      Fault("restart",
            {MotionCode(MotionKey::kBoardSilent),
             "the motion board (" + sender.name + ") has restarted: what it was commanded is void"},
            now, output);
    }
  } else if (returns && !GoesOn(report, now)) {
    Look(now + kLookTime);  // it may have restarted all the same
  } else if (was_silent && stopped_) {
    RenewStop(now);
  }
  const Temperatures temperatures = body_.report.motor_temperature;
  body_.report = report;
  body_.report.motor_temperature = temperatures;
  received_at_ = now - sender.age;
  if (looking_ && !look_end_) look_end_ = now + kLookTime;
  NoteBegun();
  NoteTaken();
  if (returns && frame_) {  // only heartbeats follow: they are no command to a board that restarted
    unconfirmed_.reset();
    ambiguous_ = false;
    recounts_ = 0;
  }
  // What was commanded before the board stopped by itself must not begin when it recovers.
  if (NeedsRecovery(report) && frame_ && !stopped_ && !IsRecoveryStand(*frame_)) frame_.reset();
  pending_ = true;
  if (!handed_on_ || now - *handed_on_ >= kBetweenReports) HandOn(now, output);
  return output;
}

// Whether the body does what the stop wants. A body that lies needs none of a walk.
bool LcmLink::HasStopped() const {
  const BodyReport& report = body_.report;
  if (report.mode == kModeOff || IsStatus(report, SwitchStatus::kEstop)) return true;
  if (IsEmergencyStop(*frame_)) return false;
  if (report.mode == kModeDamping) return true;
  return report.mode == frame_->mode && report.gait == frame_->gait &&
         IsStatus(report, SwitchStatus::kNormal);
}

// The frame gets a new count while it stops the body and the board does not show it: another
// program may have used its count before.
bool LcmLink::IsRenewed(Time now) const {
  if (!unconfirmed_) return false;
  if (Stops(*frame_)) return !HasStopped();
  const bool walks = own_ && frame_->mode == kModeWalk;
  return walks && now - begun_at_ < kHoldTime && !IsStill();
}

// By its odometry since the frame began.
bool LcmLink::IsStill() const {
  constexpr double kStillMS = 0.05;
  constexpr double kStillRadS = 0.1;
  return locations_.at && *locations_.at > begun_at_ && body_.motion.v_B.norm() < kStillMS &&
         body_.motion.w_B.norm() < kStillRadS;
}

// For a stop of the motion manager to be taken.
bool LcmLink::WaitsForStop() const {
  return frame_ && unconfirmed_ && !own_ && Stops(*frame_);
}

// The body was in the mode and gait of the frame already. The end of a transition that began before
// the frame says nothing: it may begin the motion before.
void LcmLink::NoteBegun() {
  if (!ambiguous_ || received_at_ - begun_at_ < kControlPeriod) return;
  const BodyReport& report = body_.report;
  const bool changing = IsStatus(report, SwitchStatus::kTransitioning);
  if (!was_changing_ && (changing || report.bar < bar_)) begun_ = true;
  bar_ = report.bar;
}

// The board does not say which command it has taken: its motion shows it. A transition that began
// before the command belongs to another one. A stop is sent on until the body has stopped.
void LcmLink::NoteTaken() {
  if (!unconfirmed_ || !frame_ || received_at_ - *unconfirmed_ < kControlPeriod) return;
  const BodyReport& report = body_.report;
  if (!IsStatus(report, SwitchStatus::kTransitioning)) was_changing_ = false;
  const bool shown = report.mode == frame_->mode && report.gait == frame_->gait;
  const bool changing =
      IsStatus(report, SwitchStatus::kTransitioning) && (!was_changing_ || (shown && !ambiguous_));
  const bool same = IsStatus(report, SwitchStatus::kNormal) && shown;
  const bool off = stopped_ && (report.mode == kModeOff || IsStatus(report, SwitchStatus::kEstop));
  if (own_ && !Stops(*frame_)) return;  // IsRenewed()
  if (!off && !same && !changing) return;
  if (!own_) taken_ = wanted_;
  if (off || same || !Stops(*frame_)) unconfirmed_.reset();
}

void LcmLink::HandOn(Time now, LinkOutput& output) {
  body_.report.life_count = taken_;
  body_.report.motors_taken = motors_taken_;
  const bool may_begin = frame_ && !own_ && !begun_ && received_at_ - begun_at_ < kBegunWithin;
  body_.report.ambiguous = ambiguous_ && may_begin;
  output.body = body_;
  output.body->report.switch_status = StatusWithFaults(body_.report);
  output.body->age = now - received_at_;
  body_.has_new_motion = false;
  pending_ = false;
  handed_on_ = now;
}

LinkOutput LcmLink::OnLocation(const Sender& sender, const BoardLocation& location, Duration stamp,
                               Time now) {
  LinkOutput output;
  const NewestOnly::Age age = Take(locations_, sender, now, output);
  if (age == NewestOnly::Age::kOld) return output;
  if (age == NewestOnly::Age::kNew && location.timestamp < location_stamp_) {
    const auto back_ms = MillisecondsBack(location_stamp_, location.timestamp);
    Fault("timestamp",
          {MotionCode(KeyCode::kParametersInvalid),
           "the timestamps of " + std::string(kLocalizationChannel) + " go back, by " +
               std::to_string(back_ms) + " ms: the odometry has the time of this computer"},
          now, output);
  }
  location_stamp_ = location.timestamp;
  body_.motion = location.motion;
  body_.motion.stamp = stamp;
  body_.has_new_motion = true;
  return output;
}

LinkOutput LcmLink::OnTemperatures(const Sender& sender, const Temperatures& temperatures,
                                   Time now) {
  LinkOutput output;
  if (Take(temperatures_, sender, now, output) == NewestOnly::Age::kOld) return output;
  body_.report.motor_temperature = temperatures;
  return output;
}

// --- faults ---

void LcmLink::Yield(const std::string& why, Time now, LinkOutput& output) {
  if (!Held(now)) output.held_by = why;
  held_ = true;
}

LinkOutput LcmLink::OnOtherFrame(const std::string& sender, const BodyCommand& frame, Time now) {
  LinkOutput output;
  const std::string who = sender + " (" + MotionText(frame) + ")";
  Yield("another program commands the motion board: " + who +
            "; close the app or the other motion manager",
        now, output);
  other_at_ = now;
  Fault(
      "other sender",
      {MotionCode(KeyCode::kTargetBusy), "another program commands the motion board: " + who +
                                             (frame_ ? "; this one: " + MotionText(*frame_) : "") +
                                             "; close the app or the other motion manager"},
      now, output);
  constexpr std::uint8_t kFarAway = 64;
  life_ = static_cast<std::uint8_t>(static_cast<std::uint8_t>(frame.life_count) + kFarAway);
  if (stopped_) recounts_ = 1;  // each frame of the stop is new to the board
  return output;
}

// The board has no message that says so, and obeys no command until it restarts.
LinkOutput LcmLink::OnMotorFrame(const std::string& sender, Time now) {
  LinkOutput output;
  const std::string text = sender + " moves the motors directly (" + std::string(kMotorChannel) +
                           "): the board ignores motions and stops; restart the board";
  if (!std::exchange(motors_taken_, true)) output.held_by = text;
  held_ = true;
  Fault("motors", {MotionCode(KeyCode::kTargetBusy), text}, now, output);
  return output;
}

LinkOutput LcmLink::OnMalformed(const std::string& channel, const std::string& what, Time now) {
  LinkOutput output;
  Fault("malformed " + channel,
        {MotionCode(KeyCode::kParametersInvalid),
         "a datagram on LCM channel '" + channel + "' is dropped: " + what},
        now, output);
  return output;
}

LinkOutput LcmLink::OnSendFailed(const Error& error, Time now) {
  LinkOutput output;
  Fault("send", {MotionCode(KeyCode::kNetError), error.message}, now, output);
  return output;
}

void LcmLink::Fault(const std::string& kind, LinkFault fault, Time now, LinkOutput& output) {
  const auto last = reported_.find(kind);
  if (last != reported_.end() && now - last->second < kSameFault) return;
  reported_[kind] = now;
  output.faults.push_back(std::move(fault));
}

void LcmLink::WatchRate(Time now, LinkOutput& output) {
  if (now - second_began_ < std::chrono::seconds(1)) return;
  if (in_second_ > kMostResponses) {
    Fault("flood",
          {MotionCode(MotionKey::kExecuteError),
           "the motion board sends " + std::to_string(in_second_) +
               " responses a second, expected 50; only the newest of each 10 ms is used"},
          now, output);
  }
  in_second_ = 0;
  second_began_ = now;
}

// --- time ---

LinkOutput LcmLink::OnTime(Time now) {
  LinkOutput output;
  if (pending_ && now - *handed_on_ >= kBetweenReports) HandOn(now, output);
  WatchRate(now, output);
  if (held_ && !Held(now)) {
    held_ = false;
    output.held_by = "";
    if (!stopped_) Look(now);
  }
  if (now < tick_at_) return output;
  if (HasHung(now)) Look(std::nullopt);
  tick_at_ = now + Period(now);
  const bool alone = !Held(now) && !Silent(now);
  if (alone && look_end_ && now >= *look_end_) looking_ = false;
  if (frame_) {
    Repeat(now, output);
  } else if (alone && !looking_) {
    Hold(now, output);
  } else if (KeepsBodyUp(now)) {
    output.frames.push_back(Heartbeat());
  }
  return output;
}

void LcmLink::Repeat(Time now, LinkOutput& output) {
  const bool repeats_stop = WaitsForStop() && now - begun_at_ < kRepeatTime;
  if (HasOtherSender(now) && !stopped_ && !repeats_stop) return;
  if (Held(now) && !Stops(*frame_)) {
    output.frames.push_back(Heartbeat());
    return;
  }
  BodyCommand frame = *frame_;
  const bool kept = now - kept_at_ < kNoRepetition;
  const bool lifted = IsStatus(body_.report, SwitchStatus::kLifted);
  if (Walks(frame) && (Silent(now) || !kept || lifted)) {
    // WALK_STAND may not follow a show, whose gait may be that of a user.
    const bool is_walk = std::ranges::find(kModesOfWalks, frame.mode) != kModesOfWalks.end();
    frame.mode = is_walk ? kModeWalk : kModeStand;
    frame.gait = is_walk ? kGaitStand : std::int8_t(0);
    frame.vel = {};
    Begin(frame, now, output, 1);
    own_ = true;
  } else if (unconfirmed_ && !own_ && now - *unconfirmed_ >= options_.give_up && !Stops(frame)) {
    unconfirmed_.reset();
    // A frame that the board has refused stays, for heartbeats. Another one would begin whenever
    // the board can take it, long after the answer that it has failed.
    if (!Silent(now) && IsStatus(body_.report, SwitchStatus::kBanTransition)) {
      output.frames.push_back(Heartbeat());
    } else {
      frame_.reset();
    }
  } else if (recounts_ > 0 || IsRenewed(now)) {
    recounts_ = std::max(recounts_ - 1, 0);
    Renew(now, output, 1);
  } else if (IsKnown(now)) {
    output.frames.push_back(Heartbeat());
  } else {
    output.frames.push_back(frame);
  }
}

// Whether the board has the frame, so that only heartbeats follow: a board that has restarted, or
// whose last frame was another program's, would take the frame for a new command. A stop may be
// taken again.
bool LcmLink::IsKnown(Time now) const {
  if (Stops(*frame_)) return false;
  if (now - begun_at_ >= kRepeatTime) return own_ || !unconfirmed_;
  return !unconfirmed_ && !ambiguous_;
}

// Whether heartbeats keep the body in the motion of the frame after the board was silent.
bool LcmLink::GoesOn(const BodyReport& report, Time now) const {
  if (!frame_ || Stops(*frame_) || Walks(*frame_)) return false;
  return IsKnown(now) || (report.mode == frame_->mode && report.gait == frame_->gait);
}

BodyCommand LcmLink::Heartbeat() const {
  BodyCommand heartbeat;
  heartbeat.mode = kModeNone;
  heartbeat.life_count = frame_ ? frame_->life_count : static_cast<std::int8_t>(life_);
  return heartbeat;
}

// Without a frame, while only stops may be sent because of a second board, which the same board may
// be after a restart. A walk or a dance of an earlier commander must not go on.
bool LcmLink::KeepsBodyUp(Time now) const {
  if (!HasSecondBoard(now) || HasOtherSender(now) || Silent(now)) return false;
  if (!look_end_ || now < *look_end_ || NeedsRecovery(body_.report)) return false;
  const BodyReport& report = body_.report;
  if (report.mode == kModeWalk) return report.gait == kGaitStand;
  return report.mode == kModeDamping || (report.mode == kModeStand && report.gait == 0);
}

Time LcmLink::NextDeadline() const {
  return pending_ ? std::min(tick_at_, *handed_on_ + kBetweenReports) : tick_at_;
}

}  // namespace musher::motion
