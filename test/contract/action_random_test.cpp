// Random goals, ends, cancellations, partitions and restarts on the simulated network: every goal
// ends exactly once for its client, and nothing is left behind.

#include <gmock/gmock.h>

#include <cstdlib>
#include <list>

#include "musher/test/contract/action_harness.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::transport::action_random_test {

constexpr std::uint64_t kRuns = 300;
constexpr int kSteps = 60;

class RandomRun {
 public:
  explicit RandomRun(std::uint64_t seed) : network_(seed), random_(seed) {
    network_.SetLease(std::chrono::seconds(1));
    sim::LinkFaults faults;
    faults.loss = 0.05;
    faults.duplication = 0.05;
    faults.delay_max = Milliseconds(5);
    network_.SetFaults(faults);
    StartServer();
    for (const char* host : {"desk", "phone"}) {
      nodes_.push_back(network_.MakeNode(host));
      clients_.push_back(Must(MakeActionClient<Fibonacci>(*nodes_.back(), "fibonacci")));
    }
  }

  void Run() {
    for (int step = 0; step < kSteps; ++step) {
      Next();
      network_.RunFor(random_.Between(Duration::zero(), Milliseconds(Below(10) == 0 ? 3000 : 30)));
    }
    for (const char* host : {"desk", "phone"}) network_.Heal("dog", host);
    if (!server_) StartServer();
    network_.RunFor(std::chrono::seconds(30));
    while (!server_->started.empty()) EndGoal();
    network_.RunFor(std::chrono::seconds(60));
    Check();
  }

  std::map<std::string, int> ends;

 private:
  std::size_t Below(std::size_t count) { return random_.Next() % count; }

  void StartServer() {
    dog_ = network_.MakeNode("dog");
    server_ = FibonacciServer::Make(*dog_, "fibonacci");
  }
  void Next() {
    switch (Below(12)) {
      case 0:
        return network_.Partition("dog", Below(2) == 0 ? "desk" : "phone");
      case 1:
        return network_.Block(Below(2) == 0 ? "desk" : "dog", Below(2) == 0 ? "dog" : "phone");
      case 2:
      case 3:
        for (const char* host : {"desk", "phone"}) network_.Heal("dog", host);
        return;
      case 4:
        return Restart();
      case 5:
        return clients_[Below(2)]->CancelAll(Milliseconds(200), [](const auto&) {});
      case 6:
      case 7:
        return WithAGoal([this](SeenGoal& goal) {
          clients_[Below(2)]->Cancel(goal.id, Milliseconds(200), [](const auto&) {});
        });
      case 8:
      case 9:
        return EndGoal();
      default:
        goals_.emplace_back();
        goals_.back().id = clients_[Below(2)]->SendGoal({static_cast<int>(Below(4)) - 1},
                                                        Milliseconds(500), goals_.back().Events());
    }
  }
  void Restart() {
    if (Below(2) != 0) return;
    if (dog_) network_.Crash(*dog_);
    server_.reset();
    dog_.reset();
    StartServer();
  }
  template <class Use>
  void WithAGoal(const Use& use) {
    if (goals_.empty()) return;
    use(*std::next(goals_.begin(), static_cast<std::ptrdiff_t>(Below(goals_.size()))));
  }
  // One way or another; the last one drops the handle.
  void EndGoal() {
    if (!server_ || server_->started.empty()) return;
    const std::size_t i = Below(server_->started.size());
    FibonacciGoal goal = server_->started[i];
    if (Below(2) == 0) goal.Execute();
    if (Below(2) == 0) goal.PublishFeedback({{1, 1}});
    if (Below(3) == 0) goal.Canceled({});
    if (Below(3) == 0) goal.Succeed({{2}});
    if (Below(3) == 0) goal.Abort({{3}});
    server_->started.erase(server_->started.begin() + static_cast<std::ptrdiff_t>(i));
    server_->canceling.clear();
  }

  void Check() {
    for (const SeenGoal& goal : goals_) {
      ASSERT_TRUE(goal.ended()) << "a goal hangs";
      const bool has_reason = !goal.outcome->reason.empty();
      EXPECT_EQ(has_reason, goal.End() == "lost" || goal.End() == "rejected") << goal.End();
    }
    for (const SeenGoal& goal : goals_) ++ends[goal.End()];
    for (const auto& client : clients_) EXPECT_EQ(client->goals(), 0U);
    EXPECT_EQ(server_->server->waiting(), 0U);
    EXPECT_TRUE(server_->started.empty());
  }

  std::list<SeenGoal> goals_;  // outlives the clients
  sim::Network network_;
  sim::Random random_;
  std::unique_ptr<Node> dog_;
  std::unique_ptr<FibonacciServer> server_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::vector<std::unique_ptr<ActionClient<Fibonacci>>> clients_;
};

TEST(RandomActions, EndEveryGoalOnceAndLeaveNothingBehind) {
  const char* more = std::getenv("MUSHER_SEEDS");
  const std::uint64_t runs = more != nullptr ? std::strtoull(more, nullptr, 10) : kRuns;
  std::map<std::string, int> ends;
  for (std::uint64_t seed = 1; seed <= runs && !::testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomRun run(seed);
    run.Run();
    for (const auto& [end, count] : run.ends) ends[end] += count;
  }
  for (const char* end : {"succeeded", "canceled", "aborted", "rejected", "lost"}) {
    EXPECT_GT(ends[end], 0) << end;
  }
}

}  // namespace musher::transport::action_random_test
