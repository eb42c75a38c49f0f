#pragma once
// The connection of a command to the controller: joins the domain, finds the controller, calls it.
// That of this host is called by a socket of the kernel, where its machine is meant.
//
//   Open() ── Call() ──▶ the reply
//                 └──▶ a Failure: no controller, no reply in time, interrupted, or a bad network
//
// On a host with several outer networks Cyclone sends to a process by one of them, and keeps it
// while it is down. So where none answers, the link joins by each network alone.
//
// Threads: one; Call() runs the loop until the reply arrives. Ctrl-C ends a Call(), not the
// program.

#include <sys/types.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/console/exit_code.hpp"
#include "musher/cli/console/options.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/machine/cpu_shortage.hpp"
#include "musher/controller/client/leader_call.hpp"
#include "musher/controller/client/leader_watch.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/host_calls.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {

class Link {
 public:
  // Time for discovering a controller. A running one is found in some 10 ms; a lost discovery
  // packet is repaired within a second.
  static constexpr Duration kDiscovery = Milliseconds(1200);
  // With credentials discovery takes some 400 ms; a lost handshake message is repeated after 1 s.
  static constexpr Duration kSecuredDiscovery = Milliseconds(4000);
  Duration discovery() const { return global_.keys.empty() ? kDiscovery : kSecuredDiscovery; }
  // What is awaited may end so long after Await(), which reports more about processes that do not
  // answer.
  static constexpr Duration kAfterAwait = kLongestShortage + std::chrono::minutes(1);
  // A controller process of this host, leading or still listening for others, answers soon; it may
  // also lack CPU for a while.
  static constexpr Duration kDiscoveryOfOneHere = Milliseconds(4000);
  static constexpr Duration kSecuredDiscoveryOfOneHere = Milliseconds(9000);
  Duration discovery_of_one_here() const {
    return global_.keys.empty() ? kDiscoveryOfOneHere : kSecuredDiscoveryOfOneHere;
  }

  // `console`, which must outlive it, gets a line while the link waits for a controller that is
  // short of CPU time. With several outer networks it waits until a controller answers.
  static Result<std::unique_ptr<Link>> Open(const GlobalOptions& global,
                                            Console* console = nullptr);
  // The same without that wait, by all networks, or by `network` alone.
  static Result<std::unique_ptr<Link>> OpenAtOnce(const GlobalOptions& global,
                                                  Console* console = nullptr,
                                                  const std::string& network = {});
  // The outer networks each of which a link may join by alone; none: there are less than two.
  static std::vector<std::string> SeparateNetworks(const GlobalOptions& global);
  // The same for a command that only uses Call(): it joins the domain once a call needs it.
  static std::unique_ptr<Link> OpenForCalls(const GlobalOptions& global,
                                            Console* console = nullptr);

  enum class Purpose { kLook, kAct };
  // Chooses the machine that the command speaks to: by --machine, else the machine of this host,
  // else the only machine that answers. Runs the loop until it is found, at most for discovery; a
  // Failure if the choice is open, and where a command that acts finds none, or would speak to
  // another machine than that of the files of this host. Call() and FollowStatus() choose it, too.
  std::optional<Failure> ChooseMachine(Purpose purpose = Purpose::kLook);
  // That machine does not run here, and a command that acts names no other one.
  Failure NotHere(const MachineIdentity& here, const std::string& others) const;
  // Speaks to every machine of the namespace, or to `machine`, without waiting.
  void Choose(MachineIdentity machine = {});
  // Speaks to a machine that --machine means, once its controller is discovered. Waits for none.
  void ChooseOnceFound();
  // What is known of it; empty: nothing was found.
  const MachineIdentity& machine() const { return machine_; }

  template <msg::Service S>
  using Answer = std::variant<typename S::Response, Failure>;

  // `service`: for example "set_state". Waits for --timeout if given, else for `timeout`.
  template <msg::Service S>
  Answer<S> Call(const std::string& service, const typename S::Request& request, Duration timeout);

  // The same for a service whose answer may take as long as a switch: fails with kUnknownEnd once
  // the controller that was called is lost.
  template <msg::Service S>
  Answer<S> CallLeader(const std::string& service, const typename S::Request& request,
                       Duration timeout);

  // The same by the socket of this host's controller: needs neither discovery nor a network.
  // nullopt: it is not called so. `lost`: the exit code if it ends before its reply.
  template <msg::Service S>
  std::optional<Answer<S>> CallHere(const std::string& service, const typename S::Request& request,
                                    Duration timeout, ExitCode lost);
  // Begins it, and does not wait: on_reply runs on the loop. Null: it is not called so.
  template <msg::Service S>
  std::unique_ptr<transport::HostCall> BeginCallHere(
      const std::string& service, const typename S::Request& request,
      std::function<void(Result<typename S::Response>)> on_reply);

  // Chooses the machine and subscribes to its latched status. on_change gets each one, and none
  // when the controller is lost. To be called once.
  using OnStatus = std::function<void(const std::optional<msg::MachineStatus>&)>;
  Result<> FollowStatus(OnStatus on_change);
  const std::optional<msg::MachineStatus>& status() const { return status_; }

  // The machine's latest status. Runs the loop until the machine switches to `target`, at most for
  // discovery().
  const std::optional<msg::MachineStatus>& StatusTowards(const std::string& target);
  // FollowStatus() has received a status, and its controller leads no longer.
  bool LeaderIsLost() const;
  // Runs the loop until a status is received. Returns nullopt, or why there is none.
  std::optional<Failure> AwaitStatus();
  // The last status that FollowStatus() received, also of a controller that is lost; none: never
  // any.
  const std::optional<msg::MachineStatus>& last_leader() const { return last_leader_; }
  // Runs the loop until this controller has exited, at most `timeout`. Watches its process if it is
  // on this host, else its status, which requires FollowStatus(). Returns whether it has.
  bool AwaitEndOf(const msg::MachineStatus& controller, Duration timeout);
  // Joins the domain, unless it has.
  Result<> Join();
  // For commands that call other peers than the controller.
  transport::Node& node() { return *node_; }  // not before a link for calls has joined
  transport::EventLoop& loop() { return loop_; }
  // Runs the loop until `done` holds, at most `timeout`, or until Ctrl-C. Returns whether it held.
  bool RunUntil(const std::function<bool()>& done, Duration timeout);
  // The same, and longer while the controller of this host that is spoken to lives, but it or this
  // process is short of CPU time: at most kLongestShortage, and not with --timeout.
  bool RunPatiently(const std::function<bool()>& done, Duration timeout);
  // Whether calls go to the controller of this host by its socket.
  bool CallsHere() const;
  bool interrupted() const { return interrupted_; }
  // Whether Ctrl-C came; the next RunUntil() waits for the next one.
  bool TakeInterrupt() { return std::exchange(interrupted_, false); }
  pid_t LeaderHere() const;      // 0: no controller of this host leads in the command's namespace
  bool HasMachine() const;       // a controller of the chosen machine was discovered
  bool HasOtherMachine() const;  // … of another one in the namespace
  // The failure "no <what> in namespace …".
  Failure NotFound(const std::string& what) const;

  // Runs the loop until Ctrl-C, or until the console's output is lost.
  void RunUntilInterrupted(const Console& console);
  // From now on the exit of the reader of stdout, as in `| head -1`, counts as Ctrl-C: for commands
  // that print until then.
  void EndWithReader();

  // Runs the loop until the answer arrives. Fails if no controller is found in time, or if it does
  // not answer within `timeout`.
  std::optional<Failure> Await(const std::function<bool()>& answered,
                               const std::function<bool()>& found, Duration timeout);

 private:
  Link(const GlobalOptions& global, Console* console);
  std::optional<std::variant<msg::Bytes, Failure>> CallHere(const std::string& service,
                                                            const msg::Bytes& request,
                                                            Duration timeout, ExitCode lost);
  std::string HostCallsName() const;  // empty: no calls go there

  Failure NoAnswer(Duration timeout) const;
  Failure LostBeforeItAnswered() const;
  // A controller that was discovered.
  struct Found {
    msg::MachineInfo info;
    transport::ParticipantId participant = 0;

    MachineIdentity machine() const { return {info.machine, info.machine_id}; }
  };
  Result<> JoinBy(const std::string& network);
  void Leave();
  Result<> JoinByEachNetwork();
  bool IsAnsweredWithin(Duration limit);
  std::vector<Found> Candidates() const;
  bool IsNamed(const MachineIdentity& machine) const;
  bool Speaks(const MachineIdentity& machine) const;
  std::string ControllerName() const;  // that the controller of this host holds
  bool IsNamedHere() const;
  bool ChooseHere(Duration limit);
  std::optional<Failure> ChooseNamed();
  void TakeNamed();
  Result<> Follow();
  std::optional<Failure> ChooseOf(const std::vector<Found>& candidates, Purpose purpose);
  std::optional<Failure> ChooseElsewhere(const std::vector<Found>& candidates, Purpose purpose);
  std::optional<MachineIdentity> MachineOfActuatorsHere();
  static bool AreOne(const std::vector<Found>& candidates);  // none of another machine
  static std::string TextOf(const std::vector<Found>& candidates);
  std::string OthersText() const;
  std::optional<std::string> SilentHere() const;
  static Failure OpenChoice(const std::vector<Found>& candidates, const std::string& what);
  transport::ParticipantId Leader() const;
  pid_t SpokenToHere() const;  // the controller of this host that is spoken to; 0: none
  void ReportShortage(pid_t controller, CpuShortage shortage);

  const GlobalOptions& global_;
  Console* const console_;
  bool shortage_reported_ = false;
  UniqueFd signals_;  // before the node: its threads inherit the mask
  transport::LinuxEventLoop loop_;
  bool interrupted_ = false;
  transport::LoopHandlePtr signal_watch_;
  UniqueFd reader_;
  transport::LoopHandlePtr reader_watch_;
  std::map<transport::EndpointId, Found> machines_;  // by their writer
  MachineIdentity machine_;                          // that was chosen
  bool chosen_ = false;                              // or searched for, in vain
  bool open_ = false;      // nothing but the word of --machine is known of it yet
  bool searched_ = false;  // … and no controller of it was discovered
  std::optional<msg::MachineStatus> status_;
  std::optional<msg::MachineStatus> last_leader_;
  OnStatus on_status_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Subscription> machine_infos_;
  std::unique_ptr<LeaderWatch> leader_;  // of FollowStatus()
  transport::LoopHandlePtr follow_;      // … again, once its machine is found
};

template <msg::Service S>
std::optional<Link::Answer<S>> Link::CallHere(const std::string& service,
                                              const typename S::Request& request, Duration timeout,
                                              ExitCode lost) {
  const auto here =
      CallHere(service, transport::internal::EncodeEnvelope({}, request), timeout, lost);
  if (!here) return std::nullopt;
  if (const auto* failure = std::get_if<Failure>(&*here)) return *failure;
  auto reply = transport::DecodeReply<S>(std::get<msg::Bytes>(*here));
  if (!reply) return Failure{ExitCode::kNoAnswer, reply.error()};
  return std::move(reply).value();
}

template <msg::Service S>
std::unique_ptr<transport::HostCall> Link::BeginCallHere(
    const std::string& service, const typename S::Request& request,
    std::function<void(Result<typename S::Response>)> on_reply) {
  const std::string name = HostCallsName();
  if (name.empty()) return nullptr;
  return transport::HostCall::Make(loop_, name, service,
                                   transport::internal::EncodeEnvelope({}, request),
                                   [done = std::move(on_reply)](Result<msg::Bytes> reply) {
                                     done(transport::DecodeReply<S>(reply));
                                   });
}

template <msg::Service S>
Link::Answer<S> Link::Call(const std::string& service, const typename S::Request& request,
                           Duration timeout) {
  const Duration wait = global_.timeout.value_or(timeout);
  if (auto here = CallHere<S>(service, request, wait, ExitCode::kNoController)) return *here;
  if (auto joined = Join(); !joined) return Failure{ExitCode::kUsage, joined.error()};
  auto client =
      transport::MakeClient<S>(*node_, transport::MachineService(global_.name_space, service));
  if (!client) return Failure{ExitCode::kUsage, client.error()};
  constexpr bool kActs = requires(typename S::Request acting) {
    acting.by;
  };
  if (auto failure = ChooseMachine(kActs ? Purpose::kAct : Purpose::kLook)) {
    return *std::move(failure);
  }
  const transport::ParticipantId leader = Leader();
  if (leader == 0 && !machine_.name.empty()) return NotFound("controller");
  typename S::Request meant = request;
  if constexpr (requires { meant.machine_id; }) {
    meant.machine = machine_.name;
    meant.machine_id = machine_.id;
  }
  const bool led = status_.has_value();
  std::optional<Result<typename S::Response>> reply;
  client.value()->Call(
      meant, wait + kAfterAwait, [&reply](auto result) { reply = std::move(result); }, leader);
  const auto failure = Await([&] { return reply.has_value() || (led && LeaderIsLost()); },
                             [&] { return client.value()->Ready(); }, wait);
  if (failure) return !interrupted_ && LeaderIsLost() ? LostBeforeItAnswered() : *failure;
  if (!reply) return LostBeforeItAnswered();
  if (!*reply) return Failure{ExitCode::kNoAnswer, reply->error()};
  return std::move(*reply).value();
}

template <msg::Service S>
Link::Answer<S> Link::CallLeader(const std::string& service, const typename S::Request& request,
                                 Duration timeout) {
  const Duration wait = global_.timeout.value_or(timeout);
  if (auto here = CallHere<S>(service, request, wait, ExitCode::kUnknownEnd)) return *here;
  if (auto failure = ChooseMachine(Purpose::kAct)) return *std::move(failure);
  LeaderWatch::Options leader{global_.name_space, HostId(), WatchByPidfd(loop_)};
  leader.machine = machine_;
  std::optional<Result<typename S::Response>> reply;
  const auto call = LeaderCall<S>::Make(*node_, leader, service, request, wait + kAfterAwait,
                                        [&reply](auto result) { reply = std::move(result); });
  if (!call) return Failure{ExitCode::kUsage, call.error()};
  const auto failure =
      Await([&] { return reply.has_value(); }, [&] { return call.value()->found(); }, wait);
  if (failure) return *failure;
  if (!*reply) return Failure{ExitCode::kUnknownEnd, reply->error()};
  return std::move(*reply).value();
}

}  // namespace musher::cli
