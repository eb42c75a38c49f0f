#pragma once
// Whether a node of nav2 goes on where it was; only for the nodes of this folder.
//
// A reactive control resets each child that does not run in each tick, so that the status of a
// condition there says nothing about the tick before. A node with a memory goes on where it was
// ticked in the tick before, or is not idle.

#include <cstdint>

#include "musher/behavior/tree/node.hpp"

namespace musher::tree::nav2 {

class RecentTick {
 public:
  // Once a tick: whether the node begins.
  bool Begins(const Tick& tick, Status status) {
    const bool was_ticked = last_ != 0 && tick.number <= last_ + 1;
    last_ = tick.number;
    return status == Status::kIdle && !was_ticked;
  }

 private:
  std::uint64_t last_ = 0;  // number of its last tick
};

}  // namespace musher::tree::nav2
