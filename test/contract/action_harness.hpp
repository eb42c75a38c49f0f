#pragma once
// A server of Fibonacci whose goals a test ends, and what a client sees of each of its goals.

#include <gmock/gmock.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/example_interfaces/fibonacci.hpp"
#include "musher/test/contract/world.hpp"
#include "musher/transport/action.hpp"

namespace musher::transport {

using msg::Fibonacci;
using FibonacciGoal = ServerGoal<Fibonacci>;

constexpr Duration kLong = std::chrono::seconds(15);

// A server, and what its handlers were called with.
struct FibonacciServer {
  // Goals with an order below zero are rejected; cancel requests are accepted if `cancels`.
  static std::unique_ptr<FibonacciServer> Make(Node& node, const std::string& name,
                                               ActionServerOptions options = {}) {
    auto made = std::make_unique<FibonacciServer>();
    FibonacciServer* self = made.get();
    ActionHandlers<Fibonacci> handlers;
    handlers.accept = [self](const Fibonacci::Goal& goal, ParticipantId) {
      ++self->offered;
      return goal.order >= 0;
    };
    handlers.start = [self](FibonacciGoal goal) { self->started.push_back(std::move(goal)); };
    handlers.may_cancel = [self](const FibonacciGoal&) { return self->cancels; };
    handlers.cancel = [self](FibonacciGoal goal) { self->canceling.push_back(std::move(goal)); };
    made->server = Must(MakeActionServer<Fibonacci>(node, name, handlers, std::move(options)));
    return made;
  }

  bool cancels = true;
  int offered = 0;
  std::vector<FibonacciGoal> started;
  std::vector<FibonacciGoal> canceling;
  std::unique_ptr<ActionServer<Fibonacci>> server;
};

// What a client sees of one goal.
struct SeenGoal {
  GoalEvents<Fibonacci> Events() {
    GoalEvents<Fibonacci> events;
    events.on_accepted = [this] { log.emplace_back("accepted"); };
    events.on_state = [this](GoalState state) { log.emplace_back(GoalStateName(state)); };
    events.on_feedback = [this](const Fibonacci::Feedback& feedback) {
      EXPECT_FALSE(log.empty()) << "not before the acceptance";
      feedbacks.push_back(feedback.sequence);
    };
    events.on_end = [this](const GoalOutcome<Fibonacci>& end) {
      EXPECT_FALSE(outcome) << "a goal must end once";
      outcome = end;
    };
    return events;
  }
  bool accepted() const { return !log.empty(); }
  bool ended() const { return outcome.has_value(); }
  std::string End() const {
    return outcome ? std::string(GoalEndName(outcome->end)) : "(not ended)";
  }

  GoalId id{};
  std::vector<std::string> log;
  std::vector<std::vector<std::int32_t>> feedbacks;
  std::optional<GoalOutcome<Fibonacci>> outcome;
};

class ActionContract : public Contract {
 protected:
  std::unique_ptr<ActionClient<Fibonacci>> MakeClient(Node& node,
                                                      ActionClientOptions options = {}) {
    return Must(MakeActionClient<Fibonacci>(node, name_, std::move(options)));
  }
  // A goal, accepted by the server.
  void Start(ActionClient<Fibonacci>& client, SeenGoal& seen, int order = 5) {
    Send(client, seen, order);
    ASSERT_TRUE(RunUntil([&] { return seen.accepted(); }));
  }
  static void Send(ActionClient<Fibonacci>& client, SeenGoal& seen, int order = 5) {
    seen.id = client.SendGoal({order}, kLong, seen.Events());
    EXPECT_TRUE(seen.log.empty()) << "no callback inside SendGoal()";
  }
  bool RunUntilEnded(const SeenGoal& seen) {
    return RunUntil([&] { return seen.ended(); });
  }
  // The reply to a cancel request.
  msg::CancelGoal::Response CancelReply(
      const std::function<void(ActionClient<Fibonacci>::OnCancelReply)>& cancel) {
    std::optional<msg::CancelGoal::Response> response;
    cancel([&](const Result<msg::CancelGoal::Response>& reply) {
      ASSERT_TRUE(reply) << reply.error().message;
      response = reply.value();
    });
    EXPECT_TRUE(RunUntil([&] { return response.has_value(); }));
    return response.value_or(msg::CancelGoal::Response{-1, {}});
  }
  msg::CancelGoal::Response Cancel(ActionClient<Fibonacci>& client, const GoalId& id) {
    return CancelReply([&](auto on_reply) { client.Cancel(id, kLong, std::move(on_reply)); });
  }
  std::string OutcomeOf(ActionClient<Fibonacci>& client, const GoalId& id) {
    std::string end;
    client.GetOutcome(id, kLong, [&](const Result<GoalOutcome<Fibonacci>>& outcome) {
      end = outcome ? GoalEndName(outcome.value().end) : outcome.error().message;
    });
    EXPECT_TRUE(RunUntil([&] { return !end.empty(); }));
    return end;
  }

  const std::string name_ = Unique("fibonacci");
};

}  // namespace musher::transport
