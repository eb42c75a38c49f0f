#include "musher/lifecycle/switch/tear_down_share.hpp"

#include <algorithm>

namespace musher {
namespace {

// The legs in an order in which each stands before those that it needs.
class Order {
 public:
  Order(const MachineConfig& config, const std::vector<Leg>& legs)
      : legs_(config.actuators.size(), nullptr), seen_(config.actuators.size(), false) {
    for (const Leg& leg : legs) legs_[leg.actuator] = &leg;
    for (const Leg& leg : legs) Visit(leg);
    std::reverse(sorted_.begin(), sorted_.end());
  }

  const std::vector<const Leg*>& sorted() const { return sorted_; }

 private:
  void Visit(const Leg& leg) {
    if (seen_[leg.actuator]) return;
    seen_[leg.actuator] = true;
    for (const ActuatorIndex needed : leg.needs) {
      if (legs_[needed] != nullptr) Visit(*legs_[needed]);
    }
    sorted_.push_back(&leg);
  }

  PerActuator<const Leg*> legs_;
  PerActuator<bool> seen_;
  std::vector<const Leg*> sorted_;
};

}  // namespace

PerActuator<Duration> ChainTimes(const MachineConfig& config, const std::vector<Leg>& legs) {
  PerActuator<Duration> chains(config.actuators.size(), Duration{});
  const Order order(config, legs);
  for (const Leg* leg : order.sorted()) {
    // So far the longest chain behind it: those that wait for it came before.
    Duration& chain = chains[leg->actuator];
    chain += config.TimeFor(leg->actuator, leg->target);
    for (const ActuatorIndex needed : leg->needs) {
      chains[needed] = std::max(chains[needed], chain);
    }
  }
  return chains;
}

Duration ShareOf(Duration left, Duration time, Duration chain) {
  if (chain <= left) return time;
  const double part = static_cast<double>(time.count()) / static_cast<double>(chain.count());
  return Duration(static_cast<Duration::rep>(static_cast<double>(left.count()) * part));
}

}  // namespace musher
