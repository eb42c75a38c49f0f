// Actions whose server or client is lost, on every transport; partitions on the simulated one.

#include <gmock/gmock.h>

#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/test/contract/action_harness.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::transport::action_loss_test {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using Numbers = std::vector<std::int32_t>;

class ActionLoss : public ActionContract {
 protected:
  const std::unique_ptr<Node> here_ = MakeNode();
  std::unique_ptr<Node> there_ = MakeNode();
  std::unique_ptr<FibonacciServer> server_ = FibonacciServer::Make(*there_, name_);
};
MUSHER_ON_EVERY_TRANSPORT(ActionLoss);

TEST_P(ActionLoss, EndsTheGoalsOfALostServerAsLost) {
  ActionClientOptions options;
  options.lost_after = Milliseconds(100);
  const auto client = MakeClient(*here_, options);
  SeenGoal first, second;
  Start(*client, first);
  Start(*client, second);
  server_.reset();
  there_.reset();
  ASSERT_TRUE(RunUntil([&] { return first.ended() && second.ended(); }));
  EXPECT_EQ(first.End(), "lost");
  EXPECT_EQ(second.outcome->reason, name_ + ": connection to the server lost");
  EXPECT_EQ(client->goals(), 0U);
}

TEST_P(ActionLoss, EndsTheGoalsOfARestartedServerAsLost) {
  const auto client = MakeClient(*here_);
  SeenGoal seen, next;
  Start(*client, seen);
  server_.reset();
  there_.reset();
  there_ = MakeNode();
  server_ = FibonacciServer::Make(*there_, name_);
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "lost");
  EXPECT_THAT(seen.outcome->reason, HasSubstr("it has restarted"));
  Start(*client, next);
  server_->started[0].Succeed({{1}});
  ASSERT_TRUE(RunUntilEnded(next));
  EXPECT_EQ(next.End(), "succeeded") << "with the new server";
}

TEST_P(ActionLoss, EndsAGoalWithoutAServerInTime) {
  const auto client = Must(MakeActionClient<Fibonacci>(*here_, name_ + "_none"));
  SeenGoal seen;
  seen.id = client->SendGoal({5}, Milliseconds(50), seen.Events());
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "lost");
  EXPECT_THAT(seen.outcome->reason, HasSubstr("no server available in time"));
}

// A goal that was accepted too late must not run without a client that follows it.
TEST_P(ActionLoss, CancelsAGoalWhoseAcceptanceComesTooLate) {
  const std::string name = name_ + "_slow";
  const auto client = Must(MakeActionClient<Fibonacci>(*here_, name));
  std::optional<Server<Fibonacci::SendGoal>::Reply> late;
  const auto send_goal = Must(
      MakeServer<Fibonacci::SendGoal>(*there_, name + "/_action/send_goal",
                                      [&](const auto&, auto reply) { late = std::move(reply); }));
  std::vector<GoalId> cancelled;
  const auto cancel_goal = Must(MakeServer<msg::CancelGoal>(
      *there_, name + "/_action/cancel_goal", [&](const auto& request, const auto& reply) {
        cancelled.push_back(request.goal_info.goal_id.uuid);
        reply({});
      }));
  SeenGoal seen;
  seen.id = client->SendGoal({5}, Milliseconds(300), seen.Events());
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "lost");
  ASSERT_TRUE(RunUntil([&] { return !cancelled.empty(); }));
  EXPECT_THAT(cancelled, ElementsAre(seen.id));
  ASSERT_TRUE(late);
  (*late)({true, {}});
}

// A server that does not keep the cancellation of a goal that it does not know starts it later.
TEST_P(ActionLoss, RepeatsTheCancellationOfALostGoalUntilItIsDone) {
  const std::string name = name_ + "_forgets";
  const auto client = Must(MakeActionClient<Fibonacci>(*here_, name));
  const auto send_goal = Must(MakeServer<Fibonacci::SendGoal>(*there_, name + "/_action/send_goal",
                                                              [](const auto&, const auto&) {}));
  std::vector<GoalId> cancelled;
  const auto cancel_goal = Must(MakeServer<msg::CancelGoal>(
      *there_, name + "/_action/cancel_goal", [&](const auto& request, const auto& reply) {
        cancelled.push_back(request.goal_info.goal_id.uuid);
        if (cancelled.size() == 1) return;  // its reply is lost
        msg::CancelGoal::Response response;
        response.return_code = msg::CancelGoal::kErrorUnknownGoalId;
        if (cancelled.size() == 3) {  // it has started the goal
          response.return_code = msg::CancelGoal::kErrorNone;
          response.goals_canceling.push_back(request.goal_info);
        }
        reply(response);
      }));
  SeenGoal seen;
  seen.id = client->SendGoal({5}, Milliseconds(300), seen.Events());
  ASSERT_TRUE(RunUntil([&] { return cancelled.size() == 3; }));
  EXPECT_THAT(cancelled, ElementsAre(seen.id, seen.id, seen.id));
  EXPECT_EQ(seen.End(), "lost") << "at once";
  const Time until = loop().Now() + Milliseconds(1500);
  loop().RunUntil([] { return false; }, until);
  EXPECT_THAT(cancelled, SizeIs(3)) << "its goal is cancelled now";
}

// A writer with a short history may replace a reply that was not received.
TEST_P(ActionLoss, RequestsTheResultOfAnEndedGoalUntilItComes) {
  const std::string name = name_ + "_forgetful";
  const auto status =
      Must(MakePublisher<msg::GoalStatusArray>(*there_, name + "/_action/status", kLatchedQos));
  const auto send_goal = Must(MakeServer<Fibonacci::SendGoal>(
      *there_, name + "/_action/send_goal", [&](const auto& request, const auto& reply) {
        reply({true, {}});
        EXPECT_TRUE(status->Publish({{{{request.goal_id, {}}, msg::GoalStatus::kStatusAborted}}}));
      }));
  int requests = 0;
  const auto get_result = Must(MakeServer<Fibonacci::GetResult>(
      *there_, name + "/_action/get_result", [&](const auto&, const auto& reply) {
        if (++requests == 3) reply({msg::GoalStatus::kStatusAborted, {{6}}});
      }));
  const auto client = Must(MakeActionClient<Fibonacci>(*here_, name));
  SeenGoal seen;
  Send(*client, seen);
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(requests, 3);
  EXPECT_EQ(seen.End(), "aborted");
  EXPECT_EQ(seen.outcome->result.sequence, Numbers{6});
}

TEST_P(ActionLoss, GoesOnWithTheGoalsOfALostClient) {
  auto gone = MakeNode();
  auto client = MakeClient(*gone);
  SeenGoal seen;
  Start(*client, seen);
  client.reset();
  gone.reset();
  EXPECT_EQ(server_->started[0].state(), GoalState::kAccepted);
  EXPECT_TRUE(server_->started[0].Succeed({{2}}));
  EXPECT_FALSE(seen.ended()) << "its callbacks are dropped";
  const auto other = MakeClient(*here_);
  EXPECT_EQ(OutcomeOf(*other, seen.id), "succeeded") << "the result is kept for others";
}

// A client that subscribes to no feedback, and one that comes later.
TEST_P(ActionLoss, DropsFeedbackThatHasNoSubscriber) {
  const auto send_goal =
      Must(transport::MakeClient<Fibonacci::SendGoal>(*here_, name_ + "/_action/send_goal"));
  bool accepted = false;
  send_goal->Call({{{7}}, {5}}, kLong,
                  [&](const auto& reply) { accepted = reply.value().accepted; });
  ASSERT_TRUE(RunUntil([&] { return accepted && !server_->started.empty(); }));
  for (std::int32_t i = 0; i < 1000; ++i) {
    ASSERT_TRUE(server_->started[0].PublishFeedback({{i}})) << "no failure of the server";
  }
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Start(*client, seen);
  ASSERT_TRUE(server_->started[1].PublishFeedback({{7}}));
  ASSERT_TRUE(RunUntil([&] { return !seen.feedbacks.empty(); }));
  EXPECT_THAT(seen.feedbacks, ElementsAre(Numbers{7})) << "of its own goal alone";
  EXPECT_TRUE(server_->started[0].Succeed({{2}}));
}

TEST_P(ActionLoss, LetsACallbackDropItsClientAndAHandlerItsServer) {
  auto client = MakeClient(*here_);
  SeenGoal seen;
  GoalEvents<Fibonacci> events;
  bool accepted = false;
  events.on_accepted = [&] {
    client.reset();
    accepted = true;
  };
  events.on_feedback = [](const auto&) { ADD_FAILURE() << "after the client was dropped"; };
  client->SendGoal({5}, kLong, events);
  ASSERT_TRUE(RunUntil([&] { return accepted; }));

  const std::string name = name_ + "_brief";
  std::unique_ptr<ActionServer<Fibonacci>> brief;
  ActionHandlers<Fibonacci> handlers;
  std::optional<FibonacciGoal> kept;
  handlers.start = [&](FibonacciGoal goal) {
    brief.reset();
    kept = std::move(goal);
  };
  brief = Must(MakeActionServer<Fibonacci>(*there_, name, handlers));
  ActionClientOptions options;
  options.lost_after = Milliseconds(100);
  const auto next = Must(MakeActionClient<Fibonacci>(*here_, name, options));
  next->SendGoal({5}, Milliseconds(2000), seen.Events());
  ASSERT_TRUE(RunUntil([&] { return kept.has_value(); }));
  EXPECT_FALSE(kept->Succeed({})) << "the server is dropped";
  EXPECT_EQ(kept->state(), GoalState::kUnknown);
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "lost");
}

TEST_P(ActionLoss, LetsTheEndOfAGoalDropItsClient) {
  auto client = MakeClient(*here_);
  SeenGoal other;
  GoalEvents<Fibonacci> events;
  events.on_end = [&](const auto&) { client.reset(); };
  client->SendGoal({5}, kLong, events);
  Start(*client, other);
  ASSERT_TRUE(RunUntil([&] { return server_->started.size() == 2; }));
  for (FibonacciGoal& goal : server_->started) {
    if (goal.id() != other.id) goal.Succeed({});
  }
  ASSERT_TRUE(RunUntil([&] { return client == nullptr; }));
  EXPECT_FALSE(other.ended());
}

// A robot and a desk whose connection fails.
class PartitionedAction : public ::testing::Test {
 protected:
  PartitionedAction() {
    network_.SetLease(Milliseconds(1000));
    ActionClientOptions options;
    options.lost_after = std::chrono::seconds(5);
    client_ = Must(MakeActionClient<Fibonacci>(*desk_, "fibonacci", options));
    client_->SendGoal({5}, kLong, seen_.Events());
    EXPECT_TRUE(RunUntil([this] { return seen_.accepted(); }));
  }
  bool RunUntil(const std::function<bool()>& done) {
    return network_.RunUntil(done, network_.now() + std::chrono::seconds(60));
  }
  FibonacciGoal& goal() { return server_->started[0]; }

  sim::Network network_{1};
  const std::unique_ptr<Node> dog_ = network_.MakeNode("dog"), desk_ = network_.MakeNode("desk");
  const std::unique_ptr<FibonacciServer> server_ = FibonacciServer::Make(*dog_, "fibonacci");
  std::unique_ptr<ActionClient<Fibonacci>> client_;
  SeenGoal seen_;
};

TEST_F(PartitionedAction, GetsTheResultAfterAnInterruptionThatIsShort) {
  network_.Partition("dog", "desk");
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(client_->Servers(), IsEmpty());
  goal().Succeed({{4}});
  network_.RunFor(std::chrono::seconds(2));
  network_.Heal("dog", "desk");
  ASSERT_TRUE(RunUntil([&] { return seen_.ended(); }));
  EXPECT_EQ(seen_.End(), "succeeded");
  EXPECT_EQ(seen_.outcome->result.sequence, Numbers{4});
}

TEST_F(PartitionedAction, LosesTheGoalAfterALongInterruptionAndTheServerGoesOn) {
  network_.Partition("dog", "desk");
  ASSERT_TRUE(RunUntil([&] { return seen_.ended(); }));
  EXPECT_EQ(seen_.End(), "lost");
  EXPECT_TRUE(goal().Execute());
}

// The server loses the client and drops the reply, while the client sees no loss.
TEST_F(PartitionedAction, GetsTheResultWhenOnlyTheServerLostTheConnection) {
  network_.Block("desk", "dog");
  network_.RunFor(std::chrono::seconds(2));
  goal().Succeed({{4}});
  network_.RunFor(std::chrono::seconds(7));  // longer than a reply is held
  network_.Free("desk", "dog");
  ASSERT_TRUE(RunUntil([&] { return seen_.ended(); }));
  EXPECT_EQ(seen_.End(), "succeeded");
}

// The reply to a client whose reader is not discovered is held.
class HeldAction : public PartitionedAction {
 protected:
  static constexpr GoalId kGoal{7};

  HeldAction() {
    RunUntil([this] { return requests_->MatchedReaders() == 1; });
    Fibonacci::SendGoal::Request request{{kGoal}, {5}};
    EXPECT_TRUE(requests_->Write(internal::EncodeEnvelope(msg::RequestId{1, 1}, request)));
    EXPECT_TRUE(RunUntil([this] { return server_->offered == 2; }));
  }
  const std::unique_ptr<Node> phone_ = network_.MakeNode("phone");
  const std::unique_ptr<RawWriter> requests_ =
      Must(phone_->MakeRawWriter("rq/fibonacci/_action/send_goalRequest",
                                 std::string(Fibonacci::SendGoal::kTypeName) + "Request_", {}, {}));
};

TEST_F(HeldAction, StartsAGoalAfterTheReplyThatAcceptsIt) {
  EXPECT_THAT(server_->started, SizeIs(1));
  network_.RunFor(std::chrono::seconds(6));  // the reply is dropped
  ASSERT_THAT(server_->started, SizeIs(2));
  EXPECT_EQ(server_->started[1].id(), kGoal);
}

TEST_F(HeldAction, EndsAGoalThatIsCancelledBeforeItsStart) {
  std::string end;
  client_->GetOutcome(kGoal, kLong,
                      [&](const auto& outcome) { end = GoalEndName(outcome.value().end); });
  client_->Cancel(kGoal, kLong, [](const auto& reply) {
    EXPECT_EQ(reply.value().return_code, msg::CancelGoal::kErrorNone);
  });
  ASSERT_TRUE(RunUntil([&] { return !end.empty(); }));
  EXPECT_EQ(end, "canceled");
  EXPECT_THAT(server_->canceling, IsEmpty());
  network_.RunFor(std::chrono::seconds(6));
  EXPECT_THAT(server_->started, SizeIs(1)) << "it is not started any more";
}

// Its result was empty: a person who had sent a skill read "cancelled:".
TEST(AnActionWithATextInItsResult, SaysThatAGoalWasCancelledBeforeItsStart) {
  using Skill = msg::SkillExecution;
  constexpr GoalId kGoal{7};
  sim::Network network(1);
  const auto robot = network.MakeNode("dog"), desk = network.MakeNode("desk"),
             phone = network.MakeNode("phone");
  int started = 0;
  ActionHandlers<Skill> handlers;
  handlers.start = [&](const ServerGoal<Skill>&) { ++started; };
  handlers.cancel = [](ServerGoal<Skill> goal) { goal.Canceled({}); };
  const auto server = Must(MakeActionServer<Skill>(*robot, "skill", handlers));
  const auto client = Must(MakeActionClient<Skill>(*desk, "skill"));
  // The reply to a client without a reader is held, and the goal is not started before it is sent.
  const auto requests =
      Must(phone->MakeRawWriter("rq/skill/_action/send_goalRequest",
                                std::string(Skill::SendGoal::kTypeName) + "Request_", {}, {}));
  network.RunFor(std::chrono::seconds(1));
  Skill::SendGoal::Request request;
  request.goal_id.uuid = kGoal;
  EXPECT_TRUE(requests->Write(internal::EncodeEnvelope(msg::RequestId{1, 1}, request)));
  network.RunFor(Milliseconds(500));
  std::string end;
  client->Cancel(kGoal, kLong, [](const auto&) {});
  client->GetOutcome(kGoal, kLong, [&](const Result<GoalOutcome<Skill>>& outcome) {
    ASSERT_TRUE(outcome) << outcome.error().message;
    end = std::string(GoalEndName(outcome.value().end)) + ": " + outcome.value().result.message;
  });
  network.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(end, "canceled: cancelled before it started");
  EXPECT_EQ(started, 0);
}

TEST_F(PartitionedAction, ForgetsTheCallersOfResultsThatAreLost) {
  for (int i = 0; i < 50; ++i) {
    const auto desk = network_.MakeNode("desk");
    const auto client = Must(MakeActionClient<Fibonacci>(*desk, "fibonacci"));
    const std::size_t before = server_->server->waiting();
    client->GetOutcome(goal().id(), kLong, [](const auto&) {});
    ASSERT_TRUE(RunUntil([&] { return server_->server->waiting() != before; }));
    network_.Crash(*desk);
    network_.RunFor(std::chrono::seconds(2));
  }
  EXPECT_LE(server_->server->waiting(), 33U);
  goal().Succeed({});
  ASSERT_TRUE(RunUntil([&] { return seen_.ended(); }));
  EXPECT_EQ(seen_.End(), "succeeded") << "a caller that is connected is not forgotten";
}

}  // namespace musher::transport::action_loss_test
