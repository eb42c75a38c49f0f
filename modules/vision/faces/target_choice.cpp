#include "musher/modules/vision/faces/target_choice.hpp"

#include <algorithm>

namespace musher::vision {

std::optional<int> TargetChoice::OnPicture(std::int64_t stamp_ns,
                                           const std::vector<Candidate>& frontal) {
  const auto kept = std::find_if(frontal.begin(), frontal.end(),
                                 [this](const Candidate& one) { return one.id == target_; });
  const auto nearest =
      std::max_element(frontal.begin(), frontal.end(),
                       [](const Candidate& a, const Candidate& b) { return a.height < b.height; });
  if (kept != frontal.end()) {
    seen_ns_ = stamp_ns;
    // A size of 1 / (1 - nearer) is nearer by that share.
    if (nearest->height * (1 - rules_.nearer) > kept->height) target_ = nearest->id;
    return target_;
  }
  if (target_ && Duration(stamp_ns - seen_ns_) <= rules_.lost) return std::nullopt;
  target_.reset();
  if (nearest == frontal.end()) return std::nullopt;
  seen_ns_ = stamp_ns;
  target_ = nearest->id;
  return target_;
}

}  // namespace musher::vision
