// Actions between Musher and plain C programs that have nothing but idlc's structs.

#include <gmock/gmock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "musher/base/unique_fd.hpp"
#include "musher/test/contract/action_harness.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::transport::action_peer_test {

using ::testing::ElementsAre;

using Numbers = std::vector<std::int32_t>;

class ActionPeer : public ::testing::Test {
 protected:
  ActionPeer() {
    DdsOptions options;
    options.domain_id = TestDomain();
    node_ = Must(MakeDdsNode(loop_, options));
  }
  bool RunUntil(const std::function<bool()>& done) {
    return loop_.RunUntil(done, loop_.Now() + std::chrono::seconds(120));
  }
  testing::Process Peer(const std::string& program, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {BinDir() + "/" + program, std::to_string(TestDomain()), name_});
    return testing::Process(arguments);
  }
  // Runs the loop until the program has exited; its output.
  std::string RunUntilExit(testing::Process& process) {
    const UniqueFd fd(static_cast<int>(syscall(SYS_pidfd_open, process.pid(), 0)));
    bool exited = false;
    const auto watch = loop_.WhenReadable(fd.get(), [&] { exited = true; });
    EXPECT_TRUE(RunUntil([&] { return exited; }));
    const testing::Ended ended = process.Wait();
    EXPECT_EQ(ended.exit, 0) << ended.err;
    return ended.out;
  }

  const std::string name_ = "action_peer_" + std::to_string(getpid());
  LinuxEventLoop loop_;
  std::unique_ptr<Node> node_;
};

class PlainActionClient : public ActionPeer {
 protected:
  // Computes Fibonacci numbers; an order above 20 waits for a cancellation.
  std::unique_ptr<ActionServer<Fibonacci>> MakeServer() {
    ActionHandlers<Fibonacci> handlers;
    handlers.accept = [](const Fibonacci::Goal& goal, ParticipantId) { return goal.order >= 0; };
    handlers.start = [this](FibonacciGoal goal) {
      goal.Execute();
      Numbers numbers{0};
      goal.PublishFeedback({numbers});
      if (goal.goal().order > 20) return goals_.push_back(goal);
      for (int next = 1, i = 1; i < goal.goal().order; ++i) {
        numbers.push_back(next);
        next += numbers[numbers.size() - 2];
      }
      goal.PublishFeedback({numbers});
      goal.Succeed({numbers});
    };
    handlers.cancel = [](FibonacciGoal goal) { goal.Canceled({{0}}); };
    return Must(MakeActionServer<Fibonacci>(*node_, name_, handlers));
  }
  std::vector<FibonacciGoal> goals_;
};

TEST_F(PlainActionClient, RunsAGoalOnOurServer) {
  const auto server = MakeServer();
  auto peer = Peer("action_client_peer", {"6"});
  EXPECT_EQ(RunUntilExit(peer),
            "accepted at a time\n"
            "feedback: 0\n"
            "feedback: 0 1 1 2 3 5\n"
            "result 1 of status 4: 0 1 1 2 3 5\n"
            "result 2 of status 4: 0 1 1 2 3 5\n"
            "result 3 of status 0:\n"
            "last status 4\n");
}

TEST_F(PlainActionClient, CancelsAGoalOnOurServer) {
  const auto server = MakeServer();
  auto peer = Peer("action_client_peer", {"100", "cancel"});
  EXPECT_EQ(RunUntilExit(peer),
            "accepted at a time\n"
            "feedback: 0\n"
            "cancel: code 0, 1 canceling\n"
            "result 1 of status 5: 0\n"
            "result 2 of status 5: 0\n"
            "result 3 of status 0:\n"
            "last status 5\n");
}

TEST_F(PlainActionClient, IsRejectedByOurServer) {
  const auto server = MakeServer();
  auto peer = Peer("action_client_peer", {"-1"});
  EXPECT_EQ(RunUntilExit(peer), "rejected\nlast status 0\n");
}

class PlainActionServer : public ActionPeer {
 protected:
  std::optional<testing::Process> peer_{
      std::in_place,
      std::vector{BinDir() + "/action_server_peer", std::to_string(TestDomain()), name_}};
  std::unique_ptr<ActionClient<Fibonacci>> client_ = Must(MakeActionClient<Fibonacci>(
      *node_, name_, {.lost_after = Milliseconds(300), .on_match_changed = {}}));
  SeenGoal seen_;
};

TEST_F(PlainActionServer, RunsOurGoal) {
  client_->SendGoal({6}, kLong, seen_.Events());
  // Feedback is volatile: the server may discover our reader after it has published the first one.
  ASSERT_TRUE(RunUntil([&] {
    return seen_.ended() && !seen_.feedbacks.empty() && seen_.feedbacks.back().size() == 6;
  }));
  EXPECT_EQ(seen_.End(), "succeeded");
  EXPECT_EQ(seen_.outcome->result.sequence, (Numbers{0, 1, 1, 2, 3, 5}));
  EXPECT_EQ(seen_.feedbacks.back(), seen_.outcome->result.sequence);
}

TEST_F(PlainActionServer, CancelsOurGoal) {
  const GoalId id = client_->SendGoal({100}, kLong, seen_.Events());
  ASSERT_TRUE(RunUntil([&] { return !seen_.feedbacks.empty(); }));
  std::optional<msg::CancelGoal::Response> reply;
  client_->Cancel(id, kLong, [&](const auto& response) { reply = response.value(); });
  ASSERT_TRUE(RunUntil([&] { return reply && seen_.ended(); }));
  EXPECT_EQ(reply->return_code, msg::CancelGoal::kErrorNone);
  EXPECT_EQ(reply->goals_canceling.at(0).goal_id.uuid, id);
  EXPECT_EQ(seen_.End(), "canceled");
}

TEST_F(PlainActionServer, RejectsOurGoal) {
  client_->SendGoal({-1}, kLong, seen_.Events());
  ASSERT_TRUE(RunUntil([&] { return seen_.ended(); }));
  EXPECT_EQ(seen_.End(), "rejected");
}

TEST_F(PlainActionServer, IsRestartedAndDoesNotKnowOurGoal) {
  client_->SendGoal({100}, kLong, seen_.Events());
  ASSERT_TRUE(RunUntil([&] { return !seen_.feedbacks.empty(); }));
  peer_.reset();  // killed
  peer_.emplace(std::vector{BinDir() + "/action_server_peer", std::to_string(TestDomain()), name_});
  ASSERT_TRUE(RunUntil([&] { return seen_.ended(); }));
  EXPECT_EQ(seen_.End(), "lost");
}

}  // namespace musher::transport::action_peer_test
