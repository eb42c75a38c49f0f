#include "musher/cyberdog/self_check_file.hpp"

#include <utility>

#include "musher/cyberdog/self_check.hpp"

namespace musher::cyberdog {

void SelfCheckFile::OnRecord() {
  const bool running = machine_.phase == Phase::kRunning && machine_.policy.loaded;
  if (!running && machine_.phase != Phase::kFailed) return;
  const bool adopted = machine_.last_switch == 0;
  if (std::exchange(ended_, true) || adopted || !save_) return;
  timer_ = loop_.At(loop_.Now() + kDelay,
                    [this] { save_(kName, SelfCheckOf(config_, machine_).description + "\n"); });
}

}  // namespace musher::cyberdog
