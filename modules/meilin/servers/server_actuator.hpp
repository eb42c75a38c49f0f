#pragma once
// The actuator of one of the four servers.
//
//   SelfCheck    waits until the hardware is there, for the time of the config; goals go on
//   Active       goals are accepted
//   all others   the hardware stops, the present goal is aborted with the reason, new ones are
//                rejected
//   an emergency stop: the same, until Active is set again after its release
//   SIGTERM, SIGINT: the same, then the process ends by the signal
//
// Threads: state callbacks on the actuator's worker, topics and emergency stops on the loop.

#include <functional>
#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/actuator/program/end_signals.hpp"
#include "musher/modules/meilin/servers/server_config.hpp"

namespace musher::meilin::servers {

class ServerActuator : public MachineActuator {
 public:
  // Makes the server on the loop; without one, of the config. For tests.
  using MakeServer = std::function<Result<std::unique_ptr<Server>>(const Dependencies&)>;

  ServerActuator(const std::string& actuator_name, ServerConfig config, MakeServer make = {});
  ~ServerActuator() override;

  // Whether goals are accepted; in a fault-injection test, too.
  bool permitted() const { return permitted_; }

 protected:
  void OnEmergencyStop() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> Open();
  Result<> SelfCheck();
  Result<> Enter(const State& state);
  void Permit(bool permitted, const std::string& why);

  const program::EndSignals signals_;  // before any thread
  const ServerConfig config_;
  const MakeServer make_;
  bool permitted_ = false;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<transport::OtherMachines> others_;  // null: with keys
  std::unique_ptr<Server> server_;
  transport::LoopHandlePtr signal_watch_;
};

}  // namespace musher::meilin::servers
