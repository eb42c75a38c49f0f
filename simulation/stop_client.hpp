#pragma once
// The program that engages an emergency stop, as `musher estop` does, of the parts that ship: it
// publishes the stop and collects who has latched it (StopLatch), follows the controller
// (LeaderWatch), and ends with exit code 0 only if every actuator of the machine has latched it.
// Else, and where no controller leads that saves it, the stop stays published for a minute. Its
// links may be slow and lossy, and its discovery takes long.
//
// Threads: the one of the network.

#include <functional>
#include <memory>
#include <set>
#include <string>

#include "musher/controller/client/leader_watch.hpp"
#include "musher/controller/client/stop_latch.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/simulation/hosts.hpp"

namespace musher::simulation {

class StopClient {
 public:
  struct Options {
    std::string endpoint;
    std::size_t host = 0;
    MachineIdentity machine;  // as far as the program knows it
    // What runs on its host, at any time.
    std::function<StopView()> view = {};
    Duration delay_most{};      // of its links
    double loss = 0;            // the same
    Duration discovery_most{};  // until it and another process know of each other
    std::string name_space = {};
  };
  // The program ends; `confirmed`: with exit code 0.
  using OnEnd = std::function<void(bool confirmed)>;
  // Nothing publishes the stop any more: the client is to be dropped, not inside this call.
  using OnOver = std::function<void()>;

  // `network` and `hosts` must outlive it.
  StopClient(transport::sim::Network& network, Hosts& hosts, Options options, StopId id,
             OnEnd on_end, OnOver on_over);
  ~StopClient();
  StopClient(const StopClient&) = delete;
  StopClient& operator=(const StopClient&) = delete;

  std::size_t host() const { return options_.host; }
  // The program has ended, and another one publishes the stop for a minute.
  bool stays_published() const { return stays_published_; }

 private:
  void OpenLinks(Hosts& hosts);
  void Follow(const Hosts& hosts);
  StopView View() const;
  void Look();
  void End();

  transport::sim::Network& network_;
  const Options options_;
  const OnEnd on_end_;
  const OnOver on_over_;
  std::set<transport::EndpointId> controllers_;  // of the machine, discovered: their writers
  bool ended_ = false;
  bool stays_published_ = false;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Subscription> machines_;
  std::unique_ptr<LeaderWatch> leader_;
  std::unique_ptr<StopLatch> latch_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::simulation
