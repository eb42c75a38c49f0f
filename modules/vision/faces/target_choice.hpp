#pragma once
// Which person the robot looks at: the nearest one who looks at it, kept until lost or until
// another is clearly nearer. Pure: time is the pictures' own.

#include <cstdint>
#include <optional>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::vision {

struct TargetRules {
  Duration lost = Milliseconds(1000);  // not seen from the front: another may be chosen
  double nearer = 0.25;                // another has to be nearer by this share

  friend bool operator==(const TargetRules&, const TargetRules&) = default;
};

class TargetChoice {
 public:
  explicit TargetChoice(const TargetRules& rules) : rules_(rules) {}

  struct Candidate {
    int id = 0;
    double height = 0;  // of the face in the picture: the larger, the nearer
  };
  // The persons seen from the front in a picture. Returns the chosen one; nothing while it is not
  // among them.
  std::optional<int> OnPicture(std::int64_t stamp_ns, const std::vector<Candidate>& frontal);

 private:
  TargetRules rules_;
  std::optional<int> target_;
  std::int64_t seen_ns_ = 0;
};

}  // namespace musher::vision
