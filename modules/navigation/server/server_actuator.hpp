#pragma once
// The actuator of a server of the navigation chain. `Server` has a type Config with
// `self_check_time`, Make(), Permit(), Check() and OnTimeJump(), as PlannerServer has them.
//
//   SelfCheck    waits for all robots, for the time of the config; degraded if one is ready, failed
//                if none is; goals are accepted or not as before: after SetUp and in Error not, in
//                the run phase it is a check of a server that goes on
//   Active       goals are accepted
//   all others   present goals end at once, new ones are rejected
//   an emergency stop: the same, until Active is set again after its release
//   SIGTERM, SIGINT: the same, then the process ends by the signal
//
// Threads: state callbacks on the actuator's worker, topics and emergency stops on the loop.

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/actuator/program/await.hpp"
#include "musher/actuator/program/end_signals.hpp"
#include "musher/application/refusal.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/transport/clock.hpp"

namespace musher::navigation {

struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;
  std::string name_space;
  std::function<void(LogLevel level, const std::string& line)> log;
};

// What is missing for the robots of a server.
struct SelfCheckResult {
  std::string missing;  // empty: nothing
  int ready = 0;        // robots

  // `what` is missing for a robot; empty: nothing.
  void Add(const std::string& what) {
    ready += what.empty() ? 1 : 0;
    if (!what.empty()) missing += (missing.empty() ? "" : "; ") + what;
  }
  Result<> result() const {
    if (missing.empty()) return Ok();
    return Error{MakeCode(cyberdog::module_code::kNavigation, KeyCode::kSelfCheckFailed), missing};
  }
};

template <class Server>
class ServerActuator : public MachineActuator {
 public:
  using Make = std::function<Result<std::unique_ptr<Server>>(
      const Dependencies& dependencies, const typename Server::Config& config)>;

  // `make` empty: Server::Make() with its own threads.
  ServerActuator(const std::string& actuator_name, typename Server::Config config, Make make = {})
      : MachineActuator(actuator_name), config_(std::move(config)), make_(std::move(make)) {
    RegisterStateCallback([this](const State& state) { return Run(state); });
  }
  ~ServerActuator() override {
    if (!node_) return;
    node_->RunOnLoop([this] {
      signal_watch_.reset();
      server_.reset();
      clock_.reset();
    });
  }

 protected:
  void OnEmergencyStop() override {
    if (server_) server_->Permit(false, "an emergency stop holds it");
  }

 private:
  Result<> Run(const State& state) {
    if (state == kSetUp) return SetUp();
    if (state == kSelfCheck) return SelfCheck();
    Result<> entered;
    node_->RunOnLoop([&] {
      if (state != kActive) return server_->Permit(false, "it is in " + state);
      if (!EmergencyStopped()) return server_->Permit(true, "");
      entered = RefusedWith<ApplicationRefusal::kStoppedMeanwhile>(
          MakeCode(cyberdog::module_code::kNavigation, KeyCode::kStateInvalid));
    });
    return entered;
  }
  Result<> SetUp() {
    node_ = node();
    if (!node_) {
      return Error{MakeCode(cyberdog::module_code::kNavigation, KeyCode::kUninitialized),
                   "there is no node for its topics"};
    }
    Result<> made;
    node_->RunOnLoop([&] {
      if (!server_) made = MakeServer();
    });
    return made;
  }
  // On the loop.
  Result<> MakeServer() {
    auto clock = transport::Clock::Of(machine_config().clock, node_->node(), [this] {
      if (server_) server_->OnTimeJump(clock_->JumpText());
    });
    if (!clock) return clock.error();
    clock_ = std::move(clock).value();
    const Dependencies dependencies{
        node_->node(), *clock_, machine_config().name_space,
        [this](LogLevel level, const std::string& line) { Log(level, line); }};
    auto server = make_ ? make_(dependencies, config_) : Server::Make(dependencies, config_);
    if (!server) return server.error();
    server_ = std::move(server).value();
    signal_watch_ = signals_.Watch(node_->loop(), [this] { server_.reset(); });
    return Ok();
  }
  Result<> SelfCheck() {
    SelfCheckResult last;
    Result<> checked = program::AwaitOnLoop(
        *node_, config_.self_check_time,
        [&] {
          last = server_->Check();
          return last.result();
        },
        [this] { return StopRequested(); });
    if (checked || last.ready == 0) return checked;
    ReportDegraded(checked.error());  // the other robots can go on
    return Ok();
  }

  const program::EndSignals signals_;  // before any thread
  const typename Server::Config config_;
  const Make make_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<Server> server_;
  transport::LoopHandlePtr signal_watch_;
};

}  // namespace musher::navigation
