#include "musher/transport/raw_action_server.hpp"

#include <algorithm>

namespace musher::transport {

namespace {

// So many callers may wait for a result before those that are lost are forgotten.
constexpr std::size_t kManyWaiting = 32;

// Fills in the first fields of an encoded reply of get_result, behind the 4 bytes of its header.
msg::Bytes Completed(msg::Bytes reply, const msg::RequestId& id, GoalState state) {
  const msg::Bytes begin = msg::Encode(internal::ResultReply{id, static_cast<std::int8_t>(state)});
  MUSHER_CHECK(reply.size() >= begin.size());
  std::copy(begin.begin(), begin.end(), reply.begin());
  return reply;
}

}  // namespace

RawActionServer* RawGoal::server() const {
  const auto server = server_.lock();
  return server ? *server : nullptr;
}

RawGoal::~RawGoal() {
  if (auto* server = this->server()) server->Abandon(id_);
}

GoalState RawGoal::state() const {
  const auto* server = this->server();
  return server == nullptr ? ended_ : server->goals_.StateOf(id_);
}

bool RawGoal::Execute() {
  auto* server = this->server();
  return server != nullptr && server->Execute(id_);
}

bool RawGoal::End(GoalState state, msg::Bytes reply) {
  auto* server = this->server();
  if (server == nullptr || !server->End(id_, state, std::move(reply))) return false;
  ended_ = state;
  server_.reset();  // when the result has expired, another goal may have this id
  return true;
}

bool RawGoal::PublishFeedback(msg::Bytes message) {
  const auto* server = this->server();
  return server != nullptr && IsActive(server->goals_.StateOf(id_)) &&
         server->feedback_->Write(std::move(message)).ok();
}

Result<std::unique_ptr<RawActionServer>> RawActionServer::Make(Node& node,
                                                               const std::string& action,
                                                               const ActionTypes& types,
                                                               Defaults defaults, Handlers handlers,
                                                               ActionServerOptions options) {
  if (!options.stamp) {
    options.stamp = [] {
      return msg::ToStamp(std::chrono::system_clock::now().time_since_epoch());
    };
  }
  std::unique_ptr<RawActionServer> server(
      new RawActionServer(node, std::move(defaults), std::move(handlers), std::move(options)));
  if (const Result<> opened = server->Open(node, action, types); !opened) return opened.error();
  return server;
}

Result<> RawActionServer::Open(Node& node, const std::string& action, const ActionTypes& types) {
  auto feedback =
      node.MakeRawWriter("rt/" + FeedbackTopic(action), types.feedback, kDefaultQos, {});
  if (!feedback) return feedback.error();
  feedback_ = std::move(feedback).value();

  auto status = MakePublisher<msg::GoalStatusArray>(node, StatusTopic(action), kLatchedQos);
  if (!status) return status.error();
  status_ = std::move(status).value();

  auto get_result = RawServer::Make(
      node, GetResultService(action), types.get_result,
      [this](const msg::RequestId& id, std::span<const std::byte> bytes, RawServer::Reply reply,
             ParticipantId caller) { return OnGetResult(id, bytes, std::move(reply), caller); });
  if (!get_result) return get_result.error();
  get_result_ = std::move(get_result).value();

  auto cancel_goal = MakeServer<msg::CancelGoal>(
      node, CancelGoalService(action),
      [this](const msg::CancelGoal::Request& request, const Server<msg::CancelGoal>::Reply& reply) {
        OnCancelGoal(request.goal_info, reply);
      });
  if (!cancel_goal) return cancel_goal.error();
  cancel_goal_ = std::move(cancel_goal).value();

  auto send_goal =
      RawServer::Make(node, SendGoalService(action), types.send_goal,
                      [this](const msg::RequestId& id, std::span<const std::byte> bytes,
                             const RawServer::Reply& reply, ParticipantId caller) {
                        return OnSendGoal(id, bytes, reply, caller);
                      });
  if (!send_goal) return send_goal.error();
  send_goal_ = std::move(send_goal).value();
  return {};
}

bool RawActionServer::OnSendGoal(const msg::RequestId& id, std::span<const std::byte> bytes,
                                 const RawServer::Reply& reply, ParticipantId caller) {
  const auto request = msg::Decode<internal::GoalRequest>(bytes);
  if (!request) return false;
  const GoalId& goal_id = request->goal_id.uuid;
  const auto reject = [&] { reply(msg::Encode(internal::SendGoalReply{id, false, {}})); };
  if (goal_id == kNoGoalId || goals_.StateOf(goal_id) != GoalState::kUnknown ||
      goals_.WasCancelledEarly(goal_id, loop_.Now())) {
    reject();
    return true;
  }
  const std::weak_ptr self = self_;
  const auto handlers = handlers_;
  const std::optional<RawGoalPtr> decided = handlers->accept(bytes, caller);
  if (!decided) return false;
  if (self.expired()) return true;
  const msg::Stamp stamp = options_.stamp();
  if (*decided == nullptr || !goals_.Accept(goal_id, stamp)) {
    reject();
    return true;
  }
  const RawGoalPtr& goal = *decided;
  goal->id_ = goal_id;
  goal->caller_ = caller;
  goal->server_ = self_;
  records_[goal_id].goal = goal;
  reply(msg::Encode(internal::SendGoalReply{id, true, stamp}));
  PublishStatuses();
  send_goal_->AfterReplies(caller, [self, goal] {
    if (const auto server = self.lock()) (*server)->Start(goal);
  });
  return true;
}

void RawActionServer::Start(const RawGoalPtr& goal) {
  if (!IsActive(goals_.StateOf(goal->id()))) return;
  const auto handlers = handlers_;
  records_.at(goal->id()).started = true;
  handlers->start(goal);  // last: it may drop the server
}

bool RawActionServer::OnGetResult(const msg::RequestId& id, std::span<const std::byte> bytes,
                                  RawServer::Reply reply, ParticipantId caller) {
  const auto request = msg::Decode<internal::GoalRequest>(bytes);
  if (!request) return false;
  const GoalId& goal_id = request->goal_id.uuid;
  const GoalState state = goals_.StateOf(goal_id);
  if (state == GoalState::kUnknown) {
    reply(Completed(defaults_.no_result, id, state));
    return true;
  }
  Record& record = records_.at(goal_id);
  if (IsTerminal(state)) {
    reply(Completed(record.result, id, state));
    return true;
  }
  if (record.waiting.size() >= kManyWaiting) {
    std::erase_if(record.waiting, [this](const WaitingRequest& waiting) {
      return !get_result_->HasClientOf(waiting.caller);
    });
  }
  record.waiting.push_back({id, caller, std::move(reply)});
  return true;
}

void RawActionServer::OnCancelGoal(const msg::GoalInfo& request,
                                   const Server<msg::CancelGoal>::Reply& reply) {
  const std::weak_ptr self = self_;
  const auto handlers = handlers_;
  const CancelChoice choice = goals_.ChooseCancelled(request);
  goals_.NoteEarlyCancel(request, loop_.Now());
  std::vector<RawGoalPtr> canceling;
  msg::CancelGoal::Response response;
  response.return_code = choice.return_code;
  for (const GoalId& id : choice.goals) {
    const auto record = records_.find(id);
    RawGoalPtr goal = record == records_.end() ? nullptr : record->second.goal.lock();
    const bool unstarted = goal != nullptr && !record->second.started;
    const bool accepted = unstarted || (goal != nullptr && handlers->may_cancel(goal));
    if (self.expired()) return;
    if (!accepted || !goals_.Change(id, GoalState::kCanceling, loop_.Now())) continue;
    response.goals_canceling.push_back(goals_.InfoOf(id));
    canceling.push_back(std::move(goal));
  }
  for (const GoalId& id : choice.canceling) {
    if (goals_.StateOf(id) == GoalState::kCanceling) {
      response.goals_canceling.push_back(goals_.InfoOf(id));
    }
  }
  if (!choice.goals.empty() && response.goals_canceling.empty()) {
    response.return_code = msg::CancelGoal::kErrorRejected;
  }
  reply(response);
  if (!canceling.empty()) PublishStatuses();
  for (RawGoalPtr& goal : canceling) {
    if (goal->state() != GoalState::kCanceling) continue;
    if (!records_.at(goal->id()).started) {
      goal->End(GoalState::kCanceled, defaults_.not_started);
      continue;
    }
    handlers->cancel(std::move(goal));
    if (self.expired()) return;
  }
}

bool RawActionServer::Execute(const GoalId& id) {
  loop_.CheckThread();
  if (!goals_.Change(id, GoalState::kExecuting, loop_.Now())) return false;
  PublishStatuses();
  return true;
}

bool RawActionServer::End(const GoalId& id, GoalState state, msg::Bytes reply) {
  loop_.CheckThread();
  if (!IsTerminal(state)) return false;
  if (goals_.StateOf(id) == GoalState::kAccepted && state != GoalState::kCanceled) Execute(id);
  if (!goals_.Change(id, state, loop_.Now())) return false;
  records_.at(id).result = Completed(std::move(reply), {}, state);
  ReplyToWaiting(id);
  PublishStatuses();
  Expire();
  return true;
}

void RawActionServer::Abandon(const GoalId& id) {
  const GoalState state = goals_.StateOf(id);
  const bool canceling = state == GoalState::kCanceling;
  if (!IsActive(state)) return;
  End(id, canceling ? GoalState::kCanceled : GoalState::kAborted, defaults_.no_result);
}

void RawActionServer::ReplyToWaiting(const GoalId& id) {
  Record& record = records_.at(id);
  for (const WaitingRequest& waiting : std::exchange(record.waiting, {})) {
    waiting.reply(Completed(record.result, waiting.id, goals_.StateOf(id)));
  }
}

void RawActionServer::Expire() {
  const std::vector<GoalId> expired = goals_.Expire(loop_.Now());
  for (const GoalId& id : expired) records_.erase(id);
  if (!expired.empty()) PublishStatuses();
  expiry_.reset();
  if (const auto next = goals_.NextExpiry()) {
    expiry_ = loop_.At(*next, [this] { Expire(); });
  }
}

// A failure is ignored: the next change publishes all statuses again.
void RawActionServer::PublishStatuses() {
  static_cast<void>(status_->Publish(goals_.Statuses()));
}

std::size_t RawActionServer::waiting() const {
  std::size_t count = 0;
  for (const auto& [id, record] : records_) count += record.waiting.size();
  return count;
}

}  // namespace musher::transport
