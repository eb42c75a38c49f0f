#include "musher/modules/wedding/data/show_data.hpp"

namespace musher::wedding {
namespace {

// Validates a value from a file that may have been edited.
double Within(double value) {
  return value >= 0 && value <= 1 ? value : 0.5;
}

}  // namespace

void ShowData::Persist(fsm::Archive& archive) {
  archive.Field("target_pose", motion.target_pose);
  archive.Field("look_at_x", motion.look_at_target.x);
  archive.Field("look_at_y", motion.look_at_target.y);
  archive.Field("safety_triggered", safety_triggered);
  motion.look_at_target = {Within(motion.look_at_target.x), Within(motion.look_at_target.y)};
}

}  // namespace musher::wedding
