#pragma once
// A node on a simulated network for an actuator under test: its topics and services are real, and a
// test has their peers on other nodes of the network.
//
// Threads: RunOnLoop() and WaitFor() run on the calling thread, one at a time; the network must not
// run meanwhile. Post() of its loop may be called from any thread, as that of threads of the
// actuator: what it posts runs within kInboxPeriod of the network's time.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

class SimulatedNodeThread final : public transport::NodeThread {
 public:
  static constexpr Duration kInboxPeriod = Milliseconds(20);

  // A process of its own on that host. The network must outlive it.
  SimulatedNodeThread(transport::sim::Network& network, std::string host);
  ~SimulatedNodeThread() override;

  void RunOnLoop(const std::function<void()>& work) override;
  // The network's time passes only here, and where the test runs the network.
  void WaitFor(Duration time) override;
  // Makes the node of another process of the same host.
  Result<std::unique_ptr<transport::Node>> MakeNode(const std::string& name_space,
                                                    const std::string& name) override;
  transport::Node& node() override;
  const std::optional<transport::Credentials>& credentials() const override { return none_; }

 private:
  class ThreadSafeNode;

  void CheckCaller() const;

  transport::sim::Network& network_;
  const std::string host_;
  const std::unique_ptr<ThreadSafeNode> node_;
  const std::optional<transport::Credentials> none_;
};

}  // namespace musher::simulation
