#include "musher/modules/vision/faces/closeness.hpp"

#include <algorithm>
#include <utility>

namespace musher::vision {

bool Closeness::OnPicture(std::int64_t stamp_ns, const std::vector<Sighting>& seen) {
  const Duration gap(stamp_ns - std::exchange(last_ns_, stamp_ns).value_or(stamp_ns));
  const Duration passed = std::min(gap, rules_.longest_gap);
  watched_ += passed;
  known_ = known_ || !seen.empty() || watched_ >= rules_.hold;
  for (auto& [id, unseen] : near_) unseen += passed;
  for (const Sighting& sighting : seen) {
    const auto known = near_.find(sighting.id);
    const double limit_m = known == near_.end() ? rules_.near_m : rules_.clear_m;
    if (sighting.distance_m < limit_m) {
      near_[sighting.id] = Duration::zero();
    } else if (known != near_.end()) {
      near_.erase(known);
    }
  }
  std::erase_if(near_, [this](const auto& entry) { return entry.second > rules_.hold; });
  return too_close();
}

std::set<int> Closeness::TooNear() const {
  std::set<int> ids;
  for (const auto& [id, unseen] : near_) ids.insert(id);
  return ids;
}

}  // namespace musher::vision
