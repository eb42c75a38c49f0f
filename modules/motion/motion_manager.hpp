#pragma once
// The actuator motion_manager: what each state of the machine means for the body.
//
//   SetUp       creates topics and services; waits for the first report of the body
//   SelfCheck   3009 when the board is silent or a motor has an error
//   Active, Protected
//               accepts commands; [capability.*] says which. Nothing moves by itself
//   DeActive, Error
//               stops a running motion and permits none
//   LowPower    the same, and the body lies down: three tries
//   OTA         the same, tried until the state's deadline
//   TearDown    as OTA, by passive get-down
//
// Unlike CyberDog's own, these callbacks fail when the body does not lie down, with the code of
// the last try. Commands stay refused all the same, until Active or Protected.
//
// Threads: state callbacks run on the worker of the base class and call into the loop, which owns
// the shell; OnEmergencyStop() runs on the loop.

#include <chrono>
#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/rate_limited_log.hpp"
#include "musher/base/work_queue.hpp"
#include "musher/modules/motion/motion_shell.hpp"

namespace musher::motion {

class MotionManager : public MachineActuator {
 public:
  MotionManager(const std::string& actuator_name, MotionConfig config, MotionTable table);
  ~MotionManager() override;

 protected:
  void OnEmergencyStop() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> OpenShell();
  Result<std::unique_ptr<MotionBackend>> MakeBackend(MotionBackend::OnBody on_body);
  Result<std::unique_ptr<MotionBackend>> MakeLcmBackend(MotionBackend::OnBody on_body);
  Result<> AwaitBody();
  Result<> SelfCheck();
  Result<> Open();
  Result<> Close(const State& state);
  Result<> CloseLying(const State& state, std::int32_t get_down, int tries);

  void OnLoop(const std::function<void(MotionShell&)>& work);
  Duration TimeToLie(const State& state) const;

  const MotionConfig config_;
  const MotionTable table_;
  std::shared_ptr<transport::NodeThread> loop_;  // keeps the loop until the shell is dropped
  // On the loop only.
  RateLimitedLog jumps_{[this](const std::string& line) { Log(line); }, std::chrono::minutes(1)};
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<MotionShell> shell_;
  // Last. A disk that hangs does not hold the end: the board has no commander then.
  WorkQueue files_{{.name = "gaits",
                    .at_end = WorkQueueOptions::AtEnd::kDrop,
                    .end_timeout = Milliseconds(200)}};
};

}  // namespace musher::motion
