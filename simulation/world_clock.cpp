#include "musher/simulation/world_clock.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/transport/clock.hpp"

namespace musher::simulation {
namespace {

constexpr Duration kClockEvery = Milliseconds(100);
constexpr std::int64_t kPermilleOfOne = 1000;  // permille

}  // namespace

WorldClock::WorldClock(transport::sim::Network& network, std::function<void(Time)> on_sample)
    : network_(network), on_sample_(std::move(on_sample)) {
  Open();
}

WorldClock::~WorldClock() {
  network_.Crash(*node_);
}

void WorldClock::Jump(Duration by) {
  now_ = std::max(now_ + by, Time{});
}

void WorldClock::Restart() {
  network_.Crash(*node_);
  now_ = Time{};
  Open();
}

void WorldClock::Open() {
  timer_.reset();
  publisher_.reset();
  node_ = network_.MakeNode("world-" + std::to_string(++writers_));
  publisher_ =
      transport::MakePublisher<msg::Clock>(*node_, transport::kClockTopic, transport::kClockQos)
          .value();
  timer_ = node_->loop().Every(kClockEvery, [this] { Tick(); });
}

void WorldClock::Tick() {
  if (paused_) return;
  now_ += Duration(kClockEvery.count() * permille_ / kPermilleOfOne);
  on_sample_(now_);
  static_cast<void>(publisher_->Publish({msg::ToStamp(now_.time_since_epoch())}));
}

}  // namespace musher::simulation
