// Actions, on every transport.

#include "musher/transport/action.hpp"

#include <gmock/gmock.h>

#include <list>
#include <set>

#include "musher/test/contract/action_harness.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::transport::action_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using Numbers = std::vector<std::int32_t>;

class Action : public ActionContract {
 protected:
  const std::unique_ptr<Node> here_ = MakeNode(), there_ = MakeNode();
  const std::unique_ptr<FibonacciServer> server_ = FibonacciServer::Make(*there_, name_);
  std::vector<FibonacciGoal>& started_ = server_->started;
};
MUSHER_ON_EVERY_TRANSPORT(Action);

TEST_P(Action, RunsAGoalToItsResultWithFeedback) {
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Start(*client, seen);
  ASSERT_THAT(started_, SizeIs(1));
  FibonacciGoal& goal = started_[0];
  EXPECT_EQ(goal.goal().order, 5);
  EXPECT_EQ(goal.id(), seen.id);
  EXPECT_EQ(goal.state(), GoalState::kAccepted);
  ASSERT_TRUE(goal.Execute());
  ASSERT_TRUE(goal.PublishFeedback({{0, 1}}));
  ASSERT_TRUE(goal.PublishFeedback({{0, 1, 1}}));
  ASSERT_TRUE(RunUntil([&] { return seen.feedbacks.size() == 2 && seen.log.size() == 2; }));
  ASSERT_TRUE(goal.Succeed({{0, 1, 1, 2, 3}}));
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_THAT(seen.log, ElementsAre("accepted", "executing"));
  EXPECT_THAT(seen.feedbacks, ElementsAre(Numbers{0, 1}, Numbers{0, 1, 1}));
  EXPECT_EQ(seen.End(), "succeeded");
  EXPECT_EQ(seen.outcome->result.sequence, (Numbers{0, 1, 1, 2, 3}));
  EXPECT_EQ(client->goals(), 0U);
}

TEST_P(Action, KnowsTheIdOfAGoalBeforeItIsSent) {
  const auto client = MakeClient(*here_);
  std::list<SeenGoal> goals(2);
  for (SeenGoal& seen : goals) {
    const GoalId next = client->NextGoalId();
    EXPECT_EQ(client->NextGoalId(), next);
    Start(*client, seen);
    EXPECT_EQ(seen.id, next);
  }
}

TEST_P(Action, DeliversTheFirstFeedbackOfAGoalThatIsSentBeforeTheServerExists) {
  const auto client = Must(MakeActionClient<Fibonacci>(*here_, name_ + "_later"));
  SeenGoal seen;
  Send(*client, seen);
  EXPECT_FALSE(client->Ready());
  ActionHandlers<Fibonacci> handlers;
  handlers.start = [](FibonacciGoal goal) {
    goal.PublishFeedback({{0}});
    goal.Succeed({{0}});
  };
  const auto server = Must(MakeActionServer<Fibonacci>(*there_, name_ + "_later", handlers));
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "succeeded");
  EXPECT_TRUE(RunUntil([&] { return client->Ready(); }));
}

TEST_P(Action, StartsNothingForAGoalThatIsRejected) {
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Send(*client, seen, -1);
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "rejected");
  EXPECT_THAT(seen.outcome->reason, HasSubstr(name_ + ": the server rejects the goal"));
  EXPECT_THAT(seen.log, IsEmpty());
  EXPECT_THAT(started_, IsEmpty());
  EXPECT_EQ(server_->server->goals(), 0U);
  EXPECT_EQ(OutcomeOf(*client, seen.id), "lost") << "the server does not know it";
}

TEST_P(Action, EndsAGoalAsAborted) {
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Start(*client, seen);
  ASSERT_TRUE(started_[0].Abort({{7}})) << "it is executed first";
  EXPECT_EQ(started_[0].state(), GoalState::kAborted);
  EXPECT_FALSE(started_[0].Succeed({}));
  EXPECT_FALSE(started_[0].PublishFeedback({}));
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "aborted");
  EXPECT_EQ(seen.outcome->result.sequence, Numbers{7});
}

TEST_P(Action, AbortsAGoalWhoseHandlesAreDropped) {
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Start(*client, seen);
  started_.clear();
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "aborted");
}

TEST_P(Action, CancelsAGoal) {
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Start(*client, seen);
  started_[0].Execute();
  EXPECT_FALSE(started_[0].Canceled({})) << "without a request";
  const auto reply = Cancel(*client, seen.id);
  EXPECT_EQ(reply.return_code, msg::CancelGoal::kErrorNone);
  ASSERT_THAT(reply.goals_canceling, SizeIs(1));
  EXPECT_EQ(reply.goals_canceling[0].goal_id.uuid, seen.id);
  ASSERT_THAT(server_->canceling, SizeIs(1));
  ASSERT_TRUE(RunUntil([&] { return seen.log.back() == "canceling"; }));
  EXPECT_FALSE(seen.ended()) << "until the server has stopped the work";
  ASSERT_TRUE(server_->canceling[0].Canceled({{1}}));
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "canceled");
  EXPECT_EQ(seen.outcome->result.sequence, Numbers{1});
}

TEST_P(Action, LetsAGoalSucceedWhileItIsCanceling) {
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Start(*client, seen);
  Cancel(*client, seen.id);
  EXPECT_TRUE(started_[0].Succeed({}));
  ASSERT_TRUE(RunUntilEnded(seen));
  EXPECT_EQ(seen.End(), "succeeded");
}

TEST_P(Action, AnswersWhyNoGoalIsCancelled) {
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Start(*client, seen);
  server_->cancels = false;
  EXPECT_EQ(Cancel(*client, seen.id).return_code, msg::CancelGoal::kErrorRejected);
  EXPECT_EQ(started_[0].state(), GoalState::kAccepted);
  EXPECT_THAT(server_->canceling, IsEmpty());
  started_[0].Succeed({});
  EXPECT_EQ(Cancel(*client, seen.id).return_code, msg::CancelGoal::kErrorGoalTerminated);
  EXPECT_EQ(Cancel(*client, GoalId{1, 2}).return_code, msg::CancelGoal::kErrorUnknownGoalId);
}

TEST_P(Action, RejectsACancelRequestWithoutAHandlerForIt) {
  ActionHandlers<Fibonacci> handlers;
  std::optional<FibonacciGoal> goal;
  handlers.start = [&](FibonacciGoal started) { goal = std::move(started); };
  const auto server = Must(MakeActionServer<Fibonacci>(*there_, name_ + "_bare", handlers));
  const auto client = Must(MakeActionClient<Fibonacci>(*here_, name_ + "_bare"));
  SeenGoal seen;
  Start(*client, seen);
  EXPECT_EQ(Cancel(*client, seen.id).return_code, msg::CancelGoal::kErrorRejected);
}

TEST_P(Action, AcceptsARepeatedCancelRequest) {
  const auto client = MakeClient(*here_);
  SeenGoal seen;
  Start(*client, seen);
  Cancel(*client, seen.id);
  const auto again = Cancel(*client, seen.id);
  EXPECT_EQ(again.return_code, msg::CancelGoal::kErrorNone);
  EXPECT_THAT(again.goals_canceling, SizeIs(1));
  EXPECT_THAT(server_->canceling, SizeIs(1)) << "the handler runs once";
}

TEST_P(Action, CancelsAllGoalsOfAllClients) {
  const auto one = MakeClient(*here_), two = MakeClient(*there_);
  SeenGoal first, second;
  Start(*one, first);
  Start(*two, second);
  const auto reply =
      CancelReply([&](auto on_reply) { one->CancelAll(kLong, std::move(on_reply)); });
  EXPECT_THAT(reply.goals_canceling, SizeIs(2));
  for (FibonacciGoal& goal : server_->canceling) goal.Canceled({});
  ASSERT_TRUE(RunUntil([&] { return first.ended() && second.ended(); }));
  EXPECT_EQ(first.End(), "canceled");
  EXPECT_EQ(second.End(), "canceled");
}

TEST_P(Action, CancelsTheGoalsThatWereAcceptedUpToATime) {
  int second = 0;
  ActionServerOptions options;
  options.stamp = [&second] { return msg::Stamp{++second, 0}; };
  const std::string name = name_ + "_stamped";
  const auto server = FibonacciServer::Make(*there_, name, options);
  const auto client = Must(MakeActionClient<Fibonacci>(*here_, name));
  std::list<SeenGoal> goals(3);
  for (SeenGoal& goal : goals) Start(*client, goal);
  const auto reply = CancelReply([&](auto on_reply) {
    client->CancelUntil({2, 0}, kLong, std::move(on_reply));
  });
  ASSERT_THAT(reply.goals_canceling, SizeIs(2));
  EXPECT_EQ(reply.goals_canceling[1].goal_id.uuid, std::next(goals.begin())->id);
  EXPECT_EQ(server->started[2].state(), GoalState::kAccepted);
}

TEST_P(Action, GivesTheResultToEveryCallerBeforeAndAfterTheEnd) {
  const auto one = MakeClient(*here_), two = MakeClient(*there_);
  SeenGoal seen;
  Start(*one, seen);
  std::vector<std::string> ends;
  const auto note = [&ends](const Result<GoalOutcome<Fibonacci>>& outcome) {
    ends.emplace_back(GoalEndName(outcome.value().end));
  };
  one->GetOutcome(seen.id, kLong, note);
  two->GetOutcome(seen.id, kLong, note);
  two->GetOutcome(seen.id, kLong, note);
  ASSERT_TRUE(RunUntil([&] { return server_->server->waiting() == 4; }));
  started_[0].Succeed({{3}});
  ASSERT_TRUE(RunUntil([&] { return ends.size() == 3 && seen.ended(); }));
  EXPECT_THAT(ends, ElementsAre("succeeded", "succeeded", "succeeded"));
  EXPECT_EQ(server_->server->waiting(), 0U);
  EXPECT_EQ(OutcomeOf(*two, seen.id), "succeeded") << "after the end";
}

TEST_P(Action, AnswersThatItDoesNotKnowAGoal) {
  const auto client = MakeClient(*here_);
  EXPECT_EQ(OutcomeOf(*client, GoalId{9}), "lost");
}

TEST_P(Action, ForgetsAResultThatHasExpired) {
  ActionServerOptions options;
  options.results.timeout = Milliseconds(50);
  const std::string name = name_ + "_short";
  const auto server = FibonacciServer::Make(*there_, name, options);
  const auto client = Must(MakeActionClient<Fibonacci>(*here_, name));
  SeenGoal seen;
  Start(*client, seen);
  server->started[0].Succeed({});
  ASSERT_TRUE(RunUntilEnded(seen));
  ASSERT_TRUE(RunUntil([&] { return server->server->goals() == 0; }));
  EXPECT_EQ(seen.End(), "succeeded");
  EXPECT_EQ(OutcomeOf(*client, seen.id), "lost");
  EXPECT_EQ(server->started[0].state(), GoalState::kSucceeded) << "the handle knows it";
}

TEST_P(Action, RunsManyGoalsAtOnce) {
  const auto one = MakeClient(*here_), two = MakeClient(*here_);
  std::list<SeenGoal> goals(60);
  int order = 0;
  for (SeenGoal& goal : goals) {
    Send(order % 2 == 0 ? *one : *two, goal, order);
    ++order;
  }
  ASSERT_TRUE(RunUntil([&] { return started_.size() == goals.size(); }));
  for (auto goal = started_.rbegin(); goal != started_.rend(); ++goal) {
    goal->Succeed({{goal->goal().order}});
  }
  ASSERT_TRUE(RunUntil(
      [&] { return std::ranges::all_of(goals, [](const auto& goal) { return goal.ended(); }); }));
  order = 0;
  std::set<GoalId> ids;
  for (const SeenGoal& goal : goals) {
    EXPECT_EQ(goal.outcome->result.sequence, Numbers{order++});
    ids.insert(goal.id);
  }
  EXPECT_THAT(ids, SizeIs(60));
}

TEST_P(Action, RejectsAGoalWithAnIdThatIsInUse) {
  const auto raw = Must(
      transport::MakeClient<Fibonacci::SendGoal>(*here_, name_ + "/_action/send_goal", nullptr));
  std::vector<bool> accepted;
  const Fibonacci::SendGoal::Request request{{GoalId{4}}, {5}};
  for (int i = 0; i < 2; ++i) {
    raw->Call(request, kLong,
              [&](const auto& reply) { accepted.push_back(reply.value().accepted); });
  }
  ASSERT_TRUE(RunUntil([&] { return accepted.size() == 2; }));
  EXPECT_THAT(accepted, ElementsAre(true, false));
  EXPECT_EQ(server_->offered, 1);
}

// A cancellation is on a topic of its own, and may overtake its goal.
TEST_P(Action, RejectsAGoalThatWasCancelledBeforeItCame) {
  const auto client = MakeClient(*here_);
  const auto raw = Must(
      transport::MakeClient<Fibonacci::SendGoal>(*here_, name_ + "/_action/send_goal", nullptr));
  EXPECT_EQ(Cancel(*client, GoalId{4}).return_code, msg::CancelGoal::kErrorUnknownGoalId);
  std::vector<bool> accepted;
  for (const GoalId& id : {GoalId{4}, GoalId{4}, GoalId{5}}) {
    raw->Call({{id}, {5}}, kLong,
              [&](const auto& reply) { accepted.push_back(reply.value().accepted); });
  }
  ASSERT_TRUE(RunUntil([&] { return accepted.size() == 3; }));
  EXPECT_THAT(accepted, ElementsAre(false, false, true));
  EXPECT_EQ(server_->offered, 1);
}

TEST_P(Action, PublishesTheStatusOfAllGoalsAlsoForLaterReaders) {
  const auto client = MakeClient(*here_);
  SeenGoal first, second;
  Start(*client, first);
  Start(*client, second);
  started_[0].Succeed({});
  started_[1].Execute();
  std::vector<std::int8_t> last;
  const auto status = Must(MakeSubscription<msg::GoalStatusArray>(
      *here_, name_ + "/_action/status",
      [&](const msg::GoalStatusArray& array, const SampleInfo&) {
        last.clear();
        for (const msg::GoalStatus& each : array.status_list) last.push_back(each.status);
      },
      kLatchedQos));
  ASSERT_TRUE(RunUntil([&] { return !last.empty(); }));
  EXPECT_THAT(last,
              ElementsAre(msg::GoalStatus::kStatusSucceeded, msg::GoalStatus::kStatusExecuting));
}

TEST_P(Action, CountsRequestsThatDoNotDecode) {
  const std::string type(Fibonacci::SendGoal::kTypeName);
  const auto writer = Must(
      here_->MakeRawWriter("rq/" + name_ + "/_action/send_goalRequest", type + "Request_", {}, {}));
  ASSERT_TRUE(RunUntil([&] { return writer->MatchedReaders() == 1; }));
  const msg::Bytes no_goal = msg::Encode(internal::GoalRequest{{1, 1}, {GoalId{1}}});
  ASSERT_TRUE(writer->Write(msg::Encode(msg::RequestId{1, 1})));
  ASSERT_TRUE(writer->Write(no_goal));
  ASSERT_TRUE(RunUntil([&] { return server_->server->malformed() == 2; }));
  EXPECT_EQ(server_->offered, 0);
}

// The example of docs/ros2.md.
TEST_P(Action, IsOpenedByEndpoints) {
  Endpoints endpoints(*there_, name_);
  Numbers numbers;
  std::string end;
  // [server]
  ActionHandlers<msg::Fibonacci> handlers;
  handlers.accept = [](const msg::Fibonacci::Goal& goal, ParticipantId) { return goal.order >= 0; };
  handlers.start = [](ServerGoal<msg::Fibonacci> goal) {
    goal.Execute();
    goal.PublishFeedback({{0, 1}});
    goal.Succeed({{0, 1, 1, 2}});  // or later: the handle is kept until the end
  };
  endpoints.ServeAction<msg::Fibonacci>("fibonacci", handlers);
  // [server end]
  // [client]
  auto* client = endpoints.OpenActionClient<msg::Fibonacci>("fibonacci");
  GoalEvents<msg::Fibonacci> events;
  events.on_feedback = [&](const msg::Fibonacci::Feedback& feedback) {
    numbers = feedback.sequence;
  };
  events.on_end = [&](const GoalOutcome<msg::Fibonacci>& outcome) {
    end = GoalEndName(outcome.end);  // a rejected or lost goal has outcome.reason
    numbers = outcome.result.sequence;
  };
  client->SendGoal({4}, Milliseconds(5000), events);
  // [client end]
  ASSERT_TRUE(endpoints.opened());
  ASSERT_TRUE(RunUntil([&] { return !end.empty(); }));
  EXPECT_EQ(end, "succeeded");
  EXPECT_EQ(numbers, (Numbers{0, 1, 1, 2}));
}

}  // namespace musher::transport::action_test
