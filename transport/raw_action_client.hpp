#pragma once
// The untyped half of an action client (action.hpp): sends goals, follows each one to its end, and
// detects goals whose server is lost.
//
//   sent --accepted--> active --result of the server-----> succeeded, canceled, aborted
//     \                      \--server or goal is lost---> lost
//      \--rejected-------------------------------------->  rejected
//       \--no reply, status, feedback in time----------->  lost, and cancelled, 11 times at most
//
// The result is requested once the goal is accepted, and again when a server is matched or lost (it
// may have restarted, or a reply was lost with the connection) or when the status topic shows that
// the goal has ended or is no longer known. A server that does not know the goal replies so.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "musher/transport/action_goals.hpp"
#include "musher/transport/action_names.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport {

// How a goal ended for the client.
enum class GoalEnd : std::uint8_t {
  kSucceeded,
  kCanceled,
  kAborted,
  kRejected,  // not accepted: nothing was started
  kLost,      // unknown: the server was lost or has forgotten the goal
};
// "succeeded"
std::string_view GoalEndName(GoalEnd end);

struct ActionClientOptions {
  // A goal is lost when no server has been connected for this time.
  Duration lost_after = std::chrono::seconds(5);
  // Runs when a server was matched or lost.
  std::function<void()> on_match_changed;
};

class RawActionClient {
 public:
  // The callbacks of one goal, in this order. Bytes are whole samples, valid during the callback.
  struct Events {
    std::function<void()> on_accepted;
    std::function<void(GoalState)> on_state;
    std::function<void(std::span<const std::byte>)> on_feedback;
    // With the reply of get_result for a goal that the server ended, else with a reason.
    std::function<void(GoalEnd, std::span<const std::byte>, const std::string& reason)> on_end;
  };
  using OnCancelReply = Client<msg::CancelGoal>::OnReply;
  using CancelCounts = Client<msg::CancelGoal>::Counts;

  static Result<std::unique_ptr<RawActionClient>> Make(Node& node, const std::string& action,
                                                       const ActionTypes& types,
                                                       ActionClientOptions options);

  bool Ready() const;
  std::vector<ParticipantId> Servers() const { return get_result_->Servers(); }
  std::size_t goals() const { return goals_.size(); }

  // The id for encoding the next request of send_goal; it is the goal's id, too, because it is
  // unique in the domain.
  msg::RequestId NextId() { return send_goal_->NextId(); }
  GoalId NextGoalId() const { return GoalIdOf(send_goal_->PeekId()); }
  static GoalId GoalIdOf(const msg::RequestId& id);
  // How a goal in `state` has ended: kLost, unless `state` is terminal.
  static GoalEnd EndOf(GoalState state);

  void SendGoal(const msg::RequestId& id, msg::Bytes request, Duration timeout, Events events);
  void GetResult(const GoalId& id, Duration timeout, RawClient::OnReply on_reply);
  void Cancel(const msg::GoalInfo& goals, Duration timeout, OnCancelReply on_reply,
              CancelCounts counts = {});

 private:
  struct Goal {
    std::shared_ptr<const Events> events;  // shared: a callback may drop the client
    Duration timeout{};                    // of the request that sends it
    GoalState state = GoalState::kUnknown;
    bool listed = false;               // in the last status, or in one before the acceptance
    bool has_ended = false;            // by its status; the result has to come
    std::vector<msg::Bytes> feedback;  // received before it was known to be accepted
    std::int64_t result_call = 0;      // 0: none
    LoopHandlePtr retry;               // of get_result
  };

  RawActionClient(Node& node, std::string action, ActionClientOptions options)
      : loop_(node.loop()), action_(std::move(action)), options_(std::move(options)) {}

  Result<> Open(Node& node, const ActionTypes& types);
  void OnSendReply(const GoalId& id, const Result<std::span<const std::byte>>& reply);
  // Cancels a goal that has ended as lost, until a server says that it is done, or repeats end.
  void CancelLost(const GoalId& id, int repeats);
  void OnAccepted(const GoalId& id);
  void RequestResult(const GoalId& id);
  void RetryResult(const GoalId& id);
  void OnResult(const GoalId& id, const Result<std::span<const std::byte>>& reply);
  void OnFeedback(std::span<const std::byte> bytes);
  void OnStatuses(const msg::GoalStatusArray& statuses);
  void OnMatchChanged();
  void WatchConnection();
  std::vector<GoalId> ActiveGoals() const;
  void EndAllAsLost();
  void End(const GoalId& id, GoalEnd end, std::span<const std::byte> reply,
           const std::string& reason);

  EventLoop& loop_;
  const std::string action_;
  const ActionClientOptions options_;
  std::map<GoalId, Goal> goals_;
  std::map<GoalId, LoopHandlePtr> cancel_lost_;  // the next request; see CancelLost()
  std::vector<ParticipantId> servers_;
  LoopHandlePtr lost_;  // while no server is matched
  std::shared_ptr<RawActionClient*> self_ = std::make_shared<RawActionClient*>(this);
  std::unique_ptr<RawReader> feedback_;
  std::unique_ptr<Subscription> status_;
  std::unique_ptr<Client<msg::CancelGoal>> cancel_goal_;
  std::unique_ptr<RawClient> get_result_;
  std::unique_ptr<RawClient> send_goal_;
};

}  // namespace musher::transport
