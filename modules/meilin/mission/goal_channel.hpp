#pragma once
// The goals of one action server, as handles of robot.hpp. A goal that is begun while an earlier
// one of this channel is being cancelled is sent after its end, or after kCancelTime; then the
// earlier one, whose end never came, is dropped as lost, and delays no other goal. A server that
// accepts one that was dropped, or was lost while it worked on one, has it cancelled once it
// replies: nothing waits for that goal any more.
//
// Times are those of the loop. Threads: the loop's.

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/meilin/robot.hpp"
#include "musher/transport/action.hpp"

namespace musher::meilin {

// What a handle shows; it outlives the channel.
struct GoalRecord {
  GoalState state = GoalState::kWaiting;
  std::string message;
  std::string feedback;
  int final_state = 0;
  bool cancel = false;      // it is to be cancelled
  bool cancelling = false;  // a request is under way
  bool accepted = false;    // by its server, also after its end here
  Time cancelled_at{};
  transport::GoalId id{};
};

class AnyChannel {
 public:
  virtual ~AnyChannel() = default;
  virtual void Update() = 0;
  virtual void CancelOne(const std::shared_ptr<GoalRecord>& record) = 0;
  virtual void CancelAll() = 0;
  virtual std::size_t open_goals() const = 0;
  virtual bool Ready() const = 0;
};

class GoalHandle final : public Goal {
 public:
  GoalHandle(std::shared_ptr<GoalRecord> record, std::weak_ptr<AnyChannel> channel)
      : record_(std::move(record)), channel_(std::move(channel)) {}

  GoalState state() const override { return record_->state; }
  const std::string& message() const override { return record_->message; }
  int final_state() const override { return record_->final_state; }
  const std::string& feedback() const override { return record_->feedback; }
  void Cancel() override {
    if (HasEnded(record_->state)) return;
    if (const auto channel = channel_.lock()) channel->CancelOne(record_);
  }

 private:
  const std::shared_ptr<GoalRecord> record_;
  const std::weak_ptr<AnyChannel> channel_;
};

template <class Result>
int FinalStateOf(const Result& result) {
  if constexpr (requires { result.final_state; }) {
    return result.final_state;
  } else {
    return 0;
  }
}

template <msg::Action A>
class GoalChannel final : public AnyChannel, public std::enable_shared_from_this<GoalChannel<A>> {
 public:
  static constexpr Duration kCancelTime = std::chrono::seconds(1);
  using ToText = std::function<std::string(const typename A::Feedback&)>;

  // The client may be null: it could not be opened. It must outlive the use of the channel, as the
  // loop must.
  GoalChannel(transport::ActionClient<A>* client, const transport::EventLoop& loop,
              Duration server_time, ToText to_text)
      : client_(client), loop_(loop), server_time_(server_time), to_text_(std::move(to_text)) {}

  GoalPtr Begin(const typename A::Goal& goal) {
    auto record = std::make_shared<GoalRecord>();
    waiting_.push_back({record, goal});
    Update();
    return std::make_unique<GoalHandle>(record, this->weak_from_this());
  }

  void Update() override {
    std::erase_if(open_, [](const auto& record) { return HasEnded(record->state); });
    if (!waiting_.empty()) DropSilent();
    for (const auto& record : open_) {
      if (record->state == GoalState::kWaiting && Ready()) record->state = GoalState::kSent;
      if (record->cancel) SendCancel(record);
    }
    while (!waiting_.empty() && MaySend()) {
      const WaitingGoal next = std::move(waiting_.front());
      waiting_.pop_front();
      if (next.record->state == GoalState::kWaiting) Send(next.record, next.goal);
    }
  }

  void CancelOne(const std::shared_ptr<GoalRecord>& record) override {
    if (!record->cancel) record->cancelled_at = loop_.Now();
    record->cancel = true;
    for (const WaitingGoal& each : waiting_) {
      if (each.record == record) record->state = GoalState::kCancelled;
    }
    SendCancel(record);
  }

  void CancelAll() override {
    for (const WaitingGoal& each : waiting_) each.record->state = GoalState::kCancelled;
    for (const auto& record : open_) CancelOne(record);
    if (Ready()) client_->CancelAll(kCancelTime, [](const auto& /*reply*/) {});
  }

  std::size_t open_goals() const override {
    const auto open = [](const auto& record) { return !HasEnded(record->state); };
    return static_cast<std::size_t>(std::ranges::count_if(open_, open)) + waiting_.size();
  }
  bool Ready() const override { return client_ != nullptr && client_->Ready(); }

 private:
  struct WaitingGoal {
    std::shared_ptr<GoalRecord> record;
    typename A::Goal goal;
  };

  // A server that was to cancel a goal for so long will not say any more that it has.
  void DropSilent() {
    const Time now = loop_.Now();
    for (const auto& record : open_) {
      if (!record->cancel || HasEnded(record->state)) continue;
      if (now - record->cancelled_at <= kCancelTime) continue;
      if (record->accepted) CancelUntilReply(record->id);
      record->message = "its end never came after it was cancelled";
      record->state = GoalState::kLost;
    }
    std::erase_if(open_, [](const auto& record) { return HasEnded(record->state); });
  }

  bool MaySend() const {
    const auto cancelling = [](const auto& record) { return record->cancel; };
    return std::ranges::none_of(open_, cancelling);
  }

  void Send(const std::shared_ptr<GoalRecord>& record, const typename A::Goal& goal) {
    if (client_ == nullptr) {
      record->state = GoalState::kUnavailable;
      return;
    }
    record->state = Ready() ? GoalState::kSent : GoalState::kWaiting;
    transport::GoalEvents<A> events;
    const std::weak_ptr<GoalChannel> weak = this->weak_from_this();
    events.on_accepted = [record, weak] {
      record->accepted = true;
      const auto channel = weak.lock();
      if (HasEnded(record->state)) {  // it was dropped
        if (channel) channel->CancelUntilReply(record->id);
        return;
      }
      record->state = GoalState::kAccepted;
      if (record->cancel && channel) channel->SendCancel(record);
    };
    events.on_feedback = [record, to_text = to_text_](const typename A::Feedback& feedback) {
      record->feedback = to_text(feedback);
    };
    events.on_end = [record, weak](const transport::GoalOutcome<A>& outcome) {
      const bool may_go_on = outcome.end == transport::GoalEnd::kLost && record->accepted;
      const auto channel = weak.lock();
      if (may_go_on && channel) channel->CancelUntilReply(record->id);
      End(*record, outcome);
    };
    record->id = client_->SendGoal(goal, server_time_, std::move(events));
    open_.push_back(record);
  }

  static void End(GoalRecord& record, const transport::GoalOutcome<A>& outcome) {
    using transport::GoalEnd;
    if (HasEnded(record.state)) return;  // it was dropped
    record.message = outcome.reason.empty() ? outcome.result.message : outcome.reason;
    record.final_state = FinalStateOf(outcome.result);
    const bool had_server = record.state != GoalState::kWaiting;
    switch (outcome.end) {
      case GoalEnd::kSucceeded:
        // A server that succeeds with success = false has failed.
        record.state = outcome.result.success ? GoalState::kSucceeded : GoalState::kFailed;
        break;
      case GoalEnd::kAborted:
        record.state = GoalState::kFailed;
        break;
      case GoalEnd::kCanceled:
        record.state = GoalState::kCancelled;
        break;
      case GoalEnd::kRejected:
        record.state = GoalState::kRejected;
        break;
      case GoalEnd::kLost:
        record.state = had_server ? GoalState::kLost : GoalState::kUnavailable;
        break;
    }
  }

  // A goal that is not accepted yet is cancelled once it is: its server does not know it before.
  void SendCancel(const std::shared_ptr<GoalRecord>& record) {
    if (record->state != GoalState::kAccepted || record->cancelling) return;
    record->cancelling = true;
    client_->Cancel(record->id, kCancelTime,
                    [record](const auto& /*reply*/) { record->cancelling = false; });
  }

  // Without a limit: the server may hang for long, and then accept the goal. The reply of any
  // server ends it, also of its next process, which does not know the goal; it cancels this goal
  // only, and is not sent while there is no server.
  void CancelUntilReply(const transport::GoalId& id) {
    client_->Cancel(id, kCancelTime, [id, weak = this->weak_from_this()](const auto& reply) {
      const auto channel = weak.lock();
      if (!reply && channel) channel->CancelUntilReply(id);
    });
  }

  transport::ActionClient<A>* const client_;
  const transport::EventLoop& loop_;
  const Duration server_time_;
  const ToText to_text_;
  std::vector<std::shared_ptr<GoalRecord>> open_;
  std::deque<WaitingGoal> waiting_;
};

}  // namespace musher::meilin
