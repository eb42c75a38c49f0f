#include "musher/modules/wedding/perception.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace musher::wedding {
namespace {

std::string Text(const Target& target) {
  std::ostringstream text;
  text << "(" << target.point.x << ", " << target.point.y << ", " << target.distance_m << ")";
  return text.str();
}

}  // namespace

Result<> Perception::OnTarget(const Target& target, Time now) {
  if (!IsInUnitRange(target.point.x) || !IsInUnitRange(target.point.y)) {
    return Error{kCodeFailed,
                 "target " + Text(target) + " is not in the picture: x and y are 0 to 1"};
  }
  if (!std::isfinite(target.distance_m) || target.distance_m < 0) {
    return Error{kCodeFailed, "target " + Text(target) + " has no distance: z is metres"};
  }
  target_at_ = now;
  TakeTarget(target, now);
  return Ok();
}

void Perception::TakeTarget(const Target& target, Time now) {
  watched_at_ = now;
  if (!Counts(face_last_, now)) face_first_ = now;
  face_last_ = now;
  target_ = target;
  const std::optional<HeadAngles> head =
      gaze_.camera == Mount::kBody ? HeadAngles{} : HeadAt(target.stamp, now);
  target_gaze_.reset();
  if (head) target_gaze_ = GazeAt(target.point, *head, gaze_);
}

// The head's angles when a picture was taken; without a usable stamp, the present ones. Nothing
// while they are unknown.
std::optional<HeadAngles> Perception::HeadAt(Duration stamp, Time now) const {
  if (!yaw_at_ || now - *yaw_at_ > gaze_.joints_age) return std::nullopt;
  const auto then = [stamp](const AngleTrail& trail, Duration at) {
    const auto known = stamp > Duration(0) ? trail.At(at) : trail.Last();
    return known ? known : trail.Last();
  };
  return HeadAngles{then(yaw_, stamp).value_or(0), then(pitch_, stamp - ahead_).value_or(0)};
}

Result<> Perception::OnGesture(std::string_view word, Time now) {
  const std::optional<Gesture> gesture = GestureOf(Tidy(word));
  if (!gesture) {
    return Error{kCodeFailed, "unknown gesture '" + std::string(word.substr(0, 40)) +
                                  "': none, heart, v or ok are known"};
  }
  // A repeated word is the same gesture, held.
  if (*gesture != gesture_ || !Counts(gesture_at_, now)) ++gesture_number_;
  gesture_ = *gesture;
  gesture_at_ = now;
  return Ok();
}

void Perception::OnFaces(const Faces& faces, Time now) {
  faces_ = faces;
  faces_at_ = now;
  watched_at_ = now;
  if (faces.center && !Counts(target_at_, now)) TakeTarget({*faces.center, 0, faces.stamp}, now);
}

void Perception::OnTooClose(bool too_close, PublisherId publisher, Time now) {
  watched_at_ = now;
  TooCloseWord& word =
      too_close_words_.try_emplace(publisher, TooCloseWord{false, now, now}).first->second;
  word.too_close = too_close;
  word.last = now;
  EvaluateTooClose();
}

void Perception::OnTooClosePublisherLost(PublisherId publisher, Time /*now*/) {
  const auto word = too_close_words_.find(publisher);
  if (word == too_close_words_.end()) return;
  if (word->second.too_close) {
    too_close_left_ = std::max(too_close_left_.value_or(word->second.last), word->second.last);
  }
  too_close_words_.erase(word);
  EvaluateTooClose();
}

void Perception::EvaluateTooClose() {
  const bool before = too_close_;
  const auto is_close = [](const auto& word) { return word.second.too_close; };
  const auto succeeds = [this](const auto& word) {
    return !word.second.too_close && word.second.first > *too_close_left_;
  };
  if (too_close_left_ && std::any_of(too_close_words_.begin(), too_close_words_.end(), succeeds)) {
    too_close_left_.reset();
  }
  too_close_ =
      too_close_left_ || std::any_of(too_close_words_.begin(), too_close_words_.end(), is_close);
  if (too_close_ && !before) ++too_close_number_;
}

Result<> Perception::OnLookAt(Gaze gaze, Time now) {
  if (!IsInUnitRange(gaze.x) || !IsInUnitRange(gaze.y)) {
    return Error{kCodeFailed, "set_look_at " + Text({gaze, 0, {}}) + ": x and y are 0 to 1"};
  }
  look_ = gaze;
  look_at_ = now;
  return Ok();
}

Result<bool> Perception::OnCamera(double width, double height, double focal_length) {
  // Beyond this no pinhole camera can see.
  constexpr double kWidest = 170 * std::numbers::pi / 180;
  const double hfov_rad = 2 * std::atan(width / (2 * focal_length));
  if (!(width >= 1 && height >= 1 && focal_length > 0 && hfov_rad <= kWidest)) {
    return Error{kCodeFailed, "camera_info: no camera has a picture of " + std::to_string(width) +
                                  " x " + std::to_string(height) + " and a focal length of " +
                                  std::to_string(focal_length) + " pixels"};
  }
  const bool news = hfov_rad != gaze_.hfov_rad || height / width != gaze_.height_to_width;
  gaze_.hfov_rad = hfov_rad;
  gaze_.height_to_width = height / width;
  return news;
}

void Perception::OnVoice(double level, Time now) {
  voice_level_ = level;
  voice_at_ = now;
}

void Perception::OnHead(Duration stamp, double yaw_rad, Time now) {
  yaw_.Add(stamp, yaw_rad);
  yaw_at_ = now;
  if (stamp > Duration(0)) ahead_ = stamp - now.time_since_epoch();
}

void Perception::OnGaze(Gaze gaze, Time now) {
  const Duration step = nodded_at_ ? now - *nodded_at_ : Duration(0);
  nodded_at_ = now;
  pitch_rad_ = Nod(pitch_rad_, gaze, gaze_, step);
  pitch_.Add(now.time_since_epoch(), pitch_rad_);
}

void Perception::Refresh(Time now, ShowData& data) {
  PerceptionData& seen = data.perception;
  if (!watched_at_) watched_at_ = now;
  seen.blind = rules_.blind > Duration(0) && now - *watched_at_ > rules_.blind;
  seen.face_detected = Counts(face_last_, now);
  seen.face_position = target_.point;
  seen.face_distance_m = target_.distance_m;
  seen.face_gaze_known = target_gaze_.has_value();
  if (target_gaze_) seen.face_gaze = *target_gaze_;
  seen.face_unseen_for = face_last_ ? now - *face_last_ : kNever;
  seen.face_seen_for = face_last_ ? *face_last_ - *face_first_ : Duration(0);
  const bool faces = Counts(faces_at_, now);
  seen.face_count = faces ? faces_.count : seen.face_detected ? 1 : 0;
  seen.face_id = faces ? faces_.largest_frontal : -1;
  const bool gesture = Counts(gesture_at_, now) && gesture_ != Gesture::kNone;
  seen.gesture = gesture ? gesture_ : Gesture::kNone;
  seen.gesture_confidence = gesture ? rules_.gesture_confidence : 0;
  seen.too_close = too_close_;
  seen.too_close_number = too_close_number_;
  seen.gesture_number = gesture_number_;
  data.look_override.reset();
  if (Counts(look_at_, now)) data.look_override = look_;
  data.audio.voice_level = Counts(voice_at_, now) ? voice_level_ : 0;
}

void Perception::Forget() {
  // Times before the jump are not compared with those after it.
  for (auto& [publisher, word] : too_close_words_) word.first = word.last = Time::min();
  if (too_close_left_) too_close_left_ = Time::min();
  target_at_.reset();
  look_at_.reset();
  face_first_.reset();
  face_last_.reset();
  faces_at_.reset();
  watched_at_.reset();
  gesture_at_.reset();
  voice_at_.reset();
  yaw_at_.reset();
  yaw_.Clear();
  nodded_at_.reset();
  pitch_.Clear();
}

}  // namespace musher::wedding
