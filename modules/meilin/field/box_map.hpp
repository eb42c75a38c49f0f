#pragma once
// Where the boxes (KFS) of a field are, as a planner receives it. Pure values.

#include <array>

#include "musher/modules/meilin/field/grid.hpp"

namespace musher::meilin {

enum class Box : int { kEmpty = 0, kKfs1 = 1, kKfs2 = 2, kFake = 3 };

struct BoxMap {
  Side side = Side::kBlue;
  // Omni: moves keep yaw 0. One-way: moves keep the yaw of the last fetch. A fetch has the yaw of
  // its direction in both.
  bool omni = false;
  std::array<std::array<Box, kCols>, kRows> boxes{};  // row 0 first

  Box At(Cell cell) const;
  friend bool operator==(const BoxMap&, const BoxMap&) = default;
};

}  // namespace musher::meilin
