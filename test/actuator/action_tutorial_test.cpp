// The action of docs/actions.md, whose code comes from here, in virtual time.

#include <gmock/gmock.h>

#include <list>
#include <string>
#include <thread>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/messages/example_interfaces/fibonacci.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::action_tutorial_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// [server]
// Serves the action `fibonacci`: one more number of the sequence every 100 ms.
class FibonacciServer {
 public:
  void Open(transport::Endpoints& topics) {
    transport::ActionHandlers<msg::Fibonacci> handlers;
    handlers.accept = [](const msg::Fibonacci::Goal& goal, transport::ParticipantId) {
      return goal.order >= 1 && goal.order <= 46;  // the next number exceeds 32 bits
    };
    handlers.start = [this](Goal goal) {
      goal.Execute();
      jobs_.push_back({goal, {0, 1}});
    };
    handlers.cancel = [this](Goal goal) {
      std::erase_if(jobs_, [&goal](const Job& job) { return job.goal.id() == goal.id(); });
      goal.Canceled({});
    };
    topics.ServeAction<msg::Fibonacci>("fibonacci", std::move(handlers));
    topics.Every(std::chrono::milliseconds(100), [this] { Step(); });
  }

 private:
  using Goal = transport::ServerGoal<msg::Fibonacci>;
  struct Job {
    Goal goal;
    std::vector<std::int32_t> sequence;
  };

  void Step() {
    for (auto job = jobs_.begin(); job != jobs_.end();) {
      auto& sequence = job->sequence;
      const bool done = static_cast<int>(sequence.size()) > job->goal.goal().order;
      if (done) {
        job->goal.Succeed({sequence});
        job = jobs_.erase(job);
      } else {
        sequence.push_back(sequence[sequence.size() - 2] + sequence.back());
        job->goal.PublishFeedback({sequence});
        ++job;
      }
    }
  }

  std::list<Job> jobs_;
};
// [server end]

// [client]
// Sends goals, and writes down what becomes of them.
class FibonacciClient {
 public:
  void Open(transport::Endpoints& topics) {
    client_ = topics.OpenActionClient<msg::Fibonacci>("fibonacci");
  }
  void Send(int order) {
    transport::GoalEvents<msg::Fibonacci> events;
    events.on_feedback = [this](const msg::Fibonacci::Feedback& feedback) {
      log.push_back("up to " + std::to_string(feedback.sequence.back()));
    };
    events.on_end = [this](const transport::GoalOutcome<msg::Fibonacci>& outcome) {
      log.push_back(std::string(GoalEndName(outcome.end)) + " " + outcome.reason);
    };
    goal_ = client_->SendGoal({order}, std::chrono::seconds(2), std::move(events));
  }
  void Cancel() {
    client_->Cancel(goal_, std::chrono::seconds(2), [this](const auto& reply) {
      const bool accepted = reply && reply.value().return_code == msg::CancelGoal::kErrorNone;
      if (!accepted) log.emplace_back("it cannot be cancelled");
    });
  }

  std::vector<std::string> log;

 private:
  transport::ActionClient<msg::Fibonacci>* client_ = nullptr;
  transport::GoalId goal_{};
};
// [client end]

// [actuator]
class Desk : public MachineActuator {
 public:
  Desk() : MachineActuator("desk") {
    RegisterStateCallback("SetUp", [this] {
      return OpenEndpoints([this](transport::Endpoints& topics) {
        server_.Open(topics);
        client_.Open(topics);
      });
    });
  }
  FibonacciClient& client() { return client_; }  // to be used on the loop

 private:
  FibonacciServer server_;
  FibonacciClient client_;
};
// [actuator end]

class TheActionOfTheTutorial : public ::testing::Test {
 protected:
  TheActionOfTheTutorial() {
    server_.Open(*robot_topics_);
    client_.Open(desk_topics_);
    EXPECT_TRUE(robot_topics_->opened().ok());
    EXPECT_TRUE(desk_topics_.opened().ok());
  }
  void RunFor(int ms) { network_.RunFor(Milliseconds(ms)); }

  transport::sim::Network network_{7};
  std::unique_ptr<transport::Node> there_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> here_ = network_.MakeNode("desk");
  FibonacciServer server_;
  FibonacciClient client_;
  std::unique_ptr<transport::Endpoints> robot_topics_ =
      std::make_unique<transport::Endpoints>(*there_, "");
  transport::Endpoints desk_topics_{*here_, ""};
};

TEST_F(TheActionOfTheTutorial, ReportsEachNumberAndSucceeds) {
  client_.Send(4);
  RunFor(1000);
  EXPECT_THAT(client_.log, ElementsAre("up to 1", "up to 2", "up to 3", "succeeded "));
}

TEST_F(TheActionOfTheTutorial, RejectsAGoalThatIsTooLarge) {
  client_.Send(47);
  RunFor(1000);
  ASSERT_EQ(client_.log.size(), 1U);
  EXPECT_THAT(client_.log.front(), HasSubstr("rejected fibonacci: the server rejects the goal"));
}

TEST_F(TheActionOfTheTutorial, IsCancelledOnRequest) {
  client_.Send(40);
  RunFor(350);
  client_.Cancel();
  RunFor(1000);
  EXPECT_EQ(client_.log.back(), "canceled ");
}

TEST_F(TheActionOfTheTutorial, IsLostForItsClientWithItsServer) {
  client_.Send(40);
  RunFor(350);
  robot_topics_.reset();
  RunFor(10'000);
  EXPECT_THAT(client_.log.back(), HasSubstr("lost "));
}

TEST(TheActuatorOfTheTutorial, ServesAndCallsTheActionFromItsSetUp) {
  const testing::RobotFile file({"desk"}, {"SetUp"});
  ActuatorRunner<Desk> desk;
  ASSERT_TRUE(desk.Init(file.path()).ok());
  ASSERT_TRUE(desk.Start().ok());
  desk.RunOnLoop([&desk] { desk.client().Send(2); });
  std::string last;
  testing::Until([&] {
    desk.RunOnLoop([&] { last = desk.client().log.empty() ? "" : desk.client().log.back(); });
    return last == "succeeded ";
  });
  EXPECT_EQ(last, "succeeded ");
}

}  // namespace musher::action_tutorial_test
