#include "musher/navigation/travelled_path.hpp"

#include <cmath>

namespace musher::navigation {
namespace {

constexpr double kPlacesApartM = 0.05;
constexpr double kBesidePathM = 0.1;
constexpr std::size_t kMostPlaces =
    static_cast<std::size_t>(TravelledPath::kLongestM / kPlacesApartM);

double ApartOnGround(const Pose& a, const Pose& b) {
  return std::hypot(a.at.x_m - b.at.x_m, a.at.y_m - b.at.y_m);
}

// Whether a body that has come from `earlier` to `later` has gone back behind `later` since.
bool IsBehind(const Pose& body, const Pose& later, const Pose& earlier) {
  const double length_m = ApartOnGround(later, earlier);
  const double c = (later.at.x_m - earlier.at.x_m) / length_m;
  const double s = (later.at.y_m - earlier.at.y_m) / length_m;
  const double x_m = body.at.x_m - later.at.x_m, y_m = body.at.y_m - later.at.y_m;
  return c * x_m + s * y_m < 0 && std::abs(c * y_m - s * x_m) < kBesidePathM;
}

}  // namespace

void TravelledPath::Add(const Pose& pose) {
  if (!IsFinite(pose)) return;
  if (!poses_.empty() && ApartOnGround(pose, last_) > kJumpM) poses_.clear();
  last_ = pose;
  while (poses_.size() > 1 && IsBehind(pose, poses_.back(), poses_[poses_.size() - 2])) {
    poses_.pop_back();
  }
  if (!poses_.empty() && ApartOnGround(pose, poses_.back()) < kPlacesApartM) return;
  poses_.push_back(pose);
  if (poses_.size() > kMostPlaces) poses_.pop_front();
}

}  // namespace musher::navigation
