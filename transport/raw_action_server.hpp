#pragma once
// The untyped half of an action server (action.hpp): its three services, its two topics, the goals
// with the callers that wait for their results, and the expiry of results.
//
// A goal is started after the reply that accepts it is sent, which may be held (raw_server.hpp): an
// rclcpp client drops the feedback of a goal that it does not know to be accepted. A goal that is
// cancelled before its start ends without being started, and its result says so where it has a
// text. A goal whose cancellation has overtaken it, on a topic of its own, is rejected; the
// cancellation is answered as ROS 2 does: the goal is unknown.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/stamp.hpp"
#include "musher/transport/action_goals.hpp"
#include "musher/transport/action_names.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport {

struct ActionServerOptions {
  ResultLimits results;
  // The time at which a goal is accepted, for the status and for cancel requests with a time.
  // Empty: the time of day. Endpoints sets the time of its clock.
  std::function<msg::Stamp()> stamp;
};

class RawActionServer;

// The text of the result of a goal that is cancelled before its start.
inline constexpr const char* kNotStartedText = "cancelled before it started";

// An accepted goal. It ends when it is destroyed, if it has not ended before: cancelled if it is
// canceling, else aborted. All calls do nothing after the server is dropped.
class RawGoal {
 public:
  RawGoal() = default;
  virtual ~RawGoal();
  RawGoal(const RawGoal&) = delete;
  RawGoal& operator=(const RawGoal&) = delete;

  const GoalId& id() const { return id_; }
  ParticipantId caller() const { return caller_; }  // that has sent it
  GoalState state() const;
  bool Execute();
  // `reply`: an encoded reply of get_result; its request id and status are filled in.
  bool End(GoalState state, msg::Bytes reply);
  // `message`: an encoded FeedbackMessage.
  bool PublishFeedback(msg::Bytes message);

 private:
  friend class RawActionServer;
  RawActionServer* server() const;

  std::weak_ptr<RawActionServer*> server_;
  GoalId id_{};
  ParticipantId caller_ = 0;
  GoalState ended_ = GoalState::kUnknown;
};
using RawGoalPtr = std::shared_ptr<RawGoal>;

class RawActionServer {
 public:
  struct Handlers {
    // Gets a whole request sample of send_goal. No value: it does not decode; null: rejected.
    std::function<std::optional<RawGoalPtr>(std::span<const std::byte>, ParticipantId)> accept;
    std::function<void(RawGoalPtr)> start;
    std::function<bool(const RawGoalPtr&)> may_cancel;
    std::function<void(RawGoalPtr)> cancel;
  };

  // Replies of get_result, see RawGoal::End().
  struct Defaults {
    msg::Bytes no_result;    // an empty one
    msg::Bytes not_started;  // of a goal that is cancelled before its start
  };

  static Result<std::unique_ptr<RawActionServer>> Make(Node& node, const std::string& action,
                                                       const ActionTypes& types, Defaults defaults,
                                                       Handlers handlers,
                                                       ActionServerOptions options);

  std::uint64_t malformed() const {
    return send_goal_->malformed() + get_result_->malformed() + cancel_goal_->malformed();
  }
  std::size_t goals() const { return goals_.size(); }
  std::size_t waiting() const;

 private:
  friend class RawGoal;

  struct WaitingRequest {
    msg::RequestId id;
    ParticipantId caller;
    RawServer::Reply reply;
  };
  struct Record {
    std::weak_ptr<RawGoal> goal;
    bool started = false;                 // passed to the handler
    std::vector<WaitingRequest> waiting;  // for the end
    msg::Bytes result;                    // from the end on
  };

  RawActionServer(Node& node, Defaults defaults, Handlers handlers, ActionServerOptions options)
      : loop_(node.loop()),
        defaults_(std::move(defaults)),
        options_(std::move(options)),
        handlers_(std::make_shared<const Handlers>(std::move(handlers))),
        goals_(options_.results) {}

  Result<> Open(Node& node, const std::string& action, const ActionTypes& types);
  bool OnSendGoal(const msg::RequestId& id, std::span<const std::byte> bytes,
                  const RawServer::Reply& reply, ParticipantId caller);
  bool OnGetResult(const msg::RequestId& id, std::span<const std::byte> bytes,
                   RawServer::Reply reply, ParticipantId caller);
  void OnCancelGoal(const msg::GoalInfo& request, const Server<msg::CancelGoal>::Reply& reply);
  void Start(const RawGoalPtr& goal);
  bool Execute(const GoalId& id);
  bool End(const GoalId& id, GoalState state, msg::Bytes reply);
  void Abandon(const GoalId& id);
  void ReplyToWaiting(const GoalId& id);
  void Expire();
  void PublishStatuses();

  EventLoop& loop_;
  const Defaults defaults_;
  const ActionServerOptions options_;
  const std::shared_ptr<const Handlers> handlers_;  // shared: a handler may drop the server
  ActionGoals goals_;
  std::map<GoalId, Record> records_;  // of each known goal
  LoopHandlePtr expiry_;
  std::shared_ptr<RawActionServer*> self_ = std::make_shared<RawActionServer*>(this);
  std::unique_ptr<RawWriter> feedback_;
  std::unique_ptr<Publisher<msg::GoalStatusArray>> status_;
  std::unique_ptr<RawServer> get_result_;
  std::unique_ptr<Server<msg::CancelGoal>> cancel_goal_;
  std::unique_ptr<RawServer> send_goal_;  // last: nothing is accepted before the rest exists
};

}  // namespace musher::transport
