#pragma once
// Low power of the board: calls the service `low_power_consumption` (std_srvs/SetBool) of
// CyberDog's power manager when the machine is in LowPower, and when it leaves it.
//
//   true    the machine has arrived in LowPower, unless the battery took it there
//   false   at the start, and as soon as a switch out of LowPower begins. Requests to the manager
//           (low_power_exit, dog_wakeup, the state topics and services) wait for it
//
// A call is tried up to three times, one second apart. A failure is recorded and retried with the
// next switch. On a robot without that service nothing happens.
//
// Threads: loop thread only.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/shell/controller_shell.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class PowerSaving {
 public:
  inline static constexpr int kTries = 3;
  inline static constexpr Duration kPause = std::chrono::seconds(1);     // between two of them
  inline static constexpr Duration kCallTime = std::chrono::seconds(3);  // timeout of one call

  // Both must outlive it.
  PowerSaving(transport::Endpoints& endpoints, ControllerShell& shell);

  // Call for every record: each change of the machine leaves one.
  void OnRecord();

  // Runs `then` once the board has left low power, at once if it is not on; with an Error if it
  // cannot leave it.
  void Leave(std::function<void(const Result<>&)> then);
  bool leaving() const { return !waiting_.empty(); }

 private:
  bool Wanted() const;
  void Look();
  void Call(bool on);
  void OnFailure(bool on, const Error& why);
  void AnswerWaiting(const Result<>& left);

  ControllerShell& shell_;
  transport::EventLoop& loop_;
  transport::Client<msg::SetBool>* client_;
  std::optional<bool> on_;        // what the power manager has confirmed
  std::optional<bool> given_up_;  // the last value that failed
  std::optional<bool> trying_;
  int tries_ = 0;                                              // of trying_
  bool calling_ = false;                                       // no reply yet
  std::vector<std::function<void(const Result<>&)>> waiting_;  // callbacks of Leave()
  transport::LoopHandlePtr again_;
  transport::LoopHandlePtr answered_;  // runs the waiting callbacks
};

}  // namespace musher::cyberdog
