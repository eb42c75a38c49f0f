#pragma once
// A client of the machine, as the command line and applications are: a process of its own that
// calls the controller's services over the simulated network.
//
// Threads: one, that of the network.

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>

#include "musher/controller/switch_client.hpp"
#include "musher/simulation/hosts.hpp"

namespace musher::simulation {

class Client {
 public:
  // The hosts must outlive it.
  Client(transport::sim::Network& network, Hosts& hosts, const MachineConfig& config,
         std::size_t host);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void SetState(const State& target, const std::string& actuator);
  void GetStatus();
  void ReleaseEmergencyStop();
  void Restart(const std::string& actuator);

  // A switch that was requested and whose end is not known yet.
  struct Request {
    std::uint64_t id = 0;
    State target;
    Time asked{};                  // by the network's clock
    std::optional<Time> orphaned;  // the controller that had it is killed
    bool told = false;             // that it is
  };
  const std::list<Request>& open() const { return open_; }
  // A controller is killed: what was requested of it has no answer.
  void OnControllerKilled();  // the one that led
  std::size_t host() const { return host_; }

  // May be empty. A switch has ended; `end.kind` is kUnknown when it is not known how.
  std::function<void(const Request&, const SwitchEnd&)> on_end;
  // A call other than for a switch has ended: with an answer, or without.
  std::function<void(bool answered)> on_answer;

 private:
  template <class S>
  void Call(const char* service, const typename S::Request& request);

  transport::sim::Network& network_;
  const MachineConfig& config_;
  const std::size_t host_;
  std::uint64_t next_id_ = 1;
  std::unique_ptr<transport::Node> node_;
  std::list<Request> open_;
  std::list<std::pair<std::uint64_t, std::unique_ptr<SwitchClient>>> switches_;
  std::list<std::shared_ptr<void>> calls_;  // the clients of the other services
};

}  // namespace musher::simulation
