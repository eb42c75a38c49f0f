#pragma once
// The way from a command to the controller: joins the domain, finds the controller, asks it.
//
//   Open() ── Ask() ──▶ the answer
//                 └──▶ a Failure: no controller, no answer in time, interrupted, or a bad network
//
// Threads: one; Ask() runs the loop until there is an answer. Ctrl-C ends an Ask(), not the
// program.

#include <sys/types.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "musher/controller/cli/exit_code.hpp"
#include "musher/controller/cli/options.hpp"
#include "musher/controller/cli/signals.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/lifecycle_wire.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"

namespace musher::cli {

class Link {
 public:
  // How long a controller may take to be discovered. One that is there is found in some 10 ms; when
  // a packet of discovery is lost, what repairs it comes within a second.
  static constexpr Duration kDiscovery = Milliseconds(1200);
  // With keys in some 400 ms; what is lost of an introduction is repeated after a second.
  static constexpr Duration kSecuredDiscovery = Milliseconds(4000);
  Duration discovery() const { return global_.keys.empty() ? kDiscovery : kSecuredDiscovery; }
  // One whose process leads on this host, or looks around before it does, answers soon; it may
  // also have had no CPU for a while.
  static constexpr Duration kDiscoveryOfOneHere = Milliseconds(4000);
  static constexpr Duration kSecuredDiscoveryOfOneHere = Milliseconds(9000);
  Duration discovery_of_one_here() const {
    return global_.keys.empty() ? kDiscoveryOfOneHere : kSecuredDiscoveryOfOneHere;
  }

  static Result<std::unique_ptr<Link>> Open(const GlobalOptions& global);

  template <msg::Service S>
  using Answer = std::variant<typename S::Response, Failure>;

  // `service`: "set_state" and the like. Waits as long as --timeout says, else `timeout`.
  template <msg::Service S>
  Answer<S> Ask(const std::string& service, const typename S::Request& request, Duration timeout);

  // From now on keeps the machine's latched status; on_change hears of it, with none when the
  // controller has gone. To be called once.
  using OnStatus = std::function<void(const std::optional<msg::MachineStatus>&)>;
  Result<> FollowStatus(OnStatus on_change);
  const std::optional<msg::MachineStatus>& status() const { return status_; }

  // The machine's latest status; runs the loop until it is on its way to `target`, but not for
  // long: after that, what is known.
  const std::optional<msg::MachineStatus>& StatusTowards(const std::string& target);
  // Runs the loop until a status is there; says nullopt, or why there is none.
  std::optional<Failure> AwaitStatus();
  // The last controller that FollowStatus() heard of, also one that has gone; none: no one.
  const std::optional<msg::MachineStatus>& last_leader() const { return last_leader_; }
  // Runs the loop until this controller has ended, at most `timeout`: its process, where we can see
  // it, else its status, which FollowStatus() must have begun to follow. Says whether it has.
  bool AwaitEndOf(const msg::MachineStatus& controller, Duration timeout);
  // For commands that speak with others than the controller.
  transport::Node& node() { return *node_; }
  transport::EventLoop& loop() { return loop_; }
  // Runs the loop until `done` holds, at most `timeout`, or until Ctrl-C; says whether it held.
  bool RunUntil(const std::function<bool()>& done, Duration timeout);
  bool interrupted() const { return interrupted_; }
  pid_t LeaderHere() const;  // 0: no controller of this host leads in our namespace
  bool HasMachine() const;   // a controller in our namespace has been heard of
  // Nothing was found: "no <what> in namespace …".
  Failure NotFound(const std::string& what) const;

  // Runs the loop until Ctrl-C.
  void RunUntilInterrupted();

  // Runs the loop until the answer is there, or there is a reason to stop waiting for it: no
  // controller is found in time, or it does not answer within `timeout`.
  std::optional<Failure> Await(const std::function<bool()>& answered,
                               const std::function<bool()>& found, Duration timeout);

 private:
  explicit Link(const GlobalOptions& global);
  Result<> Join();

  Failure NoAnswer(Duration timeout) const;
  std::string UnreachableController() const;

  const GlobalOptions& global_;
  transport::UniqueFd signals_;  // before the node: its threads inherit the mask
  transport::LinuxEventLoop loop_;
  bool interrupted_ = false;
  transport::LoopHandlePtr signal_watch_;
  std::map<transport::PeerId, msg::MachineInfo> machines_;  // by the writer that told of them
  std::optional<msg::MachineStatus> status_;
  std::optional<msg::MachineStatus> last_leader_;
  transport::PeerId status_writer_ = 0;  // of the leader that told it
  OnStatus on_status_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Subscription> machine_infos_;
  std::unique_ptr<transport::Subscription> machine_status_;
};

template <msg::Service S>
Link::Answer<S> Link::Ask(const std::string& service, const typename S::Request& request,
                          Duration timeout) {
  auto client =
      transport::MakeClient<S>(*node_, transport::MachineService(global_.name_space, service));
  if (!client) return Failure{ExitCode::kUsage, client.error()};
  const Duration wait = global_.timeout.value_or(timeout);
  std::optional<Result<typename S::Response>> reply;
  // The call's own deadline is not the first to end, not even when we come late to both: Await()
  // says more about who is silent.
  client.value()->Call(request, wait + std::chrono::minutes(1),
                       [&reply](auto result) { reply = std::move(result); });
  const auto failure =
      Await([&] { return reply.has_value(); }, [&] { return client.value()->Ready(); }, wait);
  if (failure) return *failure;
  if (!*reply) return Failure{ExitCode::kNoAnswer, reply->error()};
  return std::move(*reply).value();
}

}  // namespace musher::cli
