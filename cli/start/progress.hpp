#pragma once
// The controller process reports its progress to the `musher up` that started it, over a socket
// pair: events, and how the start-up ended.
//
// Threads: loop thread only.

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/unique_fd.hpp"
#include "musher/messages/cdr.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

struct Progress {
  static constexpr const char* kStartUp = "start-up";        // complete; code 0: usable
  static constexpr const char* kNotStarted = "not-started";  // no controller runs; says why
  static constexpr const char* kTrouble = "trouble";         // a problem; the robot continues
  static constexpr const char* kFenced = "fenced";           // another controller leads now
  static constexpr const char* kAlone = "alone";      // the controller continues without launcher
  static constexpr const char* kStandby = "standby";  // it leads nothing until another one fails
  static constexpr const char* kStopped = "stopped";  // the machine is stopped
  static constexpr const char* kMachine = "machine-status";  // no event: the machine now

  std::int64_t wall_ns = 0;
  std::string kind;  // one of the above, or a journal entry's
  std::string actuator;
  std::uint64_t switch_number = 0;
  std::int32_t code = 0;
  std::string message;
  std::string event{};  // the event name of a record (lifecycle/event_name.hpp), else empty
  msg::MachineStatus machine{};  // of kMachine only

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.wall_ns, m.kind, m.actuator, m.switch_number, m.code, m.message, m.event,
                    m.machine);
  }
  friend bool operator==(const Progress&, const Progress&) = default;
};

// The two ends of a connection that keeps message boundaries.
std::pair<UniqueFd, UniqueFd> MakeProgressPair();

// The controller's end. Never blocks: messages that a stopped launcher does not read wait here;
// once the launcher has exited, nothing is sent any more.
class ProgressSender {
 public:
  ProgressSender(transport::EventLoop& loop, UniqueFd socket)
      : loop_(loop), socket_(std::move(socket)) {}

  void Send(const Progress& progress);
  // Sends the machine behind all messages; one that is not sent yet is replaced, an equal one is
  // not sent again.
  void Send(const msg::MachineStatus& machine);

 private:
  void Flush();
  bool SendNow(const msg::Bytes& bytes);

  transport::EventLoop& loop_;
  UniqueFd socket_;
  bool launcher_exited_ = false;
  std::deque<msg::Bytes> waiting_;
  msg::MachineStatus machine_;        // the last one
  std::optional<msg::Bytes> unsent_;  // the same, encoded, until it is sent
  transport::LoopHandlePtr retry_;
};

// The launcher's end: calls on_progress for each message, then once on_end when the controller
// process has closed its end.
class ProgressReceiver {
 public:
  ProgressReceiver(transport::EventLoop& loop, UniqueFd socket,
                   std::function<void(const Progress&)> on_progress, std::function<void()> on_end);

 private:
  void Receive();

  UniqueFd socket_;
  std::function<void(const Progress&)> on_progress_;
  std::function<void()> on_end_;
  transport::LoopHandlePtr watch_;
};

}  // namespace musher::cli
