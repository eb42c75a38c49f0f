#pragma once
// What the three applications have in common: a state machine, skills, and a tree each are an
// engine that ticks while the machine is in Active.
//
//            SetUp: Open()          Active               any other state, emergency stop
//   closed ────────────────▶ paused ──────▶ ticking ─────────────────────────────────▶ paused
//
// Threads: Run() on the worker. Until SetUp is done the engine belongs to the worker, then to the
// loop, on which all other calls are.

#include <functional>
#include <optional>
#include <string>

#include "musher/application/ticks.hpp"
#include "musher/base/result.hpp"

namespace musher {

class ApplicationImpl {
 public:
  ApplicationImpl(MachineActuator& actuator, double rate_hz);
  virtual ~ApplicationImpl() = default;
  ApplicationImpl(const ApplicationImpl&) = delete;
  ApplicationImpl& operator=(const ApplicationImpl&) = delete;

  // The callback of every state.
  Result<> Run(const State& state);
  void OnEmergencyStop();
  // Ends the process when another thread than the loop's calls it.
  void CheckThread() const { ticks_.CheckThread(); }

  bool ticking() const { return ticking_; }
  Time Now() const { return ticks_.Now(); }
  msg::Stamp Stamp() const { return ticks_.Stamp(); }

 protected:
  // On the worker.
  virtual Result<> SetUp() = 0;
  virtual Result<> SelfCheck() = 0;
  // On the loop, when the callback of Active or of another state runs.
  virtual Result<> Activate() = 0;
  virtual void Leave(const State& state) = 0;
  // An emergency stop, once SetUp is done. Returns why something may still move; empty: nothing
  // does.
  virtual std::string StopAtOnce() = 0;
  virtual void Tick() = 0;

  // The end of SetUp: runs `open` on the loop, with the ticks' clock.
  Result<> Open(const std::function<void(transport::Endpoints&)>& open);
  // Service `<actuator>/send_command`. A command that is not urgent, as a stop is, is refused where
  // it may be late, see CheckNotLate().
  void ServeCommands(transport::Endpoints& topics,
                     std::function<Result<>(const std::string& command)> send,
                     std::function<bool(const std::string& command)> is_urgent);
  // Fails if a request that has just arrived may be as old as a break in which this process could
  // not run: what begins or goes on by it is refused.
  Result<> CheckNotLate() const;
  // "its process could not run for 70 s": since the last call, and for so long that what ran does
  // not go on by itself.
  std::optional<std::string> TakeLongBreak();
  // Fails if an emergency stop was engaged since Active was commanded.
  Result<> CheckNoStop() const;
  bool open() const { return open_; }
  void StartTicks();
  void StopTicks();
  // "LowPower, held by the emergency stop".
  std::string Whereabouts() const;
  // Calls the application's OnPause(). An exception is logged, and is a fault of the actuator until
  // a further pause succeeds: its outputs may not be neutral.
  void CallOnPause(const std::function<void()>& hook);

  Ticks ticks_;

 private:
  MachineActuator& actuator_;
  const double rate_hz_;
  bool open_ = false;  // SetUp is done
  bool ticking_ = false;
  std::string pause_fault_;  // that is reported
};

// For the destructor of a class whose hooks an ApplicationImpl calls.
void CheckStopped(const std::string& name, bool started);

}  // namespace musher
