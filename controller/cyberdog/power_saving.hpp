#pragma once
// Low power of the board: CyberDog's power manager is told by the service `low_power_consumption`
// (std_srvs/SetBool) when the machine is in LowPower, and when it leaves it.
//
//   true    the machine has arrived in LowPower, unless the battery took it there
//   false   at the start, and as soon as a switch out of LowPower begins. Requests to the manager
//           (low_power_exit, dog_wakeup, the state topics and services) wait for it
//
// A call is made up to three times, one second apart. What comes to nothing is on record, and is
// tried again with the next switch. A robot without that service has nothing to be told.
//
// Threads: loop thread only.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/controller_shell.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class PowerSaving {
 public:
  inline static constexpr int kTries = 3;
  inline static constexpr Duration kPause = std::chrono::seconds(1);     // between two of them
  inline static constexpr Duration kCallTime = std::chrono::seconds(3);  // that one may take

  // Both must outlive it.
  PowerSaving(transport::Endpoints& endpoints, ControllerShell& shell);

  // Every change of the machine leaves a record.
  void OnRecord() { Look(); }

  // Runs `then` once low power is left, at once where it is not on; with the reason where it cannot
  // be left.
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
  std::optional<bool> given_up_;  // what it was told in vain
  std::optional<bool> trying_;
  int tries_ = 0;                                              // of that
  bool calling_ = false;                                       // no reply yet
  std::vector<std::function<void(const Result<>&)>> waiting_;  // for low power to be left
  transport::LoopHandlePtr again_;
  transport::LoopHandlePtr answered_;  // what waited begins its switch
};

}  // namespace musher::cyberdog
