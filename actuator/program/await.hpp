#pragma once
// Waits in a state callback for a condition that only the loop can evaluate: devices that need a
// moment after a start.

#include <functional>
#include <future>
#include <utility>

#include "musher/base/result.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::program {

// Calls `check` on the node's loop, at once and every 20 ms, until it succeeds, `time` of the
// steady clock is over, or `stop` holds. Returns the last result of `check`. Called on the
// actuator's worker, which blocks.
inline Result<> AwaitOnLoop(transport::NodeThread& node, Duration time,
                            const std::function<Result<>()>& check,
                            const std::function<bool()>& stop) {
  constexpr Duration kPeriod = Milliseconds(20);
  std::promise<Result<>> verdict;
  bool given = false;
  transport::LoopHandlePtr again;
  node.RunOnLoop([&] {
    const Time deadline = node.loop().Now() + time;
    const auto look = [&, deadline] {
      if (given) return;
      Result<> result = check();
      if (!result && !stop() && node.loop().Now() < deadline) return;
      given = true;
      verdict.set_value(std::move(result));
    };
    again = node.loop().Every(kPeriod, look);
    look();
  });
  Result<> result = verdict.get_future().get();
  node.RunOnLoop([&] { again.reset(); });
  return result;
}

}  // namespace musher::program
