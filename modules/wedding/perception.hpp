#pragma once
// What the robot was told of those before it, and for how long it counts. Samples come when they
// come; the states are shown, tick by tick, what holds now.
//
// A sample counts for `age`, by the time and not by the tick: a detector may be slower than the
// loop, and a person who publishes by hand once a second is understood.

#include <cstdint>
#include <map>
#include <optional>
#include <string_view>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/modules/wedding/faces.hpp"
#include "musher/modules/wedding/gaze.hpp"
#include "musher/modules/wedding/show_data.hpp"

namespace musher::wedding {

struct PerceptionRules {
  Duration age = Milliseconds(1500);
  double gesture_confidence = 0.8;  // of each gesture that is told: the topic has no number
  Duration blind{};                 // nothing heard of target, too_close, faces for longer; 0: off

  friend bool operator==(const PerceptionRules&, const PerceptionRules&) = default;
};

// Of one writer of a topic.
using PublisherId = std::uint64_t;

struct Target {
  Gaze point;             // of the picture, 0 to 1
  double distance_m = 0;  // 0: unknown
  Duration stamp{};       // of the shot; zero: none
};

class Perception {
 public:
  Perception(const PerceptionRules& rules, const GazeRules& gaze) : rules_(rules), gaze_(gaze) {}

  // Each refuses what cannot be, and then has changed nothing.
  Result<> OnTarget(const Target& target, Time now);
  // `word` as on the topic, in any case.
  Result<> OnGesture(std::string_view word, Time now);
  // Is a target, too, where no target has been heard for `age`.
  void OnFaces(const Faces& faces, Time now);
  void OnVoice(double level, Time now);
  // A "too close" holds until the same publisher says the opposite, however long that takes: a
  // guest of whom nothing is heard may still be there, and another camera does not see what this
  // one saw.
  void OnTooClose(bool too_close, PublisherId publisher, Time now);
  // The publisher has gone. What it said holds until a publisher that came after its last word says
  // that no guest is too close: its successor.
  void OnTooClosePublisherLost(PublisherId publisher, Time now);
  bool too_close() const { return too_close_; }
  // Where the robot has to look, for `age`.
  Result<> OnLookAt(Gaze gaze, Time now);
  // The camera's own opening in the place of the configured one. Says whether that is news; refuses
  // what no camera has.
  Result<bool> OnCamera(double width, double height, double focal_length);
  // How the head stood when the joints were measured.
  void OnHead(Duration stamp, double yaw_rad, Time now);

  // Where the robot looks from now on, each tick.
  void OnGaze(Gaze gaze, Time now);

  // What holds at `now`. Of a robot that has heard nothing yet, blindness counts from the first.
  void Refresh(Time now, ShowData& data);
  // Time went back, or the robot rested: nothing counts any more, but that somebody is too close.
  void Forget();

 private:
  struct TooCloseWord {
    bool too_close = false;
    Time first{};  // that anything was heard of this publisher
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
  std::optional<Time> target_at_;  // when the topic `target` was last heard
  std::optional<Time> look_at_;    // when it was asked for
  Gaze look_;
  std::optional<Time> faces_at_;
  Faces faces_;
  std::optional<Time> gesture_at_;
  Gesture gesture_ = Gesture::kNone;
  std::uint64_t gesture_number_ = 0;
  std::map<PublisherId, TooCloseWord> too_close_words_;  // of the publishers that are there
  std::optional<Time> too_close_left_;  // the last word of one that has gone and was not answered
  bool too_close_ = false;
  std::uint64_t too_close_number_ = 0;
  std::optional<Time> watched_at_;  // when one of the three was last heard
  std::optional<Time> voice_at_;
  double voice_level_ = 0;
  AngleTrail yaw_;
  std::optional<Time> yaw_at_;  // when it was last measured
  Duration ahead_{};            // of the clock that stamps, to the machine's
  AngleTrail pitch_;
  double pitch_rad_ = 0;
  std::optional<Time> nodded_at_;
};

}  // namespace musher::wedding
