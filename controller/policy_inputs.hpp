#pragma once
// What the policy listens to: battery, motion and time. Topics become events, and of what is
// repeated only the changes; a topic that falls silent becomes one, too.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>

#include "musher/lifecycle/coordinator.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher {

class PolicyInputs {
 public:
  using Tell = std::function<void(const Event&)>;

  // Without [policy] there is nothing to listen to: null.
  static Result<std::unique_ptr<PolicyInputs>> Make(transport::Node& node,
                                                    const MachineConfig& config, Tell tell);

  // The machine begins: what was heard before is told, and everything from now on.
  void Begin();
  // Wakes the policy at this time of its clock. The steady one needs no waking.
  void WakeAt(std::optional<Time> when);
  // Tells the policy's time, where it is a topic's: before whatever depends on it.
  void TellTime();

 private:
  // One topic, and since when nothing was heard of it.
  struct Ear {
    PolicyInput input = PolicyInput::kBattery;
    Duration patience{};
    Time heard{};
    bool silent = false;
    std::unique_ptr<transport::Subscription> subscription;
    transport::LoopHandlePtr timer;
  };

  PolicyInputs(const MachineConfig& config, Tell tell);
  Result<> Open(transport::Node& node);
  void OnWorldRestarted();
  void OnBattery(const msg::BmsStatus& status);
  void OnMotion(const msg::MotionStatus& status);
  void Heard(Ear& ear);
  void WatchFor(Ear& ear);
  bool IsStill(std::int32_t motion) const;
  void Pass(const Event& event);

  const MachineConfig& config_;
  const PolicyConfig& policy_;
  Tell tell_;
  bool begun_ = false;
  bool by_topic_ = false;
  std::optional<event::BatterySeen> battery_;  // the last one that was told, or is to be
  std::optional<event::MotionSeen> motion_;
  std::optional<Time> told_;  // the policy's time
  std::unique_ptr<transport::Clock> clock_;
  transport::LoopHandlePtr first_time_;
  transport::LoopHandlePtr wake_;
  std::optional<Time> wake_at_;
  Ear battery_ear_;
  Ear motion_ear_;
};

}  // namespace musher
