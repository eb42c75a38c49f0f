#include "musher/modules/wedding/perception.hpp"

#include <cmath>
#include <sstream>

namespace musher::wedding {
namespace {

bool IsShare(double value) {
  return value >= 0 && value <= 1;  // false of NaN
}

std::string Text(const Target& target) {
  std::ostringstream text;
  text << "(" << target.point.x << ", " << target.point.y << ", " << target.distance_m << ")";
  return text.str();
}

}  // namespace

Result<> Perception::OnTarget(const Target& target, Time now) {
  if (!IsShare(target.point.x) || !IsShare(target.point.y)) {
    return Error{kCodeFailed,
                 "target " + Text(target) + " is not in the picture: x and y are 0 to 1"};
  }
  if (!std::isfinite(target.distance_m) || target.distance_m < 0) {
    return Error{kCodeFailed, "target " + Text(target) + " has no distance: z is metres"};
  }
  if (!Counts(face_last_, now)) face_first_ = now;
  face_last_ = now;
  target_ = target;
  std::optional<double> yaw_rad = 0;
  if (gaze_.camera == Mount::kHead) {
    yaw_rad.reset();
    if (head_at_ && now - *head_at_ <= gaze_.joints_age) {
      yaw_rad = target.stamp > Duration(0) ? head_.At(target.stamp) : head_.Last();
      if (!yaw_rad) yaw_rad = head_.Last();
    }
  }
  target_gaze_.reset();
  if (yaw_rad) target_gaze_ = GazeAt(target.point, *yaw_rad, gaze_);
  return Ok();
}

Result<> Perception::OnGesture(std::string_view word, Time now) {
  const std::optional<Gesture> gesture = GestureOf(Tidy(word));
  if (!gesture) {
    return Error{kCodeFailed, "unknown gesture '" + std::string(word.substr(0, 40)) +
                                  "': none, heart, v or ok are known"};
  }
  // The same again is the same gesture, held.
  if (*gesture != gesture_ || !Counts(gesture_at_, now)) gesture_used_ = false;
  gesture_ = *gesture;
  gesture_at_ = now;
  return Ok();
}

void Perception::OnFaces(const Faces& faces, Time now) {
  faces_ = faces;
  faces_at_ = now;
}

void Perception::OnVoice(double level, Time now) {
  voice_level_ = level;
  voice_at_ = now;
}

void Perception::OnTooClose(bool too_close, Time now) {
  too_close_ = too_close;
  too_close_at_ = now;
}

void Perception::OnHead(Duration stamp, double yaw_rad, Time now) {
  head_.Add(stamp, yaw_rad);
  head_at_ = now;
}

void Perception::Refresh(Time now, ShowData& data) const {
  PerceptionData& seen = data.perception;
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
  seen.too_close = Counts(too_close_at_, now) && too_close_;
  data.gesture_used = gesture_used_;
  data.audio.voice_level = Counts(voice_at_, now) ? voice_level_ : 0;
}

void Perception::Forget() {
  face_first_.reset();
  face_last_.reset();
  faces_at_.reset();
  gesture_at_.reset();
  gesture_used_ = false;
  too_close_at_.reset();
  voice_at_.reset();
  head_at_.reset();
  head_.Clear();
}

}  // namespace musher::wedding
