#pragma once
// Actions as ROS 2 maps them on services and topics: goals that take time, with feedback, a result,
// and cancellation. `<action>/_action/send_goal`, `get_result` and `cancel_goal` are services,
// `<action>/_action/feedback` and `status` topics.
//
//   // The server: `start` gets a copy of the goal's handle, which it keeps until the goal's end.
//   ActionHandlers<msg::Fibonacci> handlers;
//   handlers.accept = [](const auto& goal, ParticipantId) { return goal.order < 47; };
//   handlers.start = [&](ServerGoal<msg::Fibonacci> goal) {
//     goal.Execute();
//     computing.push_back(goal);  // later: goal.PublishFeedback({…}), goal.Succeed({…})
//   };
//   handlers.cancel = [&](ServerGoal<msg::Fibonacci> goal) { goal.Canceled({}); };
//   auto server = MakeActionServer<msg::Fibonacci>(node, "fibonacci", handlers);
//
//   // The client:
//   auto client = MakeActionClient<msg::Fibonacci>(node, "fibonacci");
//   GoalEvents<msg::Fibonacci> events;
//   events.on_end = [](const GoalOutcome<msg::Fibonacci>& outcome) {…};
//   const GoalId id = client.value()->SendGoal({10}, Milliseconds(500), events);
//
// Problems of the ROS 2 stack that are avoided:
//   - Every goal of a client ends: with the server's result, or as lost with a reason when the
//     server crashed, restarted or became unreachable. (An rclcpp client waits for ever.)
//   - A goal ends as aborted when its server has dropped every handle, and so forgotten the goal.
//   - A goal that is cancelled before its start says so in `error_msg` or `message` of its result.
//   - A cancel request for a goal that is canceling already is answered with that goal, so that it
//     may be repeated. (ROS 2 answers that the goal has ended.)
//   - A cancel request that overtakes its goal is kept for a minute, and the goal is then rejected.
//     (ROS 2 forgets it, and the goal runs.)
//
// The states of a goal are in action_goals.hpp. Feedback, status and result come on different
// topics: a result may overtake the last feedback, which is then dropped.
//
// Threads: loop thread only, callbacks included.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/messages/action.hpp"
#include "musher/transport/raw_action_client.hpp"
#include "musher/transport/raw_action_server.hpp"

namespace musher::transport {

namespace internal {

template <msg::Action A>
ActionTypes TypesOf() {
  return {std::string(A::SendGoal::kTypeName), std::string(A::GetResult::kTypeName),
          std::string(A::FeedbackMessage::kTypeName)};
}

template <msg::Action A>
struct TypedGoal : RawGoal {
  typename A::Goal goal;
};

// A reply of get_result whose request id and status are not filled in.
template <msg::Action A>
msg::Bytes EncodeResult(const typename A::Result& result) {
  typename A::GetResult::Response response;
  response.result = result;
  return EncodeEnvelope(msg::RequestId{}, response);
}

template <class R>
concept HasErrorMsg = requires(R& result) {
  result.error_msg = std::string();
};
template <class R>
concept HasMessage = requires(R& result) {
  result.message = std::string();
};

// The result of a goal that is cancelled before its start, with a text where the type has one.
template <msg::Action A>
typename A::Result NotStarted() {
  typename A::Result result{};
  if constexpr (HasErrorMsg<typename A::Result>) {
    result.error_msg = kNotStartedText;
  } else if constexpr (HasMessage<typename A::Result>) {
    result.message = kNotStartedText;
  }
  return result;
}

}  // namespace internal

// A handle of a goal on its server; copies are handles of the same goal. When the last one is
// dropped the goal ends, if it has not ended before: cancelled if it is canceling, else aborted. A
// call that the state of the goal does not permit, one after its end, and one after the server is
// dropped do nothing and return false.
template <msg::Action A>
class ServerGoal {
 public:
  using GoalResult = typename A::Result;

  explicit ServerGoal(std::shared_ptr<internal::TypedGoal<A>> goal) : goal_(std::move(goal)) {}

  const GoalId& id() const { return goal_->id(); }
  ParticipantId caller() const { return goal_->caller(); }  // that has sent it; see NameOf()
  const typename A::Goal& goal() const { return goal_->goal; }
  GoalState state() const { return goal_->state(); }

  // The goal was accepted; now it is worked on.
  bool Execute() { return goal_->Execute(); }
  // Until the end of the goal. Feedback without a subscriber is dropped, and is no failure: a
  // client that comes later, or has lost its connection, gets the next one.
  bool PublishFeedback(const typename A::Feedback& feedback) {
    typename A::FeedbackMessage message;
    message.goal_id.uuid = id();
    message.feedback = feedback;
    return goal_->PublishFeedback(msg::Encode(message));
  }
  // Ends the goal. Succeed and Abort() are also permitted in accepted, and then execute it first.
  bool Succeed(const GoalResult& result) { return End(GoalState::kSucceeded, result); }
  bool Abort(const GoalResult& result) { return End(GoalState::kAborted, result); }
  // In canceling only.
  bool Canceled(const GoalResult& result) { return End(GoalState::kCanceled, result); }

 private:
  bool End(GoalState state, const GoalResult& result) {
    return goal_->End(state, internal::EncodeResult<A>(result));
  }

  std::shared_ptr<internal::TypedGoal<A>> goal_;
};

// What an action server does with goals. A handler may drop the server.
template <msg::Action A>
struct ActionHandlers {
  // Whether a goal is accepted; without it each one is. A rejected goal starts nothing. A goal with
  // an id that is in use is rejected without a call.
  std::function<bool(const typename A::Goal&, ParticipantId caller)> accept;
  // Begins with an accepted goal, now or later; required. The client has its reply already.
  std::function<void(ServerGoal<A>)> start;
  // Whether a goal that is accepted or executing may be cancelled; without it each one may. It must
  // not end the goal.
  std::function<bool(const ServerGoal<A>&)> may_cancel;
  // The goal is canceling: stop the work and call Canceled(), now or later. Succeed() and Abort()
  // remain permitted. Without it every cancel request is rejected.
  std::function<void(ServerGoal<A>)> cancel;
};

template <msg::Action A>
class ActionServer {
 public:
  explicit ActionServer(std::unique_ptr<RawActionServer> raw) : raw_(std::move(raw)) {}

  // Requests that did not decode.
  std::uint64_t malformed() const { return raw_->malformed(); }
  // The known goals: they have not ended, or their result is kept.
  std::size_t goals() const { return raw_->goals(); }
  // Requests of results of goals that have not ended.
  std::size_t waiting() const { return raw_->waiting(); }

 private:
  std::unique_ptr<RawActionServer> raw_;
};

// How a goal ended for the client that sent it.
template <msg::Action A>
struct GoalOutcome {
  GoalEnd end = GoalEnd::kLost;
  typename A::Result result{};  // of the server; as it was made where the goal is rejected or lost
  std::string reason;           // of a goal that is rejected or lost, for people
};

// The callbacks of one goal; each optional, none runs inside SendGoal(). A callback may drop the
// client.
template <msg::Action A>
struct GoalEvents {
  std::function<void()> on_accepted;
  std::function<void(GoalState)> on_state;  // executing, canceling; may be skipped
  std::function<void(const typename A::Feedback&)> on_feedback;
  std::function<void(const GoalOutcome<A>&)> on_end;  // exactly once
};

template <msg::Action A>
class ActionClient {
 public:
  using OnOutcome = std::function<void(Result<GoalOutcome<A>>)>;
  using OnCancelReply = RawActionClient::OnCancelReply;

  explicit ActionClient(std::unique_ptr<RawActionClient> raw) : raw_(std::move(raw)) {}

  // Whether a server is matched with all its services and topics.
  bool Ready() const { return raw_->Ready(); }
  // The participants of the servers, see Client::Servers().
  std::vector<ParticipantId> Servers() const { return raw_->Servers(); }
  // The goals of this client that have not ended.
  std::size_t goals() const { return raw_->goals(); }

  // The id of the goal that SendGoal() sends next, so that it can be noted before: goals go on when
  // this process is killed, and its successor can cancel those whose ids it knows.
  GoalId NextGoalId() const { return raw_->NextGoalId(); }
  // Sends a goal at once if a server is matched, else as soon as one is. Without a reply, a status
  // or feedback of it in time the goal is lost; should the server accept it all the same, the
  // client cancels it there. Dropping the client drops the callbacks; its goals go on.
  GoalId SendGoal(const typename A::Goal& goal, Duration timeout, GoalEvents<A> events) {
    const msg::RequestId id = raw_->NextId();
    typename A::SendGoal::Request request;
    request.goal_id.uuid = RawActionClient::GoalIdOf(id);
    request.goal = goal;
    raw_->SendGoal(id, internal::EncodeEnvelope(id, request), timeout, Untyped(std::move(events)));
    return request.goal_id.uuid;
  }

  // Cancels goals, also those of other clients. The reply has a return code and the goals that are
  // canceling (action_msgs/cancel_goal.idl). A server that does not know the goal replies so, also
  // where another one runs it: `counts` chooses the reply, see Client::CallAll().
  void Cancel(const GoalId& id, Duration timeout, OnCancelReply on_reply,
              RawActionClient::CancelCounts counts = {}) {
    raw_->Cancel({{id}, {}}, timeout, std::move(on_reply), std::move(counts));
  }
  void CancelAll(Duration timeout, OnCancelReply on_reply) {
    raw_->Cancel({}, timeout, std::move(on_reply));
  }
  // The goals that the server has accepted at or before `stamp`, by the clock of the server.
  void CancelUntil(const msg::Stamp& stamp, Duration timeout, OnCancelReply on_reply) {
    raw_->Cancel({{}, stamp}, timeout, std::move(on_reply));
  }

  // The outcome of any goal, also of another client: when it has ended, or with kCodeTimeout. A
  // goal that the server does not know is lost.
  void GetOutcome(const GoalId& id, Duration timeout, OnOutcome on_outcome) {
    raw_->GetResult(id, timeout,
                    [on_outcome = std::move(on_outcome)](Result<std::span<const std::byte>> reply) {
                      if (!reply) return on_outcome(reply.error());
                      typename A::GetResult::Response response{};
                      if (!internal::DecodeEnvelope(reply.value(), response)) {
                        return on_outcome(Error{kCodeNetError, "the result is malformed"});
                      }
                      const auto end =
                          RawActionClient::EndOf(static_cast<GoalState>(response.status));
                      on_outcome(GoalOutcome<A>{
                          end, std::move(response.result),
                          end == GoalEnd::kLost ? "the server does not know the goal" : ""});
                    });
  }

 private:
  static RawActionClient::Events Untyped(GoalEvents<A> events) {
    RawActionClient::Events raw{std::move(events.on_accepted), std::move(events.on_state), {}, {}};
    raw.on_feedback = [on_feedback = std::move(events.on_feedback)](auto bytes) {
      if (!on_feedback) return;
      if (const auto message = msg::Decode<typename A::FeedbackMessage>(bytes)) {
        on_feedback(message->feedback);
      }
    };
    raw.on_end = [on_end = std::move(events.on_end)](GoalEnd end, auto reply,
                                                     const std::string& reason) {
      if (!on_end) return;
      typename A::GetResult::Response response{};
      const bool malformed = !reply.empty() && !internal::DecodeEnvelope(reply, response);
      if (malformed) return on_end({GoalEnd::kLost, {}, "the result is malformed"});
      on_end({end, std::move(response.result), reason});
    };
    return raw;
  }

  std::unique_ptr<RawActionClient> raw_;
};

template <msg::Action A>
Result<std::unique_ptr<ActionServer<A>>> MakeActionServer(
    Node& node, const std::string& action, ActionHandlers<A> handlers,
    ActionServerOptions options = {}) {  // NOLINT
  using Typed = internal::TypedGoal<A>;
  MUSHER_CHECK(handlers.start != nullptr);
  const auto handle = [](const RawGoalPtr& goal) {
    return ServerGoal<A>(std::static_pointer_cast<Typed>(goal));
  };
  RawActionServer::Handlers raw;
  raw.accept = [accept = std::move(handlers.accept)](
                   std::span<const std::byte> bytes,
                   ParticipantId caller) -> std::optional<RawGoalPtr> {
    typename A::SendGoal::Request request{};
    if (!internal::DecodeEnvelope(bytes, request)) return std::nullopt;
    if (accept && !accept(request.goal, caller)) return RawGoalPtr();
    auto goal = std::make_shared<Typed>();
    goal->goal = std::move(request.goal);
    return RawGoalPtr(std::move(goal));
  };
  raw.start = [start = std::move(handlers.start), handle](const RawGoalPtr& goal) {
    start(handle(goal));
  };
  raw.may_cancel = [may_cancel = std::move(handlers.may_cancel), handle,
                    cancels = static_cast<bool>(handlers.cancel)](const RawGoalPtr& goal) {
    return cancels && (!may_cancel || may_cancel(handle(goal)));
  };
  raw.cancel = [cancel = std::move(handlers.cancel), handle](const RawGoalPtr& goal) {
    cancel(handle(goal));
  };
  RawActionServer::Defaults defaults{internal::EncodeResult<A>({}),
                                     internal::EncodeResult<A>(internal::NotStarted<A>())};
  auto server = RawActionServer::Make(node, action, internal::TypesOf<A>(), std::move(defaults),
                                      std::move(raw), std::move(options));
  if (!server) return server.error();
  return std::make_unique<ActionServer<A>>(std::move(server).value());
}

template <msg::Action A>
Result<std::unique_ptr<ActionClient<A>>> MakeActionClient(
    Node& node, const std::string& action, ActionClientOptions options = {}) {  // NOLINT
  auto client = RawActionClient::Make(node, action, internal::TypesOf<A>(), std::move(options));
  if (!client) return client.error();
  return std::make_unique<ActionClient<A>>(std::move(client).value());
}

}  // namespace musher::transport
