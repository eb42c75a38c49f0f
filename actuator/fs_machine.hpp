#pragma once
// The interface of an actuator for CyberDog's manager: service `<name>machine_service`, offered
// once SetUp is done, and a heartbeat on `manager_heartbeats` every 500 ms while a subscriber is
// matched.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "musher/lifecycle/state.hpp"
#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"

namespace musher {

class FsMachine {
 public:
  // OnCommand calls it once, now or later, with the actuator's state then and the command's code.
  using Reply = std::function<void(const State& state, std::int32_t code)>;
  using OnCommand = std::function<void(const State& target, Reply reply)>;

  // `node` must outlive it.
  static Result<std::unique_ptr<FsMachine>> Make(transport::Node& node,
                                                 const std::string& name_space,
                                                 const std::string& name, OnCommand on_command);

 private:
  FsMachine(transport::Node& node, std::string name) : node_(node), name_(std::move(name)) {}

  void OnMatchChanged();

  transport::Node& node_;
  const std::string name_;
  transport::LoopHandlePtr heartbeat_;  // while a subscriber is matched
  std::unique_ptr<transport::Publisher<msg::Heartbeats>> heartbeats_;
  std::unique_ptr<transport::Server<msg::FsMachine>>
      server_;  // last: its handler uses all of the above
};

}  // namespace musher
