#pragma once
// A module like those of CyberDog's machine library: SetUp first, then the service; callbacks run
// on the thread that replies and sends heartbeats; `current_state` is never filled. Tests inject
// its faults.

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/transport/service.hpp"

namespace musher::testing {

class CyberdogModule {
 public:
  struct Callback {
    Duration takes = Milliseconds(5);
    std::int32_t code = 0;
  };

  // `heartbeats_as`: the name in its heartbeats; empty: it sends none.
  CyberdogModule(transport::Node& node, std::string name_space, std::string name,
                 std::string heartbeats_as, Duration set_up_takes = Milliseconds(5));

  std::map<std::string, Callback> script;
  std::vector<std::string> unknown_states;  // those not in its table
  int lost_replies = 0;                     // so many of the next are not sent
  bool sends_heartbeats = true;
  bool heartbeats_while_busy = false;
  std::function<void(const std::string&)> on_callback;  // called before each

  const std::vector<std::string>& log() const { return log_; }  // the callbacks that were begun

 private:
  using Reply = transport::Server<msg::FsMachine>::Reply;

  void Open();
  void Next();
  void Run(const std::string& state, const Reply& reply);
  void Heartbeat();

  transport::Node& node_;
  const std::string name_space_;
  const std::string name_;
  const std::string heartbeats_as_;
  bool busy_ = false;
  std::deque<std::pair<std::string, Reply>> queue_;
  std::vector<std::string> log_;
  std::unique_ptr<transport::Publisher<msg::Heartbeats>> heartbeats_;
  std::unique_ptr<transport::Server<msg::FsMachine>> server_;
  transport::LoopHandlePtr heartbeat_;
  transport::LoopHandlePtr end_;
};

}  // namespace musher::testing
