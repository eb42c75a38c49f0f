#include "musher/modules/race/perception.hpp"

#include <algorithm>
#include <utility>

namespace musher::race {

bool Perception::Takes(Index detector, Detector::Kind kind, Time taken) {
  if (detector >= open_.size() || !open_[detector]) return false;
  const Detector::Kind expected = course_.detectors[detector].kind;
  const bool is_word = kind == Detector::Kind::kSighting && expected == Detector::Kind::kText;
  if (expected != kind && !is_word) return false;
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
    // A detector of words publishes when it sees one; the others for each picture.
    const bool of_pictures = course_.detectors[i].kind != Detector::Kind::kText;
    const bool is_silent = now - watched.received_at >= course_.check.silent;
    if (watched.wanted && of_pictures && is_silent) silent = i;
  }
  if (changed) outputs_.Watch(open_);
  return silent;
}

void Perception::Close() {
  BeginTick();
  static_cast<void>(EndTick({}));
}

}  // namespace musher::race
