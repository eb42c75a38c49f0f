#pragma once
// Which incidents met the robot in which phase, so that one that never happens is seen.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "musher/simulation/incident.hpp"
#include "musher/simulation/moment.hpp"

namespace musher::simulation {

class Coverage {
 public:
  void Count(IncidentKind kind, Moment moment) {
    ++counts_[static_cast<std::size_t>(kind)][static_cast<std::size_t>(moment)];
  }
  void Add(const Coverage& other);
  std::uint64_t Of(IncidentKind kind, Moment moment) const {
    return counts_[static_cast<std::size_t>(kind)][static_cast<std::size_t>(moment)];
  }
  std::uint64_t Of(IncidentKind kind) const;
  // A table for people: a row for each kind, a column for each moment.
  std::string Text() const;

 private:
  std::array<std::array<std::uint64_t, kMoments>, kIncidentKinds> counts_{};
};

}  // namespace musher::simulation
