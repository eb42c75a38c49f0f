#pragma once
// The connection to the systemd of another host: D-Bus through ssh, as `systemctl --host` has it.
// Or to that of this host: by the socket of its D-Bus, which is up at once or not at all.
//
//   Open()      ssh is started, and on the host a shell prints the host's id and becomes
//               systemd-stdio-bridge; that of the connection before is ended, with what it holds
//   up          the id was read, and systemd sends its signals (on_up)
//   down        ssh has ended, or the host did not answer in time: on_down with the reason. ssh is
//               started again after a while, which doubles up to 10 s; Open() does so at once
//
// Nothing here waits: ssh is another process, and sd-bus is driven by the loop. A host that does
// not answer any more is noticed by ssh within 6 s.
//
// Threads: loop thread only, callbacks too. No callback runs inside a call of this class.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/program.hpp"
#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/transport/event_loop.hpp"

struct sd_bus;
struct sd_bus_message;

namespace musher {

// A message of sd-bus; null: none could be made.
using BusMessage = std::shared_ptr<sd_bus_message>;

class HostBus {
 public:
  struct Options {
    std::vector<std::string> ssh;                   // with its arguments, up to the command
    std::string login;                              // for people: "root@10.0.0.2"
    std::vector<std::string> matches = {};          // of the signals that are received
    Duration connect_within = Milliseconds(8'000);  // ssh's own limit for TCP is 5 s
    std::string socket = {};                        // of this host's D-Bus, in the place of ssh
  };
  struct Hooks {
    std::function<void()> on_up;
    // `for_good`: another attempt does not help, for example after a refused key. `was_up`: an open
    // connection was lost.
    std::function<void(bool was_up, bool for_good)> on_down;
    std::function<void(const BusMessage&)> on_signal;
    // Returns why the host that answers is not used; empty: it is used. Called before D-Bus begins.
    // Without this hook every host is used. `running`: the time since its kernel was booted.
    std::function<std::string(const std::string& host_id, Duration running)> refuse = nullptr;
  };
  // The reply, which may be an error; see sd_bus_message_is_method_error().
  using OnReply = std::function<void(const BusMessage&)>;

  // The loop must outlive it.
  HostBus(transport::EventLoop& loop, Options options, Hooks hooks);
  ~HostBus();
  HostBus(const HostBus&) = delete;
  HostBus& operator=(const HostBus&) = delete;

  // Connects now; nothing happens if it is up, or connecting.
  void Open();
  // Ends the connection for good; nothing is called any more.
  void Close();

  bool is_up() const { return state_ == State::kUp; }
  const std::string& host_id() const { return host_id_; }  // of the last connection
  // For how long its host has run: read when the connection was made, and counted on by the clock
  // here. Too short by the delay of the link.
  Duration running() const;
  // Why the connection is not up, with what to do; empty: no failure since it was up last.
  const std::string& trouble() const { return trouble_; }

  // A call of a method of systemd; null if it is not up.
  BusMessage NewCall(const std::string& path, const std::string& interface,
                     const std::string& method);
  // `done` is not called if the connection is lost before the reply.
  void Send(const BusMessage& call, OnReply done);

 private:
  enum class State : std::uint8_t { kClosed, kWaiting, kGreeting, kSubscribing, kUp, kEnding };
  struct Received {
    BusMessage message;
    std::uint64_t call = 0;  // 0: a signal
  };
  struct PendingReply;

  void Connect();
  bool ConnectHere();
  void ArmConnectDeadline();
  void ReadGreeting();
  void Subscribe();
  void Process();
  void Handle(const std::vector<Received>& received);
  void ArmTimer();
  void ReadErrors();
  void End(const std::string& why);
  void Ended();
  void DropBus();
  void DropSsh();

  transport::EventLoop& loop_;
  const Options options_;
  const Hooks hooks_;
  State state_ = State::kClosed;
  std::string host_id_;
  pid_t bridge_ = 0;   // the process there at the end of the last connection; 0: not known
  Duration booted_{};  // boot time of the last connection's host, by SinceBoot()
  std::string trouble_;
  Duration back_off_;
  std::string greeting_;  // what the host has printed so far
  std::string errors_;    // what ssh has printed
  std::string why_;       // why we have ended ssh; empty: it has ended by itself
  std::optional<ForkedProgram> ssh_;
  UniqueFd stream_;  // until sd-bus owns it
  UniqueFd errors_pipe_;
  UniqueFd pidfd_;
  sd_bus* bus_ = nullptr;
  std::vector<Received> received_;  // by the callbacks of sd-bus
  std::uint64_t next_call_ = 1;
  std::map<std::uint64_t, OnReply> calls_;
  std::vector<std::unique_ptr<PendingReply>> pending_;
  const std::shared_ptr<bool> alive_ = std::make_shared<bool>();  // expires with the connection
  // Last: their callbacks end before what they use.
  transport::LoopHandlePtr stream_watch_;
  transport::LoopHandlePtr errors_watch_;
  transport::LoopHandlePtr exit_watch_;
  transport::LoopHandlePtr deadline_;
  transport::LoopHandlePtr retry_;
  transport::LoopHandlePtr bus_timer_;
};

}  // namespace musher
