#include "musher/behavior/tree/wake_up.hpp"

namespace musher::tree {

void WakeUp::Request() const {
  if (state_ == nullptr) return;
  if (state_->ticks) {
    state_->again = true;
  } else if (!std::exchange(state_->requested, true) && state_->notify) {
    state_->notify();
  }
}

}  // namespace musher::tree
