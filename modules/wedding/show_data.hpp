#pragma once
// What the states of the show share: the seed's data, as of the present tick.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "musher/behavior/fsm/archive.hpp"
#include "musher/modules/wedding/gaze.hpp"
#include "musher/modules/wedding/joints.hpp"
#include "musher/modules/wedding/words.hpp"

namespace musher::wedding {

inline constexpr Duration kNever = Duration::max();

// What is known of those before the robot; brought up to date at the beginning of each tick.
struct PerceptionData {
  bool face_detected = false;   // a face was seen, not too long ago
  Gaze face_position;           // in the picture
  Gaze face_gaze;               // where the robot looks to look at it
  bool face_gaze_known = true;  // false while nobody says how the head stood
  double face_distance_m = 0;
  int face_count = 0;
  int face_id = -1;                   // of the largest frontal one, -1: none
  Duration face_unseen_for = kNever;  // since the last sample
  Duration face_seen_for{};           // from the first to the last sample without a gap

  Gesture gesture = Gesture::kNone;
  double gesture_confidence = 0;
  std::uint64_t gesture_number = 0;  // of which; one that is held is one

  bool too_close = false;
  std::uint64_t too_close_number = 0;  // of whom: one who stays is one
  bool blind = false;                  // nobody watches: too_close is not to be trusted
};

struct MotionData {
  JointAngles joint_positions{};  // rad, as measured
  JointAngles joint_commands{};   // rad, as its motion adapter commands them
  std::string current_pose;       // as published; empty: none yet
  std::string target_pose{pose::kNeutral};
  std::string current_motion;  // as published; empty: none yet
  std::string target_motion;   // of an action pack; empty where the show has none
  Gaze look_at_target;
};

// Sounds that have been asked for and not been published yet, in their order.
class SoundQueue {
 public:
  // The oldest gives way where there are too many; says whether none had to.
  bool Push(std::string_view sound) {
    const bool room = size_ < ring_.size();
    if (!room) static_cast<void>(Pop());
    ring_[(first_ + size_++) % ring_.size()] = sound;
    return room;
  }
  std::optional<std::string_view> Pop() {
    if (size_ == 0) return std::nullopt;
    const std::string_view sound = ring_[first_];
    first_ = (first_ + 1) % ring_.size();
    --size_;
    return sound;
  }
  std::size_t size() const { return size_; }
  void Clear() { size_ = 0; }

 private:
  std::array<std::string_view, 16> ring_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

struct AudioData {
  std::string_view voice_command = "none";  // the last one that was heard
  double voice_level = 0;                   // energy of what is heard, 0 to 1
  SoundQueue pending_speech;
  std::string_view current_speech;  // the last one that was asked for
};

struct ShowData {
  PerceptionData perception;
  MotionData motion;
  AudioData audio;
  double follow = 0.3;  // of GazeRules
  bool safety_triggered = false;
  bool left_alone = false;             // IDLE was commanded: who stands there is not greeted
  int left_alone_face = -1;            // the face_id of whom, -1: unknown
  std::uint64_t gesture_answered = 0;  // the number of the last one that was held at a photo
  std::uint64_t too_close_asked = 0;   // the number of whom was last asked to step back
  bool photo_requested = false;        // the shutter
  std::optional<bool> video_wanted;    // to begin and to end a recording
  std::optional<Gaze>
      look_override;  // that a person or program asked for, in the place of all else

  // What is not seen, heard or measured anew.
  void Persist(fsm::Archive& archive);

  void LeaveAlone() {
    left_alone = perception.face_detected;
    left_alone_face = perception.face_id;
  }
  void Say(std::string_view sound) {
    audio.current_speech = sound;
    audio.pending_speech.Push(sound);
  }
};

}  // namespace musher::wedding
