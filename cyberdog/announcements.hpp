#pragma once
// The topics that CyberDog's manager publishes: `state_switch_status` at switches,
// `self_check_status` every second, `ready_notify` for a while once the robot is usable.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <optional>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/messages/protocol/manager.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class Announcements {
 public:
  // All must outlive it.
  Announcements(transport::Endpoints& endpoints, const MachineConfig& config,
                const Machine& machine);

  // Call for every record: each change of the machine leaves one.
  void OnRecord(const action::Record& record);

 private:
  struct PendingSwitch {  // a switch under way
    CommandNumber number = 0;
    State target;
    bool published = false;
  };

  bool Leads() const;
  void FollowSwitch(const action::Record& record);
  void PublishEnd(const PendingSwitch& ended, std::int32_t code);
  void PublishReady();

  transport::EventLoop& loop_;
  const MachineConfig& config_;
  const Machine& machine_;
  std::optional<PendingSwitch> pending_;
  State published_state_;
  int ready_times_ = 0;
  std::function<void(const msg::StateSwitchStatus&)> publish_state_;
  std::function<void(const msg::SelfCheckStatus&)> publish_self_check_;
  std::function<void(const msg::Bool&)> publish_ready_;
  transport::LoopHandlePtr self_check_timer_;
  transport::LoopHandlePtr ready_timer_;
};

}  // namespace musher::cyberdog
