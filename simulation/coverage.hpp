#pragma once
// Which incidents met the robot in which phase, so that one that never happens is seen.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "musher/lifecycle/machine.hpp"
#include "musher/simulation/incident.hpp"

namespace musher::simulation {

// What the machine is doing.
enum class Moment : std::uint8_t {
  kNoController,  // nobody leads
  kSettingUp,     // its processes come up
  kAtRest,
  kJoining,      // one actuator is on its own way to where the machine is
  kSent,         // a switch has begun, nobody has answered
  kHalfWay,      // some have answered
  kAsking,       // one is overdue
  kRollingBack,  // a switch up has failed
  kFallingBack,  // to on_lost
  kStopped,      // by an emergency stop, at rest
  kTearingDown,
  kOver,  // torn down, or the start has failed
};
inline constexpr std::size_t kMoments = 12;

std::string_view MomentName(Moment moment);  // "at rest", "half way", …

// null: nobody leads.
Moment MomentOf(const Machine* machine);

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
