#pragma once
// The /clock of a simulated world or of a recording: it runs at a rate, pauses, jumps, and begins
// again from zero as another writer.
//
// Threads: the one of the network.

#include <cstdint>
#include <functional>
#include <memory>

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

class WorldClock {
 public:
  // `on_sample` gets the time of each sample that is published. The network must outlive it. The
  // first sample follows after one period.
  WorldClock(transport::sim::Network& network, std::function<void(Time)> on_sample);
  ~WorldClock();
  WorldClock(const WorldClock&) = delete;
  WorldClock& operator=(const WorldClock&) = delete;

  void SetRate(std::int64_t permille) { permille_ = permille; }
  void SetPaused(bool paused) { paused_ = paused; }
  // At the next sample. Back it goes to zero at most.
  void Jump(Duration by);
  // The world is started again: another writer, from zero.
  void Restart();

 private:
  void Open();
  void Tick();

  transport::sim::Network& network_;
  const std::function<void(Time)> on_sample_;
  int writers_ = 0;
  std::int64_t permille_ = 1000;
  bool paused_ = false;
  Time now_{};
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Publisher<msg::Clock>> publisher_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::simulation
