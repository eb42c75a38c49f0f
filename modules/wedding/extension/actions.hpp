#pragma once
// Action packs of the robot's second generation: what body and voice do together while a state
// lasts, as a pose, a motion and a rule by which sounds are selected at random.
//
// The random generator is seeded, so that a recording replays exactly.

#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "musher/modules/wedding/data/show_data.hpp"

namespace musher::wedding {

namespace pose {
inline constexpr std::string_view kWaveStart = "wave_start";
}  // namespace pose
namespace motion {
inline constexpr std::string_view kSway = "sway_normal";
inline constexpr std::string_view kWave = "wave_greet";
inline constexpr std::string_view kScan = "scan_search";
inline constexpr std::string_view kTrack = "track_face";
inline constexpr std::string_view kStop = "stop";
}  // namespace motion

enum class Action {
  kReset,
  kIdleNormal,
  kIdleObserve,
  kGreeting,
  kSearchScan,
  kTrackingActive,
  kInterviewHold,
};
std::string_view Name(Action action);

// When a pack plays a sound. Times count from the start of its action.
struct Speech {
  Duration first{};        // zero: it never speaks
  Duration again_least{};  // to the next one; zero: it speaks once
  Duration again_most{};
  double probability = 1;  // of each time
};

struct ActionPack {
  std::string_view pose;
  std::string_view motion;  // kStop: none
  std::span<const std::string_view> sounds;
  Speech speech;
};
const ActionPack& PackOf(Action action);

// The action that a state begins with; nothing for a state that moves by itself.
std::optional<Action> ActionOnEntering(std::string_view state, const ShowData& data);

// Returns each of `sounds` once before one is repeated, and none twice in a row.
class ShuffledBag {
 public:
  std::string_view Draw(std::span<const std::string_view> sounds, std::mt19937_64& random);

 private:
  std::vector<std::string_view> left_;
  const std::string_view* from_ = nullptr;
  std::string_view last_;
};

// Plays one action at a time.
class ActionPlayer {
 public:
  explicit ActionPlayer(std::uint64_t seed) : random_(seed) {}

  // Sets the pose and the motion. The same action again changes nothing.
  void Start(Action action, ShowData& data);
  // Each tick, `step` after the last one: plays what is due.
  void Tick(Duration step, ShowData& data);
  // Ends the action: no sound, no motion.
  void Stop(ShowData& data);
  std::optional<Action> action() const { return action_; }

 private:
  Duration DrawBetween(Duration least, Duration most);

  std::mt19937_64 random_;
  std::optional<Action> action_;
  Duration elapsed_{};
  std::optional<Duration> next_sound_;
  ShuffledBag bag_;
};

}  // namespace musher::wedding
