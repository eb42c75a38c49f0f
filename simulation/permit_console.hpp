#pragma once
// A console that permits a machine to move, as `musher permit` does: it gives a permit each 50 ms
// until it is dropped, which ends its process.
//
// Threads: the one of the network.

#include <functional>
#include <memory>
#include <string>

#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/simulation/hosts.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

class PermitConsole {
 public:
  // `on_permit` gets the stamp of each permit that is given. The network must outlive it.
  PermitConsole(transport::sim::Network& network, Hosts& hosts, const std::string& endpoint,
                std::size_t host, const std::string& name_space, const MachineIdentity& machine,
                std::function<void(Time stamp)> on_permit);
  ~PermitConsole();
  PermitConsole(const PermitConsole&) = delete;
  PermitConsole& operator=(const PermitConsole&) = delete;

  std::size_t host() const { return host_; }
  const std::string& endpoint() const { return endpoint_; }

 private:
  void Give();

  transport::sim::Network& network_;
  const std::string endpoint_;
  const std::size_t host_;
  const std::function<void(Time)> on_permit_;
  std::unique_ptr<transport::Node> node_;
  msg::Permit permit_;
  std::unique_ptr<transport::Publisher<msg::Permit>> publisher_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::simulation
