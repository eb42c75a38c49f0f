// Request and reply, on every transport.

#include <gmock/gmock.h>

#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/contract/world.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport::service_test {

using msg::SetState;
using Answer = std::optional<Result<SetState::Response>>;

constexpr Duration kLong = std::chrono::seconds(15);

// Returns the target of the request as the outcome.
SetState::Response Echo(const SetState::Request& request) {
  SetState::Response response;
  response.outcome = request.target;
  return response;
}

SetState::Request RequestFor(const std::string& target) {
  return {target, ""};
}

class Service : public Contract {
 protected:
  std::unique_ptr<Server<SetState>> MakeEcho(Node& node, const std::string& service) {
    return Must(MakeServer<SetState>(node, service,
                                     [this](const SetState::Request& request, const auto& reply) {
                                       ++served_;
                                       reply(Echo(request));
                                     }));
  }

  static void Call(Client<SetState>& client, const std::string& target, Answer& answer,
                   Duration timeout = kLong) {
    client.Call(RequestFor(target), timeout, [&answer](Result<SetState::Response> response) {
      EXPECT_FALSE(answer) << "a call must end once";
      answer.emplace(std::move(response));
    });
  }

  static std::string Outcome(const Answer& answer) {
    if (!answer) return "(no answer)";
    return *answer ? answer->value().outcome : answer->error().message;
  }

  int served_ = 0;
};
MUSHER_ON_EVERY_TRANSPORT(Service);

TEST_P(Service, AnswersACall) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("set_state");
  const auto server = MakeEcho(*there, name);
  const auto client = Must(MakeClient<SetState>(*here, name));
  ASSERT_TRUE(RunUntil([&] { return client->Ready(); }));
  Answer answer;
  Call(*client, "Active", answer);
  EXPECT_FALSE(answer) << "callbacks must not run inside Call()";
  ASSERT_TRUE(RunUntil([&] { return answer.has_value(); }));
  EXPECT_EQ(Outcome(answer), "Active");
}

TEST_P(Service, AnswersACallFromTheSameNode) {
  const auto node = MakeNode();
  const std::string name = Unique("set_state");
  const auto server = MakeEcho(*node, name);
  const auto client = Must(MakeClient<SetState>(*node, name));
  Answer answer;
  Call(*client, "Active", answer);
  ASSERT_TRUE(RunUntil([&] { return answer.has_value(); }));
  EXPECT_EQ(Outcome(answer), "Active");
}

TEST_P(Service, AnswersACallThatWasMadeBeforeTheServerExisted) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("set_state");
  const auto client = Must(MakeClient<SetState>(*here, name));
  Answer first, second;
  Call(*client, "first", first);
  Call(*client, "second", second);
  EXPECT_FALSE(client->Ready());
  const auto server = MakeEcho(*there, name);
  ASSERT_TRUE(RunUntil([&] { return first && second; }));
  EXPECT_EQ(Outcome(first), "first");
  EXPECT_EQ(Outcome(second), "second");
}

TEST_P(Service, LetsTheServerAnswerLaterAndInAnotherOrder) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("set_state");
  std::vector<std::pair<SetState::Request, Server<SetState>::Reply>> open;
  const auto server = Must(MakeServer<SetState>(
      *there, name, [&](const SetState::Request& request, Server<SetState>::Reply reply) {
        open.emplace_back(request, std::move(reply));
      }));
  const auto client = Must(MakeClient<SetState>(*here, name));
  Answer first, second;
  Call(*client, "first", first);
  Call(*client, "second", second);
  ASSERT_TRUE(RunUntil([&] { return open.size() == 2; }));
  open[1].second(Echo(open[1].first));
  open[1].second(Echo(open[0].first));  // a second answer does nothing
  ASSERT_TRUE(RunUntil([&] { return second.has_value(); }));
  EXPECT_FALSE(first);
  open[0].second(Echo(open[0].first));
  ASSERT_TRUE(RunUntil([&] { return first.has_value(); }));
  EXPECT_EQ(Outcome(first), "first");
  EXPECT_EQ(Outcome(second), "second");
}

TEST_P(Service, EndsACallInTimeWhenThereIsNoServer) {
  const auto here = MakeNode();
  const auto client = Must(MakeClient<SetState>(*here, Unique("set_state")));
  Answer answer;
  const Time called = loop().Now();
  Call(*client, "Active", answer, Milliseconds(50));
  ASSERT_TRUE(RunUntil([&] { return answer.has_value(); }));
  ASSERT_FALSE(*answer);
  EXPECT_EQ(answer->error().code, kCodeTimeout);
  EXPECT_GE(loop().Now() - called, Milliseconds(50));
}

TEST_P(Service, EndsACallInTimeWhenTheServerIsSilent) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("set_state");
  Server<SetState>::Reply late;
  const auto server = Must(MakeServer<SetState>(
      *there, name, [&](const SetState::Request&, auto reply) { late = std::move(reply); }));
  const auto client = Must(MakeClient<SetState>(*here, name));
  ASSERT_TRUE(RunUntil([&] { return client->Ready(); }));
  Answer answer, next;
  Call(*client, "Active", answer, Milliseconds(100));
  ASSERT_TRUE(RunUntil([&] { return answer.has_value(); }));
  ASSERT_FALSE(*answer);
  EXPECT_EQ(answer->error().code, kCodeTimeout);

  late(Echo(RequestFor("too late")));  // must not be taken for the answer to the next call
  Call(*client, "next", next);
  late = nullptr;
  ASSERT_TRUE(RunUntil([&] { return late != nullptr; }));
  late(Echo(RequestFor("next")));
  ASSERT_TRUE(RunUntil([&] { return next.has_value(); }));
  EXPECT_EQ(Outcome(next), "next");
}

TEST_P(Service, EndsACallInTimeWhenTheServerCrashes) {
  const auto here = MakeNode();
  auto there = MakeNode();
  const std::string name = Unique("set_state");
  bool called = false;
  auto server = Must(MakeServer<SetState>(
      *there, name, [&](const SetState::Request&, const auto&) { called = true; }));
  const auto client = Must(MakeClient<SetState>(*here, name));
  Answer answer;
  Call(*client, "Active", answer, Milliseconds(2000));
  ASSERT_TRUE(RunUntil([&] { return called; }));
  server.reset();
  there.reset();
  ASSERT_TRUE(RunUntil([&] { return !client->Ready(); }));
  ASSERT_TRUE(RunUntil([&] { return answer.has_value(); }));
  ASSERT_FALSE(*answer);
  EXPECT_EQ(answer->error().code, kCodeTimeout);
}

TEST_P(Service, FindsTheServerThatReplacesACrashedServer) {
  const auto here = MakeNode();
  auto there = MakeNode();
  const std::string name = Unique("set_state");
  auto server = MakeEcho(*there, name);
  const auto client = Must(MakeClient<SetState>(*here, name));
  ASSERT_TRUE(RunUntil([&] { return client->Ready(); }));
  server.reset();
  there.reset();
  ASSERT_TRUE(RunUntil([&] { return !client->Ready(); }));
  Answer answer;
  Call(*client, "again", answer);
  there = MakeNode();
  server = MakeEcho(*there, name);
  ASSERT_TRUE(RunUntil([&] { return answer.has_value(); }));
  EXPECT_EQ(Outcome(answer), "again");
}

TEST_P(Service, GivesEachOfTwoClientsItsOwnReplies) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("set_state");
  const auto server = MakeEcho(*there, name);
  const auto one = Must(MakeClient<SetState>(*here, name));
  const auto two = Must(MakeClient<SetState>(*here, name));  // the same sequence numbers
  const auto three = Must(MakeClient<SetState>(*there, name));
  std::vector<Answer> answers(15);
  for (std::size_t i = 0; i < answers.size(); i += 3) {
    Call(*one, "one", answers[i]);
    Call(*two, "two", answers[i + 1]);
    Call(*three, "three", answers[i + 2]);
  }
  ASSERT_TRUE(RunUntil([&] {
    return std::all_of(answers.begin(), answers.end(), [](const auto& a) { return a.has_value(); });
  }));
  for (std::size_t i = 0; i < answers.size(); i += 3) {
    EXPECT_EQ(Outcome(answers[i]), "one");
    EXPECT_EQ(Outcome(answers[i + 1]), "two");
    EXPECT_EQ(Outcome(answers[i + 2]), "three");
  }
  EXPECT_EQ(served_, 15);
}

TEST_P(Service, KeepsTwoServersOfANodeApart) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("motion");
  const auto set_state = MakeEcho(*there, name + "/set_state");
  const auto trigger =
      Must(MakeServer<msg::Trigger>(*there, name + "/trigger", [](const auto&, const auto& reply) {
        reply({true, "triggered"});
      }));
  const auto set_state_client = Must(MakeClient<SetState>(*here, name + "/set_state"));
  const auto trigger_client = Must(MakeClient<msg::Trigger>(*here, name + "/trigger"));
  Answer answer;
  std::string triggered;
  Call(*set_state_client, "Active", answer);
  trigger_client->Call({}, kLong,
                       [&](const auto& response) { triggered = response.value().message; });
  ASSERT_TRUE(RunUntil([&] { return answer && !triggered.empty(); }));
  EXPECT_EQ(Outcome(answer), "Active");
  EXPECT_EQ(triggered, "triggered");
}

TEST_P(Service, AnswersManyCallsThatCameAtOnce) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("set_state");
  const auto server = MakeEcho(*there, name);
  std::vector<std::unique_ptr<Client<SetState>>> clients;
  std::vector<Answer> answers(30);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    clients.push_back(Must(MakeClient<SetState>(*here, name)));
    Call(*clients.back(), std::to_string(i), answers[i]);
  }
  ASSERT_TRUE(RunUntil([&] {
    return std::all_of(answers.begin(), answers.end(), [](const auto& a) { return a.has_value(); });
  }));
  for (std::size_t i = 0; i < answers.size(); ++i)
    EXPECT_EQ(Outcome(answers[i]), std::to_string(i));
}

TEST_P(Service, DropsAndCountsAMalformedRequest) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("set_state");
  const auto server = MakeEcho(*there, name);
  const auto writer = Must(here->MakeRawWriter(
      "rq/" + name + "Request", std::string(SetState::kTypeName) + "Request_", {}, {}));
  ASSERT_TRUE(RunUntil([&] { return writer->MatchedReaders() == 1; }));
  const msg::Bytes no_id = msg::Encode(msg::Empty{});
  const msg::Bytes no_body = msg::Encode(msg::RequestId{1, 1});
  ASSERT_TRUE(writer->Write(no_id));
  ASSERT_TRUE(writer->Write(no_body));
  ASSERT_TRUE(RunUntil([&] { return server->malformed() == 2; }));
  EXPECT_EQ(served_, 0);
}

TEST_P(Service, LetsAReplyDropItsClientAndAHandlerItsServer) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string name = Unique("set_state");
  std::unique_ptr<Server<SetState>> server;
  server = Must(MakeServer<SetState>(
      *there, name, [&](const SetState::Request& request, Server<SetState>::Reply reply) {
        if (request.target == "stop") {
          server.reset();
          reply(Echo(request));  // does nothing: the server is dropped
        } else {
          reply(Echo(request));
        }
      }));
  auto client = Must(MakeClient<SetState>(*here, name));
  bool answered = false;
  client->Call(RequestFor("go"), kLong, [&](const auto& response) {
    answered = response.ok();
    client.reset();
  });
  ASSERT_TRUE(RunUntil([&] { return answered; }));
  EXPECT_EQ(client, nullptr);
  client = Must(MakeClient<SetState>(*here, name));
  client->Call(RequestFor("stop"), kLong, [](const auto&) {});
  ASSERT_TRUE(RunUntil([&] { return server == nullptr; }));
}

TEST_P(Service, EndsNoCallOfADroppedClient) {
  const auto here = MakeNode();
  auto client = Must(MakeClient<SetState>(*here, Unique("set_state")));
  bool ended = false, later = false;
  client->Call(RequestFor("Active"), Milliseconds(20), [&](const auto&) { ended = true; });
  client.reset();
  const auto timer = loop().At(loop().Now() + Milliseconds(40), [&] { later = true; });
  ASSERT_TRUE(RunUntil([&] { return later; }));
  EXPECT_FALSE(ended);
}

}  // namespace musher::transport::service_test
