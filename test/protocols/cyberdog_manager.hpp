#pragma once
// A client as CyberDog's manager is one: switches its modules one after the other in the order of
// its list, each with a timeout that counts as -1, and stops at the first that gives no 0; only a
// self-check continues. It receives their heartbeats.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/transport/service.hpp"

namespace musher::testing {

class CyberdogManager {
 public:
  struct Result {
    std::string module;
    std::int32_t code = 0;
    int current_state = 0;
  };
  using Done = std::function<void(std::vector<Result>)>;

  CyberdogManager(transport::Node& node, const std::string& name_space,
                  std::vector<std::string> modules, Duration timeout)
      : modules_(std::move(modules)), timeout_(timeout) {
    for (const std::string& module : modules_) {
      clients_.push_back(transport::MakeClient<msg::FsMachine>(
                             node, transport::ResolveName(name_space, module + "machine_service"))
                             .value());
    }
    heartbeats_ = transport::MakeSubscription<msg::Heartbeats>(
                      node, transport::ResolveName(name_space, "manager_heartbeats"),
                      [this](const msg::Heartbeats& heartbeat, const transport::SampleInfo&) {
                        ++heartbeat_counts[heartbeat.name];
                      },
                      transport::kDefaultQos)
                      .value();
  }

  // Whether every module is set up, which is all that a visible service shows.
  bool Ready() const {
    for (const auto& client : clients_) {
      if (!client->Ready()) return false;
    }
    return true;
  }

  void SetState(const std::string& state, Done done) { Next(0, state, {}, std::move(done)); }

  std::map<std::string, int> heartbeat_counts;  // by name

 private:
  void Next(std::size_t i, const std::string& state, std::vector<Result> results, Done done) {
    if (i == modules_.size()) return done(std::move(results));
    clients_[i]->Call({state}, timeout_,
                      [this, i, state, results = std::move(results), done = std::move(done)](
                          const musher::Result<msg::FsMachine::Response>& reply) mutable {
                        Result result{modules_[i], -1, 0};
                        if (reply) {
                          result = {modules_[i], reply.value().code, reply.value().current_state};
                        }
                        results.push_back(result);
                        const bool go_on = result.code == 0 || state == "SelfCheck";
                        if (!go_on) return done(std::move(results));
                        Next(i + 1, state, std::move(results), std::move(done));
                      });
  }

  std::vector<std::string> modules_;
  Duration timeout_;
  std::vector<std::unique_ptr<transport::Client<msg::FsMachine>>> clients_;
  std::unique_ptr<transport::Subscription> heartbeats_;
};

}  // namespace musher::testing
