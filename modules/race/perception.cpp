#include "musher/modules/race/perception.hpp"

#include <algorithm>
#include <utility>

namespace musher::race {

bool Perception::Takes(Index detector, Detector::Kind kind, Time taken) {
  if (detector >= open_.size() || !open_[detector]) return false;
  if (course_.detectors[detector].kind != kind) return false;
  Watched& watched = watched_[detector];
  watched.received = true;
  watched.taken = taken;
  return true;
}

void Perception::OnSighting(Index detector, Sighting sighting, Time taken) {
  if (!Takes(detector, Detector::Kind::kSighting, taken)) return;
  watched_[detector].sighting = std::move(sighting);
}

void Perception::OnLines(Index detector, const Lines& lines, Time taken) {
  if (Takes(detector, Detector::Kind::kLines, taken)) watched_[detector].lines = lines;
}

void Perception::BeginTick() {
  for (Watched& watched : watched_) watched.wanted = false;
}

const Sighting* Perception::SightingSince(Index detector, Time after) const {
  const Watched& watched = watched_[detector];
  return watched.taken && *watched.taken >= after ? &watched.sighting : nullptr;
}

const Lines* Perception::LinesSince(Index detector, Time after) const {
  const Watched& watched = watched_[detector];
  return watched.taken && *watched.taken >= after ? &watched.lines : nullptr;
}

std::optional<Index> Perception::EndTick(Duration now) {
  bool changed = false;
  std::optional<Index> silent;
  const Duration passed =
      std::clamp(now - std::exchange(ticked_at_, now), Duration(0), kTickCounts);
  for (Index i = 0; i < watched_.size(); ++i) {
    Watched& watched = watched_[i];
    watched.silent += passed;
    if (watched.wanted != open_[i]) {
      changed = true;
      watched.silent = Duration(0);
      open_[i] = watched.wanted;
      watched.taken.reset();
      watched.received_at = now;
    }
    if (std::exchange(watched.received, false)) {
      watched.received_at = now;
      watched.silent = Duration(0);
    }
    if (watched.wanted && now - watched.received_at >= course_.check.silent) silent = i;
  }
  if (changed) outputs_.Watch(open_);
  return silent;
}

void Perception::Close() {
  BeginTick();
  static_cast<void>(EndTick({}));
}

}  // namespace musher::race
