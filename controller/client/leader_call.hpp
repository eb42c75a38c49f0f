#pragma once
// Calls a service of the leading controller whose answer may take as long as a switch, and ends
// when that controller does: the transport keeps a call until its own deadline, because another
// server may answer.
//
//   finding ──a controller leads──▶ called ──its reply──▶ ended
//      │                              └──it ends, and does not lead again──▶ ended, lost
//      └──its last status is found, and no other one leads──▶ ended, lost
//
// Nothing is sent after its end, nor once its time is over, also where this computer was suspended
// meanwhile.
//
// For a switch see SwitchClient, which gets the outcome from the successor.
//
// Threads: loop thread only.

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/controller/client/leader_watch.hpp"
#include "musher/transport/deadline.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {

template <msg::Service S>
class LeaderCall {
 public:
  using Request = typename S::Request;
  using Response = typename S::Response;
  // Runs exactly once, never inside Make(). It must not drop the call. The errors are
  // kCodeTimeout, or kCodeNetError: the controller that was called is lost.
  using OnReply = std::function<void(Result<Response>)>;

  // `service`: as "restart_actuator". The node must outlive the call; dropping the call only ends
  // the waiting.
  static Result<std::unique_ptr<LeaderCall>> Make(transport::Node& node,
                                                  LeaderWatch::Options leader,
                                                  const std::string& service, Request request,
                                                  Duration timeout, OnReply on_reply) {
    std::unique_ptr<LeaderCall> call(
        new LeaderCall(node, leader.host, std::move(request), timeout, std::move(on_reply)));
    auto client =
        transport::MakeClient<S>(node, transport::MachineService(leader.name_space, service),
                                 [self = call.get()] { self->Send(); });
    if (!client) return client.error();
    call->client_ = std::move(client).value();
    leader.one_machine = true;
    auto watch = LeaderWatch::Make(
        node, std::move(leader),
        [self = call.get()](const msg::MachineStatus& status) { self->OnStatus(status); },
        [self = call.get()](const msg::MachineStatus& status, const std::string& how) {
          self->OnLeaderEnd(status, how);
        });
    if (!watch) return watch.error();
    call->watch_ = std::move(watch).value();
    return call;
  }

  // A controller that leads has been found.
  bool found() const { return called_ || watch_->leader(); }

 private:
  // How long to wait for a controller that no longer leads. On this host, where its exit is noticed
  // at once, a reply may still arrive; on another host it leads again when the link is back. Before
  // the call a successor may still be found (kLinkGrace).
  static constexpr Duration kGrace = Milliseconds(200);
  static constexpr Duration kLinkGrace = std::chrono::seconds(5);

  LeaderCall(transport::Node& node, std::string host, Request request, Duration timeout,
             OnReply on_reply)
      : node_(node),
        host_(std::move(host)),
        request_(std::move(request)),
        on_reply_(std::move(on_reply)),
        deadline_(node.loop(), timeout) {
    timer_ = node.loop().At(deadline_.at(), [this] {
      End(Error{kCodeTimeout, "no answer of a controller that leads"});
    });
  }

  void OnStatus(const msg::MachineStatus& status) {
    const bool again = called_ && status.pid == called_->pid && status.host == called_->host;
    if (!called_ || again) grace_ = nullptr;
    Send();
  }
  // The service of a crashed controller may still be matched, so only the leader is called.
  void Send() {
    if (ended_ || called_ || !watch_ || !watch_->leader()) return;
    const auto servers = client_->Servers();
    if (std::find(servers.begin(), servers.end(), watch_->participant()) == servers.end()) return;
    if (deadline_.IsOver()) {
      return End(Error{kCodeTimeout, "no controller that leads was found in time"});
    }
    called_ = watch_->leader();
    Request meant = request_;
    meant.machine = watch_->machine().name;
    meant.machine_id = watch_->machine().id;
    client_->Call(
        meant, deadline_.Left(), [this](Result<Response> reply) { End(std::move(reply)); },
        watch_->participant());
  }
  void OnLeaderEnd(const msg::MachineStatus& leader, const std::string& how) {
    if (called_ && (leader.pid != called_->pid || leader.host != called_->host)) return;
    transport::EventLoop& loop = node_.loop();
    const bool soon = called_ && leader.host == host_;
    std::string why = "the controller (pid " + std::to_string(leader.pid) + ", epoch " +
                      std::to_string(leader.epoch) + ") " + how + " before it " +
                      (called_ ? "answered" : "was called");
    grace_ = loop.At(loop.Now() + (soon ? kGrace : kLinkGrace), [this, why = std::move(why)] {
      End(Error{kCodeNetError, why});
    });
  }
  void End(Result<Response> reply) {
    if (ended_) return;
    ended_ = true;
    timer_ = nullptr;
    grace_ = nullptr;
    on_reply_(std::move(reply));
  }

  transport::Node& node_;
  const std::string host_;
  const Request request_;
  const OnReply on_reply_;
  const transport::Deadline deadline_;
  bool ended_ = false;
  std::optional<msg::MachineStatus> called_;  // the controller that has the request
  transport::LoopHandlePtr timer_;
  transport::LoopHandlePtr grace_;  // while that controller does not lead
  std::unique_ptr<transport::Client<S>> client_;
  std::unique_ptr<LeaderWatch> watch_;  // last: its callbacks use all of the above
};

}  // namespace musher
