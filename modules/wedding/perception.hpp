#pragma once
// What the robot has received about the people before it, and for how long it is valid. Samples
// arrive at any time; the states read, tick by tick, what is valid now.
//
// A sample is valid for `age`, by time and not by tick: a detector may be slower than the loop,
// and a person may publish from the command line once a second.

#include <cstdint>
#include <map>
#include <optional>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/base/strong_number.hpp"
#include "musher/base/time.hpp"
#include "musher/modules/wedding/data/gaze.hpp"
#include "musher/modules/wedding/data/show_data.hpp"
#include "musher/modules/wedding/faces.hpp"

namespace musher::wedding {

struct PerceptionRules {
  Duration age = Milliseconds(1500);
  double gesture_confidence = 0.8;  // of each received gesture: the topic has no number
  Duration blind{};                 // timeout of target, too_close and faces; 0: off

  friend bool operator==(const PerceptionRules&, const PerceptionRules&) = default;
};

// Identifies one publisher of a topic.
using PublisherId = StrongNumber<struct PublisherKind>;

struct Target {
  Gaze point;             // of the picture, 0 to 1
  double distance_m = 0;  // 0: unknown
  Duration stamp{};       // of the picture; zero: none
};

class Perception {
 public:
  Perception(const PerceptionRules& rules, const GazeRules& gaze) : rules_(rules), gaze_(gaze) {}

  // Each refuses invalid input, and then has changed nothing.
  Result<> OnTarget(const Target& target, Time now);
  // `word` as on the topic, in any case.
  Result<> OnGesture(std::string_view word, Time now);
  // Counts as a target, too, when no target was received for `age`.
  void OnFaces(const Faces& faces, Time now);
  void OnVoice(double level, Time now);
  // A "too close" holds until the same publisher withdraws it, however long that takes: a guest of
  // whom no message arrives may still be there, and another camera does not see what this one saw.
  void OnTooClose(bool too_close, PublisherId publisher, Time now);
  // The publisher is lost. Its last word holds until a publisher that appeared after that word
  // says that no guest is too close: its successor.
  void OnTooClosePublisherLost(PublisherId publisher, Time now);
  bool too_close() const { return too_close_; }
  // A requested gaze, valid for `age`.
  Result<> OnLookAt(Gaze gaze, Time now);
  // The camera's own field of view, instead of the configured one. Returns whether it changed;
  // refuses values that no camera has.
  Result<bool> OnCamera(double width, double height, double focal_length);
  // The head's angle when the joints were measured.
  void OnHead(Duration stamp, double yaw_rad, Time now);

  // The robot's gaze from now on, each tick.
  void OnGaze(Gaze gaze, Time now);

  // What is valid at `now`. Before the first message, blindness counts from the first call.
  void Refresh(Time now, ShowData& data);
  // Time went back, or the robot was paused: all samples are dropped, except that a guest is too
  // close.
  void Forget();

 private:
  struct TooCloseWord {
    bool too_close = false;
    Time first{};  // first message of this publisher
    Time last{};
  };

  void TakeTarget(const Target& target, Time now);
  void EvaluateTooClose();
  std::optional<HeadAngles> HeadAt(Duration stamp, Time now) const;
  bool Counts(const std::optional<Time>& at, Time now) const {
    return at && now - *at <= rules_.age;
  }

  const PerceptionRules rules_;
  GazeRules gaze_;

  std::optional<Time> face_first_;
  std::optional<Time> face_last_;
  Target target_;
  std::optional<Gaze> target_gaze_;
  std::optional<Time> target_at_;  // when the topic `target` was last received
  std::optional<Time> look_at_;    // when it was requested
  Gaze look_;
  std::optional<Time> faces_at_;
  Faces faces_;
  std::optional<Time> gesture_at_;
  Gesture gesture_ = Gesture::kNone;
  std::uint64_t gesture_number_ = 0;
  std::map<PublisherId, TooCloseWord> too_close_words_;  // of the publishers that are alive
  std::optional<Time> too_close_left_;  // the last word of a lost publisher without a successor
  bool too_close_ = false;
  std::uint64_t too_close_number_ = 0;
  std::optional<Time> watched_at_;  // when one of the three was last received
  std::optional<Time> voice_at_;
  double voice_level_ = 0;
  AngleTrail yaw_;
  std::optional<Time> yaw_at_;  // when it was last measured
  Duration ahead_{};            // offset of the stamping clock to the machine's
  AngleTrail pitch_;
  double pitch_rad_ = 0;
  std::optional<Time> nodded_at_;
};

}  // namespace musher::wedding
