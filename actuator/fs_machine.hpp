#pragma once
// An actuator as CyberDog's manager knows one: service `<name>machine_service`, there once SetUp is
// done, and a beat on `manager_heartbeats` every 500 ms while somebody listens.
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
  // To be called once, now or later: the state the actuator is in then, and the command's code.
  using Reply = std::function<void(const State& state, std::int32_t code)>;
  using OnCommand = std::function<void(const State& target, Reply reply)>;

  // `node` must outlive it.
  static Result<std::unique_ptr<FsMachine>> Make(transport::Node& node,
                                                 const std::string& name_space,
                                                 const std::string& name, OnCommand on_command);

 private:
  FsMachine(transport::Node& node, std::string name) : node_(node), name_(std::move(name)) {}

  void OnListeners();

  transport::Node& node_;
  const std::string name_;
  transport::LoopHandlePtr heartbeat_;  // while somebody listens
  std::unique_ptr<transport::Publisher<msg::Heartbeats>> heartbeats_;
  std::unique_ptr<transport::Server<msg::FsMachine>> server_;  // last: its handler comes to us
};

}  // namespace musher
