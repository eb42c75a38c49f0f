#include "musher/transport/raw_action_client.hpp"

#include <algorithm>
#include <cstring>

namespace musher::transport {

namespace {

// A goal may take so long: its result is requested without a timeout.
constexpr Duration kNoTimeout = std::chrono::hours(24 * 365 * 10);
// How long after a status has shown the end of a goal, or its server was lost, the result is
// requested again, if it has not come.
constexpr Duration kRetryAfter = std::chrono::seconds(1);
// The period in which a goal is cancelled whose acceptance is not known: a server that does not
// know the goal yet may accept it later.
constexpr Duration kCancelAgain = std::chrono::seconds(1);
constexpr int kCancelRepeats = 10;
// Feedback that is kept for a goal before its acceptance is known: the depth of the topic.
constexpr std::size_t kMostEarlyFeedback = 10;

}  // namespace

std::string_view GoalEndName(GoalEnd end) {
  switch (end) {
    case GoalEnd::kSucceeded:
      return "succeeded";
    case GoalEnd::kCanceled:
      return "canceled";
    case GoalEnd::kAborted:
      return "aborted";
    case GoalEnd::kRejected:
      return "rejected";
    case GoalEnd::kLost:
      break;
  }
  return "lost";
}

Result<std::unique_ptr<RawActionClient>> RawActionClient::Make(Node& node,
                                                               const std::string& action,
                                                               const ActionTypes& types,
                                                               ActionClientOptions options) {
  std::unique_ptr<RawActionClient> client(new RawActionClient(node, action, std::move(options)));
  if (const Result<> opened = client->Open(node, types); !opened) return opened.error();
  return client;
}

// The readers of the topics first: a server that discovers the client of send_goal has then
// discovered them, too, and the first feedback reaches them.
Result<> RawActionClient::Open(Node& node, const ActionTypes& types) {
  ReaderCallbacks callbacks;
  callbacks.on_sample = [this](std::span<const std::byte> bytes, const SampleInfo&) {
    OnFeedback(bytes);
  };
  callbacks.on_match_changed = [this] { OnMatchChanged(); };
  auto feedback = node.MakeRawReader("rt/" + FeedbackTopic(action_), types.feedback, kDefaultQos,
                                     std::move(callbacks));
  if (!feedback) return feedback.error();
  feedback_ = std::move(feedback).value();

  SubscriptionEvents events;
  events.on_match_changed = [this] { OnMatchChanged(); };
  // A server may be replaced within its process: the participant remains.
  events.on_writer_lost = [this](EndpointId) {
    for (const GoalId& id : ActiveGoals()) RetryResult(id);
  };
  auto status = MakeSubscription<msg::GoalStatusArray>(
      node, StatusTopic(action_),
      [this](msg::GoalStatusArray&& statuses, const SampleInfo&) { OnStatuses(statuses); },
      kLatchedQos, std::move(events));
  if (!status) return status.error();
  status_ = std::move(status).value();

  const auto on_match_changed = [this] { OnMatchChanged(); };
  auto cancel_goal =
      MakeClient<msg::CancelGoal>(node, CancelGoalService(action_), on_match_changed);
  if (!cancel_goal) return cancel_goal.error();
  cancel_goal_ = std::move(cancel_goal).value();

  auto get_result =
      RawClient::Make(node, GetResultService(action_), types.get_result, on_match_changed);
  if (!get_result) return get_result.error();
  get_result_ = std::move(get_result).value();

  auto send_goal =
      RawClient::Make(node, SendGoalService(action_), types.send_goal, on_match_changed);
  if (!send_goal) return send_goal.error();
  send_goal_ = std::move(send_goal).value();
  return {};
}

bool RawActionClient::Ready() const {
  return send_goal_ != nullptr && send_goal_->Ready() && get_result_->Ready() &&
         cancel_goal_->Ready() && feedback_->MatchedWriters() > 0 && status_->MatchedWriters() > 0;
}

GoalId RawActionClient::GoalIdOf(const msg::RequestId& id) {
  GoalId goal_id{};
  std::memcpy(goal_id.data(), &id.client, sizeof(id.client));
  std::memcpy(goal_id.data() + sizeof(id.client), &id.sequence, sizeof(id.sequence));
  return goal_id;
}

GoalEnd RawActionClient::EndOf(GoalState state) {
  switch (state) {
    case GoalState::kSucceeded:
      return GoalEnd::kSucceeded;
    case GoalState::kCanceled:
      return GoalEnd::kCanceled;
    case GoalState::kAborted:
      return GoalEnd::kAborted;
    default:
      return GoalEnd::kLost;
  }
}

void RawActionClient::SendGoal(const msg::RequestId& id, msg::Bytes request, Duration timeout,
                               Events events) {
  const GoalId goal_id = GoalIdOf(id);
  Goal& goal = goals_[goal_id];
  goal.events = std::make_shared<const Events>(std::move(events));
  goal.timeout = timeout;
  send_goal_->Call(id, std::move(request), timeout,
                   [this, goal_id](const Result<std::span<const std::byte>>& reply) {
                     OnSendReply(goal_id, reply);
                   });
}

void RawActionClient::GetResult(const GoalId& id, Duration timeout, RawClient::OnReply on_reply) {
  const msg::RequestId request = get_result_->NextId();
  get_result_->Call(request, msg::Encode(internal::GoalRequest{request, {id}}), timeout,
                    std::move(on_reply));
}

void RawActionClient::Cancel(const msg::GoalInfo& goals, Duration timeout, OnCancelReply on_reply,
                             CancelCounts counts) {
  if (!counts) return cancel_goal_->Call({goals}, timeout, std::move(on_reply));
  cancel_goal_->CallAll({goals}, timeout, std::move(counts), std::move(on_reply));
}

void RawActionClient::OnSendReply(const GoalId& id,
                                  const Result<std::span<const std::byte>>& reply) {
  std::optional<internal::SendGoalReply> decoded;
  if (reply) decoded = msg::Decode<internal::SendGoalReply>(reply.value());
  const Goal& goal = goals_.at(id);
  if (!decoded && (goal.listed || !goal.feedback.empty())) {
    OnAccepted(id);  // its reply alone is lost
  } else if (!decoded) {
    // The server may have accepted it all the same, or may accept it later.
    CancelLost(id, kCancelRepeats);
    End(id, GoalEnd::kLost, {},
        reply ? "the reply to the goal is malformed" : reply.error().message);
  } else if (!decoded->accepted) {
    End(id, GoalEnd::kRejected, {}, action_ + ": the server rejects the goal");
  } else {
    OnAccepted(id);
  }
}

void RawActionClient::CancelLost(const GoalId& id, int repeats) {
  Cancel({{id}, {}}, kCancelAgain, [this, id, repeats](const auto& reply) {
    const bool done = reply && (reply.value().return_code == msg::CancelGoal::kErrorNone ||
                                reply.value().return_code == msg::CancelGoal::kErrorGoalTerminated);
    cancel_lost_.erase(id);
    if (done || repeats == 0) return;
    cancel_lost_[id] =
        loop_.At(loop_.Now() + kCancelAgain, [this, id, repeats] { CancelLost(id, repeats - 1); });
  });
}

void RawActionClient::OnAccepted(const GoalId& id) {
  Goal& goal = goals_.at(id);
  goal.state = GoalState::kAccepted;
  const auto events = goal.events;
  const std::vector<msg::Bytes> feedback = std::exchange(goal.feedback, {});
  RequestResult(id);
  WatchConnection();
  const std::weak_ptr self = self_;
  if (events->on_accepted) events->on_accepted();
  for (const msg::Bytes& bytes : feedback) {
    if (!self.expired() && events->on_feedback) events->on_feedback(bytes);
  }
}

void RawActionClient::RequestResult(const GoalId& id) {
  Goal& goal = goals_.at(id);
  goal.retry.reset();
  if (goal.result_call != 0) get_result_->Drop(goal.result_call);
  const msg::RequestId request = get_result_->NextId();
  goal.result_call = request.sequence;
  get_result_->Call(
      request, msg::Encode(internal::GoalRequest{request, {id}}), kNoTimeout,
      [this, id](const Result<std::span<const std::byte>>& reply) { OnResult(id, reply); });
  if (goal.has_ended) RetryResult(id);
}

void RawActionClient::RetryResult(const GoalId& id) {
  goals_.at(id).retry = loop_.At(loop_.Now() + kRetryAfter, [this, id] { RequestResult(id); });
}

void RawActionClient::OnResult(const GoalId& id, const Result<std::span<const std::byte>>& reply) {
  goals_.at(id).result_call = 0;
  if (!reply) return RetryResult(id);  // the request could not be written
  const auto decoded = msg::Decode<internal::ResultReply>(reply.value());
  const auto state = static_cast<GoalState>(decoded ? decoded->status : 0);
  if (IsTerminal(state)) return End(id, EndOf(state), reply.value(), "");
  End(id, GoalEnd::kLost, {},
      action_ + ": the server does not know the goal: it has restarted, or the result has expired");
}

void RawActionClient::OnFeedback(std::span<const std::byte> bytes) {
  msg::CdrReader reader(bytes);
  msg::Uuid id;
  reader.Get(id);
  const auto goal = goals_.find(id.uuid);
  if (!reader.ok() || goal == goals_.end()) return;  // another client's goal, or it has ended
  if (goal->second.state != GoalState::kUnknown) {
    const auto events = goal->second.events;
    if (events->on_feedback) events->on_feedback(bytes);
    return;
  }
  auto& early = goal->second.feedback;
  if (early.size() == kMostEarlyFeedback) early.erase(early.begin());
  early.emplace_back(bytes.begin(), bytes.end());
}

void RawActionClient::OnStatuses(const msg::GoalStatusArray& statuses) {
  std::map<GoalId, GoalState> listed;
  for (const msg::GoalStatus& status : statuses.status_list) {
    const auto goal = goals_.find(status.goal_info.goal_id.uuid);
    if (goal == goals_.end()) continue;  // another client's
    const auto state = static_cast<GoalState>(status.status);
    // Both members are set before the acceptance is known, too.
    goal->second.has_ended = IsTerminal(state);
    if (goal->second.state == GoalState::kUnknown) goal->second.listed = true;
    listed[goal->first] = state;
  }
  const std::weak_ptr self = self_;
  for (const GoalId& id : ActiveGoals()) {
    const auto found = goals_.find(id);  // a callback may have ended it
    if (found == goals_.end()) continue;
    Goal& goal = found->second;
    const auto status = listed.find(id);
    const bool was_listed = std::exchange(goal.listed, status != listed.end());
    if (!goal.listed) {
      // A first status without the goal may be older than the goal.
      if (was_listed) RequestResult(id);
    } else if (IsTerminal(status->second)) {
      if (!goal.retry) RetryResult(id);
    } else if (status->second > goal.state) {
      goal.state = status->second;
      const auto events = goal.events;
      if (events->on_state) events->on_state(status->second);
      if (self.expired()) return;
    }
  }
}

void RawActionClient::OnMatchChanged() {
  if (!send_goal_) return;  // not open yet
  std::vector<ParticipantId> servers = get_result_->Servers();
  const bool has_new = std::ranges::any_of(servers, [this](ParticipantId server) {
    return std::ranges::find(servers_, server) == servers_.end();
  });
  servers_ = std::move(servers);
  if (has_new) {
    for (const GoalId& id : ActiveGoals()) RequestResult(id);
  }
  WatchConnection();
  const auto on_match_changed = options_.on_match_changed;
  if (on_match_changed) on_match_changed();
}

void RawActionClient::WatchConnection() {
  if (get_result_->Ready()) {
    lost_.reset();
  } else if (!lost_) {
    lost_ = loop_.At(loop_.Now() + options_.lost_after, [this] {
      lost_.reset();
      EndAllAsLost();
    });
  }
}

std::vector<GoalId> RawActionClient::ActiveGoals() const {
  std::vector<GoalId> ids;
  for (const auto& [id, goal] : goals_) {
    if (goal.state != GoalState::kUnknown) ids.push_back(id);
  }
  return ids;
}

void RawActionClient::EndAllAsLost() {
  const std::weak_ptr self = self_;
  for (const GoalId& id : ActiveGoals()) {
    End(id, GoalEnd::kLost, {}, action_ + ": connection to the server lost");
    if (self.expired()) return;
  }
}

void RawActionClient::End(const GoalId& id, GoalEnd end, std::span<const std::byte> reply,
                          const std::string& reason) {
  auto goal = goals_.extract(id);
  if (goal.empty()) return;
  if (goal.mapped().result_call != 0) get_result_->Drop(goal.mapped().result_call);
  const auto events = goal.mapped().events;
  if (events->on_end) events->on_end(end, reply, reason);  // last: it may drop the client
}

}  // namespace musher::transport
