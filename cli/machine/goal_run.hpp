#pragma once
// A goal of an action that a command sends, and whose end it awaits. Ctrl-C, or the end of
// --timeout, cancels the goal, and the command waits for its end; the second Ctrl-C returns at
// once.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/cli/console/console.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/transport/action.hpp"

namespace musher::cli {

// What messages call a goal, and how long its cancellation may take.
struct GoalWords {
  std::string goal;    // "take_off"
  std::string server;  // "cf2x_0"
  Duration cancel_time = std::chrono::seconds(10);
};

template <msg::Action A>
class GoalRun {
 public:
  using Outcome = transport::GoalOutcome<A>;
  using OnFeedback = std::function<void(const typename A::Feedback&)>;

  // `clear` is called before anything is printed. All references must outlive this.
  GoalRun(Link& link, const GlobalOptions& global, Console& console, GoalWords words,
          std::function<void()> clear)
      : link_(link),
        global_(global),
        console_(console),
        words_(std::move(words)),
        clear_(std::move(clear)) {}

  // `action`: its name in the namespace of the command.
  Result<> Open(const std::string& action) {
    constexpr Duration kLostAfter = std::chrono::seconds(3);
    auto client = transport::MakeActionClient<A>(
        link_.node(), transport::ResolveName(global_.name_space, action), {kLostAfter, {}});
    if (!client) return client.error();
    client_ = std::move(client).value();
    return Ok();
  }
  // After Open(). Runs the loop until a server is discovered; returns whether one was.
  bool AwaitServer() {
    return link_.RunUntil([this] { return client_->Ready(); }, link_.discovery());
  }
  // After Open(): who serves the action.
  std::vector<transport::ParticipantId> Servers() const { return client_->Servers(); }
  // After Open().
  void Send(const typename A::Goal& goal, OnFeedback on_feedback) {
    constexpr Duration kStartTime = std::chrono::seconds(5);  // for the reply to the request
    transport::GoalEvents<A> events;
    events.on_accepted = [this] {
      accepted_ = true;
      if (cancels_) RequestCancel();
    };
    events.on_feedback = std::move(on_feedback);
    events.on_end = [this](const Outcome& outcome) { end_ = outcome; };
    id_ = client_->SendGoal(goal, kStartTime, std::move(events));
  }

  // Until the end of the goal; until Ctrl-C has come twice; or until a timeout is over, and the
  // time for the cancellation that follows it.
  void Wait() {
    std::optional<Time> deadline;
    if (global_.timeout) deadline = link_.loop().Now() + *global_.timeout;
    while (!end_) {
      const Duration left =
          deadline ? *deadline - link_.loop().Now() : Duration(std::chrono::hours(24));
      link_.RunUntil([this] { return end_.has_value(); }, left);
      if (end_) break;
      const bool over = deadline && link_.loop().Now() >= *deadline;
      if (link_.TakeInterrupt()) {
        if (std::exchange(interrupted_, true)) break;
        Cancel("cancelling " + words_.goal + "; Ctrl-C again returns without waiting");
      } else if (over && std::exchange(timed_out_, true)) {
        break;
      } else if (over) {
        Cancel("");
        deadline = link_.loop().Now() + words_.cancel_time;
      }
    }
    clear_();
  }

  const transport::GoalId& id() const { return id_; }
  bool accepted() const { return accepted_; }
  bool interrupted() const { return interrupted_; }
  bool timed_out() const { return timed_out_; }
  const std::optional<Outcome>& end() const { return end_; }  // none: it goes on

 private:
  void Cancel(const std::string& news) {
    clear_();
    if (!news.empty()) console_.PrintError(news);
    cancels_ = true;
    if (accepted_) RequestCancel();
  }
  void RequestCancel() {
    const auto on_reply = [this](const Result<msg::CancelGoal::Response>& reply) {
      const bool refused = reply && reply.value().return_code == msg::CancelGoal::kErrorRejected;
      if (reply && !refused) return;
      clear_();
      console_.PrintError(
          words_.server +
          (refused ? " refuses the cancellation of " : " does not answer to the cancellation of ") +
          words_.goal);
    };
    client_->Cancel(id_, words_.cancel_time, on_reply);
  }

  Link& link_;
  const GlobalOptions& global_;
  Console& console_;
  const GoalWords words_;
  const std::function<void()> clear_;
  transport::GoalId id_{};
  bool accepted_ = false;
  bool cancels_ = false;
  bool interrupted_ = false;
  bool timed_out_ = false;
  std::optional<Outcome> end_;
  std::unique_ptr<transport::ActionClient<A>> client_;  // last: uses all of the above
};

}  // namespace musher::cli
