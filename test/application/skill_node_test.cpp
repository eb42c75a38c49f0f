// RunSkill: a node of a behaviour tree runs the skills of a real skill actuator.

#include "musher/application/skill_node.hpp"

#include "musher/test/application/skill_tasks.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::skill_node_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using Tasks = testing::SkillTasks;

class ASkillNode : public testing::SkillActuatorTest {
 protected:
  ASkillNode() {
    harness_.node().RunOnLoop([this] {
      endpoints_ = std::make_unique<transport::Endpoints>(harness_.node().node(), "");
      EXPECT_TRUE(nodes_.Register(factory_));
      nodes_.Open(*endpoints_);
    });
  }
  ~ASkillNode() override {
    harness_.node().RunOnLoop([this] {
      tree_.reset();
      endpoints_.reset();
    });
  }

  void Make(const std::string& ports) {
    harness_.node().RunOnLoop([&] {
      tree_ = tree::MakeTree(
          tree::Main("<RunSkill " + ports + " progress=\"{progress}\" message=\"{message}\"/>"),
          factory_);
    });
    ASSERT_TRUE(tree_);
  }
  tree::Status Tick() {
    tree::Status status = tree::Status::kIdle;
    harness_.node().RunOnLoop([&] {
      const auto ticked = tree_->TickOnce(harness_.node().node().loop().Now());
      EXPECT_TRUE(ticked) << ticked.error().message;
      if (ticked) status = ticked.value();
    });
    return status;
  }
  // Until the node has ended; the skills are stepped meanwhile.
  tree::Status End(ActuatorRunner<Tasks>& tasks) {
    tree::Status status = tree::Status::kRunning;
    EXPECT_TRUE(testing::Until([&] {
      harness_.Tick(tasks, 1);
      status = Tick();
      return status != tree::Status::kRunning;
    }));
    return status;
  }
  std::string Message() { return Entry<std::string>("message"); }
  template <class T>
  T Entry(const std::string& key) {
    T found{};
    harness_.node().RunOnLoop([&] { found = tree_->board().Get<T>(key).value(); });
    return found;
  }

  SkillNodes nodes_;
  tree::Factory factory_;
  std::unique_ptr<transport::Endpoints> endpoints_;
  std::unique_ptr<tree::Tree> tree_;
};

TEST_F(ASkillNode, SucceedsWhenItsSkillHasCompletedAndReportsItsProgress) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  Make("skill=\"wait\" parameters=\"duration_s=0.2\"");
  double most = 0;
  tree::Status status = tree::Status::kRunning;
  EXPECT_TRUE(testing::Until([&] {
    harness_.Tick(tasks, 1);
    status = Tick();
    if (status == tree::Status::kRunning) most = std::max(most, Entry<double>("progress"));
    return status != tree::Status::kRunning;
  }));
  EXPECT_EQ(status, tree::Status::kSuccess);
  EXPECT_GT(most, 0);
  EXPECT_EQ(Entry<double>("progress"), 100);
  EXPECT_EQ(Message(), "completed: Waited (100%)");
}

TEST_F(ASkillNode, FailsWithTheReasonOfItsSkillOrOfARefusal) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  Make("skill=\"fail\" actuator=\"show\"");
  EXPECT_EQ(End(tasks), tree::Status::kFailure);
  EXPECT_THAT(Message(), HasSubstr("failed: no path"));
  Make("skill=\"wait\" parameters=\"duration=1\"");
  EXPECT_EQ(End(tasks), tree::Status::kFailure);
  EXPECT_THAT(Message(), HasSubstr("wait: there is no parameter duration"));
  Make("skill=\"wait\" parameters=\"duration_s\"");
  EXPECT_EQ(End(tasks), tree::Status::kFailure);
  EXPECT_THAT(Message(), HasSubstr("expected KEY=VALUE, found 'duration_s'"));
  Make("skill=\"wait\" actuator=\"arm\"");
  EXPECT_EQ(End(tasks), tree::Status::kFailure);
  EXPECT_EQ(Message(), "no actuator arm offers the skill wait");
}

TEST_F(ASkillNode, RequestsNothingWhereAnEntryOfItsPortsHasNoValue) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  for (const std::string port : {"actuator", "parameters"}) {
    Make("skill=\"wait\" " + port + "=\"{who}\"");
    std::string why;
    EXPECT_TRUE(testing::Until([&] {
      harness_.Tick(tasks, 1);
      harness_.node().RunOnLoop([&] {
        const auto ticked = tree_->TickOnce(harness_.node().node().loop().Now());
        why = ticked ? tree::Name(ticked.value()) : ticked.error().message;
      });
      return why != "RUNNING" || tasks.StateOf("wait") == "WAITING";
    }));
    EXPECT_THAT(why, HasSubstr("port '" + port + "': the blackboard"));
  }
}

TEST_F(ASkillNode, CancelsItsSkillWhenItIsHaltedAndMayRunItAgainAtOnce) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  Make("skill=\"wait\" parameters=\"duration_s=60\"");
  ASSERT_TRUE(testing::Until([&] {
    harness_.Tick(tasks, 1);
    EXPECT_EQ(Tick(), tree::Status::kRunning);
    return tasks.StateOf("wait") == "WAITING";
  }));
  harness_.node().RunOnLoop([&] { ASSERT_TRUE(tree_->Halt(harness_.node().node().loop().Now())); });
  EXPECT_EQ(Tick(), tree::Status::kRunning) << "it waits for the end of the one before";
  ASSERT_TRUE(testing::Until([&] {
    harness_.Tick(tasks, 1);
    return tasks.StateOf("wait") == "CANCELLED";
  }));
  EXPECT_TRUE(testing::Until([&] {
    harness_.Tick(tasks, 1);
    EXPECT_EQ(Tick(), tree::Status::kRunning);
    return tasks.StateOf("wait") == "WAITING";
  })) << "it runs again";
}

TEST_F(ASkillNode, FailsWhenAnotherClientCancelsItsSkill) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  Make("skill=\"wait\" parameters=\"duration_s=60\"");
  ASSERT_TRUE(testing::Until([&] {
    harness_.Tick(tasks, 1);
    Tick();
    return tasks.StateOf("wait") == "WAITING";
  }));
  ASSERT_TRUE(tasks.Of([](Tasks& t) { return t.manager().Cancel("wait", "by alice@dog1").ok(); }));
  EXPECT_EQ(End(tasks), tree::Status::kFailure);
  EXPECT_THAT(Message(), HasSubstr("cancelled: by alice@dog1"));
}

TEST(SkillNodes, ReadParametersWithSemicolonsInTheirValues) {
  const auto read =
      SkillNodes::ReadParameters(" goal_pos=[2, 1, 0] ; text=\"a;b\"; path=[[0;0]];timeout = 60;");
  ASSERT_TRUE(read);
  EXPECT_THAT(read.value(), ElementsAre(Pair("goal_pos", "[2, 1, 0]"), Pair("text", "a;b"),
                                        Pair("path", "[[0;0]]"), Pair("timeout", "60")));
  EXPECT_FALSE(SkillNodes::ReadParameters("=1"));
}

}  // namespace musher::skill_node_test
