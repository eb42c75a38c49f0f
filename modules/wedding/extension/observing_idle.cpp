#include "musher/modules/wedding/extension/observing_idle.hpp"

#include <chrono>
#include <cmath>

namespace musher::wedding {
namespace {

Action ActionOf(ObservingIdle::Phase phase) {
  switch (phase) {
    case ObservingIdle::Phase::kGreeting:
      return Action::kGreeting;
    case ObservingIdle::Phase::kObserve:
      return Action::kIdleObserve;
    default:
      return Action::kIdleNormal;
  }
}

}  // namespace

void ObservingIdle::OnEnter(const fsm::Tick& tick) {
  SearchingIdle::OnEnter(tick);
  Begin(Phase::kActive, {});
}

void ObservingIdle::Run(const fsm::Tick& tick) {
  SearchingIdle::Run(tick);
  if (tick.elapsed >= phase_ends_) Begin(PhaseAfter(), tick.elapsed);
  player_.Start(ActionOf(phase_), data());  // also after a pause
}

ObservingIdle::Phase ObservingIdle::PhaseAfter() {
  if (phase_ != Phase::kObserve) return Phase::kObserve;
  const double share = std::uniform_real_distribution<double>(0, 1)(random_);
  return share < rules_.greeting_probability ? Phase::kGreeting : Phase::kActive;
}

void ObservingIdle::Begin(Phase phase, Duration elapsed) {
  phase_ = phase;
  candidate_ = false;
  phase_ends_ = elapsed + LengthOf(phase);
  player_.Start(ActionOf(phase), data());
}

Duration ObservingIdle::LengthOf(Phase phase) {
  switch (phase) {
    case Phase::kGreeting:
      return rules_.greeting;
    case Phase::kObserve:
      return DrawBetween(rules_.observe_least, rules_.observe_most);
    default:
      return DrawBetween(rules_.idle_least, rules_.idle_most);
  }
}

bool ObservingIdle::SeesGuest(const fsm::Tick& tick) {
  return phase_ == Phase::kObserve && IsConfirmed(tick);
}

bool ObservingIdle::IsConfirmed(const fsm::Tick& tick) {
  const PerceptionData& seen = data().perception;
  if (!seen.face_detected || seen.face_unseen_for > rules_.lost) {
    candidate_ = false;
    return false;
  }
  const bool numbered = seen.face_id >= 0 && face_id_ >= 0;
  const double moved =
      std::hypot(seen.face_position.x - position_.x, seen.face_position.y - position_.y);
  const bool same = numbered ? seen.face_id == face_id_ : moved <= rules_.same_within;
  const Duration last_seen = tick.elapsed - seen.face_unseen_for;
  if (!candidate_ || !same) first_seen_ = last_seen;
  candidate_ = true;
  face_id_ = seen.face_id;
  position_ = seen.face_position;
  return last_seen - first_seen_ >= rules_.confirm;
}

Duration ObservingIdle::DrawBetween(Duration least, Duration most) {
  const double share = std::uniform_real_distribution<double>(0, 1)(random_);
  return least + std::chrono::duration_cast<Duration>((most - least) * share);
}

void ObservingIdle::Persist(fsm::Archive& archive) {
  archive.Field("phase", phase_);
  archive.Field("phase_ends", phase_ends_);
}

}  // namespace musher::wedding
