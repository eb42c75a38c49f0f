#pragma once
// The data that the states of the show share, as of the present tick.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "musher/behavior/fsm/archive.hpp"
#include "musher/modules/wedding/data/gaze.hpp"
#include "musher/modules/wedding/data/joints.hpp"
#include "musher/modules/wedding/data/words.hpp"

namespace musher::wedding {

inline constexpr Duration kNever = Duration::max();

// What is known of the people before the robot; updated at the beginning of each tick.
struct PerceptionData {
  bool face_detected = false;   // a face was seen, not too long ago
  Gaze face_position;           // in the picture
  Gaze face_gaze;               // the gaze towards it
  bool face_gaze_known = true;  // false while the head's angles are unknown
  double face_distance_m = 0;
  int face_count = 0;
  int face_id = -1;                   // of the largest frontal one, -1: none
  Duration face_unseen_for = kNever;  // since the last sample
  Duration face_seen_for{};           // from the first to the last sample without a gap

  Gesture gesture = Gesture::kNone;
  double gesture_confidence = 0;
  std::uint64_t gesture_number = 0;  // counts gestures; a held gesture counts once

  bool too_close = false;
  std::uint64_t too_close_number = 0;  // counts guests; one who stays counts once
  bool blind = false;                  // no detector publishes: too_close is not to be trusted
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

// Sounds that have been requested and not been published yet, in order.
class SoundQueue {
 public:
  // A full queue drops the oldest; returns whether there was room.
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
  std::string_view voice_command = "none";  // the last one received
  double voice_level = 0;                   // energy of the microphone's signal, 0 to 1
  SoundQueue pending_speech;
  std::string_view current_speech;  // the last one requested
};

struct ShowData {
  PerceptionData perception;
  MotionData motion;
  AudioData audio;
  double follow = 0.3;  // of GazeRules
  bool safety_triggered = false;
  bool left_alone = false;             // IDLE was commanded: the present guest is not greeted
  int left_alone_face = -1;            // the face_id of that guest, -1: unknown
  std::uint64_t gesture_answered = 0;  // number of the last gesture answered with a photo
  std::uint64_t too_close_warned = 0;  // number of the guest last asked to step back
  bool photo_requested = false;        // the shutter
  std::optional<bool> video_wanted;    // begin or end a recording
  std::optional<Gaze> look_override;   // requested by a person or program; overrides all else

  // All but what is measured again.
  void Persist(fsm::Archive& archive);

  void LeaveAlone() {
    left_alone = perception.face_detected;
    left_alone_face = perception.face_id;
  }
  void Speak(std::string_view sound) {
    audio.current_speech = sound;
    audio.pending_speech.Push(sound);
  }
};

}  // namespace musher::wedding
