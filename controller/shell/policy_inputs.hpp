#pragma once
// The inputs of the policy: battery, motion and time. Changed samples of their topics become
// events; a topic without samples for its timeout becomes an event, too.
//
// Threads: loop thread only.

#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher {

class PolicyInputs {
 public:
  using Emit = std::function<void(const Event&)>;

  // Null without [policy].
  static Result<std::unique_ptr<PolicyInputs>> Make(transport::Node& node,
                                                    const MachineConfig& config, Emit emit);

  // The machine begins: emits the last samples received before, and everything from now on.
  void Begin();
  // Wakes the policy at this time of its clock. No effect with the steady clock.
  void WakeAt(std::optional<Time> when);
  // Emits the policy's time if it comes from a topic. To be called before every other event.
  void EmitTime();

 private:
  // One topic and the time of its last sample.
  struct Input {
    PolicyInput input = PolicyInput::kBattery;
    Duration timeout{};
    Time received{};
    bool silent = false;
    std::unique_ptr<transport::Subscription> subscription;
    transport::LoopHandlePtr timer;
  };

  // One publisher of the battery.
  struct BatterySource {
    event::BatterySeen last;
    int emitted = 0;  // samples that equal the last one
    Time received{};
  };

  PolicyInputs(const MachineConfig& config, Emit emit);
  Result<> Open(transport::Node& node);
  void OnTimeJumped();
  void OnBattery(const msg::BmsStatus& status, transport::EndpointId writer);
  void ForgetSilentSources();
  void ConfirmAgain();
  void OnMotion(const msg::MotionStatus& status);
  void OnSample(Input& input);
  void WatchForTimeout(Input& input);
  bool IsStill(std::int32_t motion) const;
  void EmitOnceBegun(const Event& event);

  const MachineConfig& config_;
  const PolicyConfig& policy_;
  Emit emit_;
  bool begun_ = false;
  bool by_topic_ = false;
  std::map<transport::EndpointId, BatterySource> batteries_;  // publishers that are not silent
  std::uint32_t next_source_ = 0;
  std::optional<event::MotionSeen> motion_;  // the last one, emitted or to be emitted by Begin()
  std::optional<Time> emitted_time_;
  Time noted_time_{};  // the last one, but for a moment
  std::unique_ptr<transport::Clock> clock_;
  transport::LoopHandlePtr first_time_;
  transport::LoopHandlePtr time_noted_;
  transport::LoopHandlePtr wake_;
  std::optional<Time> wake_at_;
  Input battery_input_;
  Input motion_input_;
};

}  // namespace musher
