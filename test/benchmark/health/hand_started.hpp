#pragma once
// The actuators of a fleet, modules started by the benchmark and not by a controller.

#include <memory>
#include <string>
#include <vector>

#include "musher/lifecycle/per_actuator.hpp"
#include "musher/test/benchmark/common/board.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"

namespace musher::benchmark {

class HandStarted {
 public:
  // `hz`: of their cycles, 0: they have none.
  explicit HandStarted(const Fleet& fleet, int hz = 0) : fleet_(fleet), hz_(hz) {
    for (const std::string& name : fleet.names()) {
      boards_.push_back(&OpenBoard(fleet.BoardFile(name)));
    }
    children_.resize(boards_.size());
    for (const ActuatorIndex i : Indices()) Start(i);
  }

  // Once more; the one before is killed if it lives.
  void Start(ActuatorIndex i) {
    children_[i] = nullptr;
    children_[i] =
        std::make_unique<Child>(fleet_.Module(fleet_.names()[i.value()], hz_),
                                Child::Environment{{"MUSHER_CONFIG", fleet_.config_file()}});
  }

  ActuatorIndices Indices() const { return children_.Indices(); }
  pid_t pid(ActuatorIndex i) const { return children_[i]->pid(); }
  Board& board(ActuatorIndex i) const { return *boards_[i]; }

 private:
  const Fleet& fleet_;
  const int hz_;
  PerActuator<Board*> boards_;
  PerActuator<std::unique_ptr<Child>> children_;
};

// For actuators that are killed repeatedly: none is given up.
inline constexpr const char* kUnlimitedRestartKeys =
    "restart_limit = 10000\nrestart_reset_ms = 1\n";

}  // namespace musher::benchmark
