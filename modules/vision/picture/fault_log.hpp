#pragma once
// Logs faults that last: a fault once, and once when it is over; again only after a quiet minute,
// so that a fault that comes and goes with each picture does not fill the log.
//
// Threads: the loop's.

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::vision {

class FaultLog {
 public:
  struct Fault {
    std::optional<Error> error;  // while it lasts
    bool logged = false;
    std::optional<Time> logged_at;
  };

  // `log` gets a fault; code 0: it is over. The loop must outlive it.
  FaultLog(const transport::EventLoop& loop, std::function<void(const Error&)> log)
      : loop_(loop), log_(std::move(log)) {}

  // `well`: the text for the end of the fault.
  void Set(Fault& fault, const Result<>& result, const std::string& well) const {
    fault.error = result ? std::nullopt : std::optional(result.error());
    if (result.ok() != fault.logged) return;
    if (!result && !MayLog(fault.logged_at)) return;
    fault.logged = !result;
    log_(result ? Error{kCodeOk, well} : result.error());
  }

  // Logs an event that may repeat with each picture.
  void Note(std::optional<Time>& logged_at, const std::string& text) const {
    if (MayLog(logged_at)) log_({kCodeOk, text});
  }

 private:
  static constexpr Duration kQuiet = std::chrono::minutes(1);

  bool MayLog(std::optional<Time>& logged_at) const {
    const Time now = loop_.Now();
    if (logged_at && now < *logged_at + kQuiet) return false;
    logged_at = now;
    return true;
  }

  const transport::EventLoop& loop_;
  const std::function<void(const Error&)> log_;
};

}  // namespace musher::vision
