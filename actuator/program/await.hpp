#pragma once
// Waits in a state callback for a condition that only the loop can evaluate: devices that need a
// moment after a start.

#include <functional>
#include <optional>

#include "musher/base/result.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::program {

// Calls `check` on the node's loop, at once and every 20 ms, until it succeeds, `time` of the
// loop is over, or `stop` holds, which is called on the calling thread. Returns the last result of
// `check`. Called on the actuator's worker, which blocks.
inline Result<> AwaitOnLoop(transport::NodeThread& node, Duration time,
                            const std::function<Result<>()>& check,
                            const std::function<bool()>& stop) {
  constexpr Duration kPeriod = Milliseconds(20);
  std::optional<Time> deadline;
  for (;;) {
    Result<> result;
    bool over = false;
    node.RunOnLoop([&] {
      result = check();
      const Time now = node.loop().Now();
      if (!deadline) deadline = now + time;
      over = now >= *deadline;
    });
    if (result || over || stop()) return result;
    node.WaitFor(kPeriod);
  }
}

}  // namespace musher::program
