#include "musher/modules/wedding/extension/actions.hpp"

#include <algorithm>
#include <array>

#include "musher/modules/wedding/extension/interview.hpp"
#include "musher/modules/wedding/extension/search.hpp"

namespace musher::wedding {
namespace {

constexpr std::array<std::string_view, 2> kIdleSounds = {"idle_random_1", "idle_greeting"};
constexpr std::array<std::string_view, 4> kGreetings = {"greeting_hello", "greeting_nice",
                                                        "greeting_bride", "greeting_groom"};
constexpr std::array<std::string_view, 1> kHello = {"greeting_hello"};

// The action packs of the robot's own software.
const std::array<ActionPack, 7> kPacks = {{
    {pose::kNeutral, motion::kStop, {}, {}},
    {pose::kNeutral,
     motion::kSway,
     kIdleSounds,
     {Milliseconds(1000), Milliseconds(10'000), Milliseconds(20'000), 0.6}},
    {pose::kNeutral, motion::kStop, {}, {}},
    {pose::kWaveStart, motion::kWave, kGreetings, {Milliseconds(500), {}, {}, 1}},
    {pose::kNeutral, motion::kScan, {}, {}},
    {pose::kNeutral,
     motion::kTrack,
     kHello,
     {Milliseconds(2000), Milliseconds(15'000), Milliseconds(25'000), 1}},
    {pose::kMicHold, motion::kTrack, {}, {}},
}};

constexpr std::array<std::string_view, 7> kNames = {
    "reset",       "idle_normal",     "idle_observe",  "greeting",
    "search_scan", "tracking_active", "interview_hold"};

double Share(std::mt19937_64& random) {
  return std::uniform_real_distribution<double>(0, 1)(random);
}

}  // namespace

std::string_view Name(Action action) {
  return kNames.at(static_cast<std::size_t>(action));
}

const ActionPack& PackOf(Action action) {
  return kPacks.at(static_cast<std::size_t>(action));
}

std::optional<Action> ActionOnEntering(std::string_view state, const ShowData& data) {
  if (state == state::kSearch) {
    return data.perception.face_detected ? Action::kTrackingActive : Action::kSearchScan;
  }
  if (state == state::kTracking) return Action::kTrackingActive;
  if (state == state::kInterview) return Action::kInterviewHold;
  if (state == state::kIdle) return Action::kIdleNormal;
  if (state == state::kSafeStop) return Action::kReset;
  return std::nullopt;
}

std::string_view ShuffledBag::Draw(std::span<const std::string_view> sounds,
                                   std::mt19937_64& random) {
  if (from_ != sounds.data()) left_.clear();
  from_ = sounds.data();
  if (left_.empty()) {
    left_.assign(sounds.begin(), sounds.end());
    std::shuffle(left_.begin(), left_.end(), random);
    if (left_.size() > 1 && left_.back() == last_) std::swap(left_.front(), left_.back());
  }
  last_ = left_.back();
  left_.pop_back();
  return last_;
}

void ActionPlayer::Start(Action action, ShowData& data) {
  if (action_ == action) return;
  action_ = action;
  elapsed_ = {};
  const ActionPack& pack = PackOf(action);
  data.motion.target_pose = pack.pose;
  data.motion.target_motion = pack.motion;
  next_sound_.reset();
  if (pack.speech.first > Duration(0)) next_sound_ = pack.speech.first;
}

void ActionPlayer::Tick(Duration step, ShowData& data) {
  if (!action_) return;
  elapsed_ += step;
  const ActionPack& pack = PackOf(*action_);
  if (!next_sound_ || elapsed_ < *next_sound_) return;
  if (Share(random_) < pack.speech.probability) data.Speak(bag_.Draw(pack.sounds, random_));
  next_sound_.reset();
  if (pack.speech.again_most > Duration(0)) {
    next_sound_ = elapsed_ + DrawBetween(pack.speech.again_least, pack.speech.again_most);
  }
}

void ActionPlayer::Stop(ShowData& data) {
  action_.reset();
  next_sound_.reset();
  data.motion.target_motion = motion::kStop;
}

Duration ActionPlayer::DrawBetween(Duration least, Duration most) {
  return least + std::chrono::duration_cast<Duration>((most - least) * Share(random_));
}

}  // namespace musher::wedding
