// A run of a skill that is replaced or removed by its actuator: its goal and its feedback end with
// it.

#include <mutex>

#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/test/application/skill_tasks.hpp"

namespace musher::skill_runs_test {

using ::testing::Contains;
using testing::SkillTasks;

class ASkillRun : public testing::SkillActuatorTest {
 protected:
  ~ASkillRun() override {
    harness_.node().RunOnLoop([this] { subscription_.reset(); });
  }
  template <class Application>
  void BeginAndListen(Application& tasks) {
    Begin(tasks);
    harness_.node().RunOnLoop([this] {
      subscription_ = transport::MakeSubscription<msg::SkillFeedback>(
                          harness_.node().node(), "skill_feedback",
                          [this](auto&& sample, const auto&) { received_.push_back(sample); })
                          .value();
    });
    Await([&] { return subscription_->MatchedWriters() == 1; });
  }
  // "completed 0123…", with the goal or without one, of each feedback.
  std::vector<std::string> Received() {
    std::vector<std::string> texts;
    harness_.node().RunOnLoop([&] {
      for (const msg::SkillFeedback& feedback : received_) {
        texts.push_back(feedback.message + (feedback.goal_id.empty() ? " without a goal" : ""));
      }
    });
    return texts;
  }

  std::unique_ptr<transport::Subscription> subscription_;
  std::vector<msg::SkillFeedback> received_;  // on the client's loop
};

TEST_F(ASkillRun, EndsItsGoalAlsoWhenTheActuatorStartsTheSkillAgain) {
  ActuatorRunner<SkillTasks> tasks;
  BeginAndListen(tasks);
  tasks.RunOnLoop([&] {
    tasks.after_step = [&] {
      const skill::Run* run = tasks.manager().Find("wait");
      if (run != nullptr && run->ended()) {
        EXPECT_TRUE(tasks.manager().Start("wait", {{"duration_s", 1000.0}}));
      }
    };
  });
  const auto sent = Send("wait", {{"duration_s", "0.1"}});
  AwaitAccepted(sent);
  harness_.Tick(tasks, 8);
  EXPECT_EQ(EndOf(sent), "succeeded true completed: Waited (100%)");
  harness_.Tick(tasks, 2);
  EXPECT_EQ(tasks.StateOf("wait"), "WAITING");
  Await([&] { return received_.back().message != "Waited" && received_.back().goal_id.empty(); });
  EXPECT_THAT(Received(), Contains("Waited"));
}

TEST_F(ASkillRun, ShowsItsEndWhenItIsReset) {
  ActuatorRunner<SkillTasks> tasks;
  BeginAndListen(tasks);
  const auto sent = Send("wait", {{"duration_s", "9"}});
  AwaitAccepted(sent);
  harness_.Tick(tasks, 1);
  tasks.RunOnLoop([&] { EXPECT_TRUE(tasks.manager().Reset("wait")); });
  EXPECT_EQ(EndOf(sent), "aborted false cancelled: it is reset (0%)");
  EXPECT_EQ(tasks.StateOf("wait"), "IDLE");
  Await([&] { return received_.back().status == msg::SkillFeedback::kStatusCancelled; });
}

}  // namespace musher::skill_runs_test
