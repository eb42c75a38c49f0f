#include "musher/modules/motion/motion_table.hpp"

#include <algorithm>
#include <utility>

namespace musher::motion {

bool Motion::MayGoTo(std::int8_t mode) const {
  return std::find(next.begin(), next.end(), mode) != next.end();
}

MotionTable::MotionTable(std::vector<Motion> motions) : motions_(std::move(motions)) {
  std::sort(motions_.begin(), motions_.end(),
            [](const Motion& a, const Motion& b) { return a.id < b.id; });
}

const Motion* MotionTable::Find(std::int64_t id) const {
  const auto found =
      std::lower_bound(motions_.begin(), motions_.end(), id,
                       [](const Motion& motion, std::int64_t key) { return motion.id < key; });
  return found == motions_.end() || found->id != id ? nullptr : &*found;
}

const Motion* MotionTable::Find(std::int8_t mode, std::int8_t gait) const {
  const auto found = std::find_if(motions_.begin(), motions_.end(), [&](const Motion& motion) {
    return motion.mode == mode && motion.gait == gait;
  });
  return found == motions_.end() ? nullptr : &*found;
}

}  // namespace musher::motion
