#include "musher/modules/race/perception.hpp"

#include <algorithm>
#include <utility>

namespace musher::race {
namespace {

// Nearer in time are two samples of one picture: the time of a stamp is computed by two clocks that
// are read one after the other.
constexpr Duration kSamePicture = Milliseconds(1);

}  // namespace

bool Perception::Takes(Index detector, Detector::Kind kind, Time taken, Time time) {
  if (detector >= open_.size() || !open_[detector]) return false;
  const Detector::Kind expected = course_.detectors[detector].kind;
  const bool is_word = kind == Detector::Kind::kSighting && expected == Detector::Kind::kText;
  if (expected != kind && !is_word) return false;
  Watched& watched = watched_[detector];
  const bool again = watched.stamped && taken - *watched.stamped < kSamePicture &&
                     *watched.stamped - taken < kSamePicture;
  watched.stamped = taken;
  if (again) return true;
  watched.received = true;
  watched.doubt.clear();
  ++watched.pictures;
  watched.taken = std::min(taken, time);
  return true;
}

void Perception::OnSighting(Index detector, Sighting sighting, Time taken, Time time) {
  if (!Takes(detector, Detector::Kind::kSighting, taken, time)) return;
  watched_[detector].sighting = std::move(sighting);
}

void Perception::OnLines(Index detector, const Lines& lines, Time taken, Time time) {
  if (Takes(detector, Detector::Kind::kLines, taken, time)) watched_[detector].lines = lines;
}

void Perception::OnDoubt(Index detector, std::string why) {
  if (detector < open_.size() && open_[detector]) watched_[detector].doubt = std::move(why);
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

std::optional<Index> Perception::EndTick(Duration now, Time time) {
  bool changed = false;
  std::optional<Index> silent;
  for (Index i = 0; i < watched_.size(); ++i) {
    Watched& watched = watched_[i];
    if (watched.wanted != open_[i]) {
      changed = true;
      open_[i] = watched.wanted;
      watched.stamped.reset();
      watched.taken.reset();
      watched.doubt.clear();
      watched.received_at = now;
    }
    const bool is_old = watched.taken && time - *watched.taken >= course_.check.silent;
    if (std::exchange(watched.received, false) && !is_old) watched.received_at = now;
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
  static_cast<void>(EndTick({}, {}));
}

}  // namespace musher::race
