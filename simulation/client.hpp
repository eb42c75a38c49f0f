#pragma once
// A client of the machine, such as the command line or an application: a process of its own that
// calls the controller's services over the simulated network.
//
// Threads: the one of the network.

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>

#include "musher/controller/client/switch_client.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/simulation/hosts.hpp"

namespace musher::simulation {

class Client {
 public:
  // All but the layout must outlive it. It speaks to the machine of that layout.
  Client(transport::sim::Network& network, Hosts& hosts, const MachineConfig& config,
         const Layout& layout, std::size_t host);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void SetState(const State& target, const std::string& actuator);
  void GetStatus();
  void ReleaseEmergencyStop();
  void Restart(const std::string& actuator);

  // A requested switch whose outcome is not known yet.
  struct Request {
    std::uint64_t id = 0;
    State target;
    Time requested{};              // by the network's clock
    std::optional<Time> orphaned;  // when its controller was killed
    bool notified = false;         // the client has noticed that
  };
  const std::list<Request>& open() const { return open_requests_; }
  // The person or program of its requests: it names the machine that is meant.
  static std::string Name(const std::string& machine_id) {
    return machine_id.empty() ? "a client" : "a client of machine " + machine_id;
  }
  // The leading controller is killed: its open requests have no reply.
  void OnControllerKilled();
  std::size_t host() const { return host_; }
  // How long it takes at most until it and what it calls have discovered each other.
  static constexpr Duration kUsualDiscovery = Milliseconds(5);
  void SetDiscoveryAtMost(Duration most);

  // May be empty. A switch has ended; `end.kind` is kUnknown when the outcome is not known.
  std::function<void(const Request&, const SwitchEnd&)> on_end;
  // A call other than for a switch has ended: with a reply, or without.
  std::function<void(bool replied)> on_reply;

 private:
  template <class S>
  void Call(const char* service, typename S::Request request);

  transport::sim::Network& network_;
  const MachineConfig& config_;
  const MachineIdentity machine_;  // without an id: any
  const std::size_t host_;
  const std::string endpoint_;
  std::uint64_t next_id_ = 1;
  std::unique_ptr<transport::Node> node_;
  std::list<Request> open_requests_;
  std::list<std::pair<std::uint64_t, std::unique_ptr<SwitchClient>>> switches_;
  std::list<std::shared_ptr<void>> calls_;  // transport clients of the other services
};

}  // namespace musher::simulation
