#pragma once
// Counts which injected events hit the robot in which phase, so that a missing combination shows.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "musher/simulation/injection.hpp"
#include "musher/simulation/phase.hpp"

namespace musher::simulation {

class Coverage {
 public:
  void Count(InjectionKind kind, MachinePhase phase) {
    ++counts_[static_cast<std::size_t>(kind)][static_cast<std::size_t>(phase)];
  }
  void Add(const Coverage& other);
  std::uint64_t Of(InjectionKind kind, MachinePhase phase) const {
    return counts_[static_cast<std::size_t>(kind)][static_cast<std::size_t>(phase)];
  }
  std::uint64_t Of(InjectionKind kind) const;
  // A text table: a row for each kind, a column for each phase.
  std::string Text() const;

 private:
  std::array<std::array<std::uint64_t, kMachinePhases>, kInjectionKinds> counts_{};
};

}  // namespace musher::simulation
