// The skills of docs/skills.md, whose code and picture come from here.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "musher/behavior/fsm/graph.hpp"
#include "musher/behavior/skill/check.hpp"
#include "musher/behavior/skill/compose.hpp"
#include "musher/behavior/skill/future.hpp"
#include "musher/behavior/skill/manager.hpp"
#include "musher/behavior/skill/pattern.hpp"
#include "musher/behavior/skill/toml/skills_toml.hpp"
#include "musher/behavior/skill/wait.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::skill::tutorial_test {

struct Drone {
  double height_m = 0;
  double climb_mps = 0;
};

// [take_off]
class TakeOff : public skill::Skill {
 public:
  explicit TakeOff(Drone& drone) : drone_(drone) {}

  void Declare(skill::Table& table) override {
    table.Does("Rises to an altitude above the ground");
    table.Takes("altitude", 1.0, "m above the ground");
    const auto rising = table.State("EXECUTING", std::chrono::seconds(30));
    table.To(rising, skill::kSucceeded, "at most 0.1 m below the altitude");
  }
  skill::Next Step(skill::Tick& tick) override {
    const double altitude = tick.parameters.Number("altitude");
    if (altitude <= 0) return skill::Next::Fail("the altitude is not above 0 m");
    if (drone_.height_m >= altitude - 0.1) return skill::Next::Succeed("Reached altitude");
    drone_.climb_mps = 0.5;
    tick.Report(100 * drone_.height_m / altitude, "Taking off");
    tick.Detail("height_m", drone_.height_m);
    return skill::Next::Stay();
  }
  void OnEnd(const skill::Ended& ended) override {
    if (!ended.paused) drone_.climb_mps = 0;
  }
  void OnPause() override { drone_.climb_mps = 0; }

 private:
  Drone& drone_;
};
// [take_off end]

using Path = std::vector<double>;

// A planner that is asked, and whose answer comes later.
struct Planner {
  std::vector<skill::Source<Path>> asked{};
  bool blocked = false;

  skill::Future<Path> Ask() { return asked.emplace_back().future(); }
};

// [navigate]
class Navigate : public skill::PatternSkill {
 public:
  explicit Navigate(Planner& planner) : planner_(planner) {}

 private:
  void Describe(skill::Table& table) override {
    table.Needs("goal_pos", skill::Kind::kNumbers, "m, in the map");
    static_cast<void>(table.SetLimit("PREPARING", std::chrono::seconds(15)));
    static_cast<void>(table.SetLimit("EXECUTING", std::chrono::seconds(120)));
  }
  Outcome Prepare(skill::Tick& tick) override {
    if (tick.entered || !plan_.valid()) plan_ = planner_.Ask();
    tick.Report(15, "Planning the path");
    if (!plan_.done()) return Outcome::Continue();
    return plan_.result() ? Outcome::Done() : Outcome::Retry(plan_.result().error().message);
  }
  Outcome Execute(skill::Tick& tick) override {
    if (planner_.blocked) return Outcome::Replan("the path is blocked");
    tick.Report(50 + musher::ToSeconds(tick.elapsed), "Moving");
    return tick.elapsed >= std::chrono::seconds(10) ? Outcome::Done("Reached goal")
                                                    : Outcome::Continue();
  }

  Planner& planner_;
  skill::Future<Path> plan_;
};
// [navigate end]

constexpr const char* kSettings = R"(
# [config]
[group.drone]
robots = ["cf2x", "drone_autel"]             # kinds of robots; without the key: all
skills = ["take_off", "navigate_to"]

[skill.take_off]
time_limit_ms = 40000                        # of a run; 0: none
state_limits_ms = { EXECUTING = 20000 }      # 0: none
parameters = { altitude = 2.0 }              # defaults
# [config end]
)";

class TheTutorial : public ::testing::Test {
 protected:
  TheTutorial() {
    Drone& drone = drone_;
    Planner& planner = planner_;
    Result<> added = Ok();
    // [registry]
    skill::Registry registry;
    added = registry.Add<TakeOff>("take_off", drone);
    added = registry.Add<Navigate>("navigate_to", planner);
    added = registry.Add("wait", skill::Wait());
    added = registry.Add("survey",
                         skill::Compose(skill::Order::kInOrder, registry,
                                        {{"take_off", {{"altitude", 2.0}}}, {"navigate_to"}}));
    skill::Manager manager(registry.All());
    // [registry end]
    EXPECT_TRUE(added) << added.error().message;
    registry_ = registry;
    manager_ = std::make_unique<Manager>(registry_.All());
  }
  std::string After(int steps, const std::string& skill) {
    for (int i = 0; i < steps; ++i) {
      manager_->RunOnce(now_ += Milliseconds(100));
      drone_.height_m += 0.1 * drone_.climb_mps;
    }
    return ToText(manager_->Find(skill)->feedback());
  }

  Drone drone_;
  Planner planner_;
  Registry registry_;
  std::unique_ptr<Manager> manager_;
  Time now_{};
};

TEST_F(TheTutorial, TakesOffAndStopsItsClimb) {
  ASSERT_TRUE(manager_->StartWithTexts("take_off", {{"altitude", "2.0"}}));
  EXPECT_EQ(After(12, "take_off"), "processing: Taking off (27%)");
  EXPECT_EQ(After(40, "take_off"), "completed: Reached altitude (100%)");
  EXPECT_EQ(drone_.climb_mps, 0);
}

TEST_F(TheTutorial, FailsToNavigateWhenThePlannerIsGoneOrSilent) {
  ASSERT_TRUE(manager_->Start("navigate_to", {{"goal_pos", Numbers{10, 20, 0}}}));
  for (int i = 0; i < 4; ++i) {
    After(2, "navigate_to");
    planner_.asked.clear();
    After(1, "navigate_to");
  }
  EXPECT_EQ(After(1, "navigate_to"),
            "failed: gives up after 3 retries: the work was abandoned (15%)");
  ASSERT_TRUE(manager_->Start("navigate_to", {{"goal_pos", Numbers{10, 20, 0}}}));
  EXPECT_EQ(After(160, "navigate_to"), "failed: not done after 15 s (15%)");
}

TEST_F(TheTutorial, SurveysWithANewPlanWhereThePathIsBlocked) {
  ASSERT_TRUE(manager_->StartWithTexts("survey", {{"navigate_to.goal_pos", "[10, 20, 0]"}}));
  After(60, "survey");
  ASSERT_EQ(planner_.asked.size(), 1U);
  planner_.asked.back().Finish({1});
  After(2, "survey");
  EXPECT_EQ(manager_->StateOf("survey"), "RUNNING/navigate_to/EXECUTING");
  planner_.blocked = true;
  After(2, "survey");
  planner_.blocked = false;
  ASSERT_EQ(planner_.asked.size(), 2U);
  planner_.asked.back().Finish({1});
  EXPECT_EQ(After(120, "survey"), "completed: Completed (100%)");
}

TEST_F(TheTutorial, TakesSkillsLimitsAndDefaultsFromItsConfig) {
  const Parsed<Config> reading = ReadConfig(kSettings, "skills.toml", registry_);
  ASSERT_TRUE(reading.config) << FormatDiagnostic(reading.diagnostics.front());
  ASSERT_TRUE(registry_.Configure(*reading.config));
  const auto skills = registry_.Of(*reading.config, "cf2x");
  ASSERT_TRUE(skills.ok());
  ASSERT_EQ(skills.value().size(), 2U);
  const skill::Run run("take_off", skills.value()[0].make(), skills.value()[0].settings);
  EXPECT_EQ(run.table().limits().run, std::chrono::seconds(40));
  EXPECT_EQ(run.table().parameters()[0].otherwise, Value(2.0));
  EXPECT_FALSE(registry_.Of(*reading.config, "jetbot").ok());
}

// The check of every skill that Musher has, and of those of the page.
TEST_F(TheTutorial, HasSkillsWhoseTablesHaveNoProblem) {
  for (const Order order : {Order::kParallel, Order::kFirstToFinish}) {
    const std::string name = "order" + std::to_string(static_cast<int>(order));
    ASSERT_TRUE(registry_.Add(name, Compose(order, registry_, {{"take_off"}, {"wait"}})));
  }
  // [check]
  for (const skill::Entry& entry : registry_.All()) {
    const skill::Run run(entry.name, entry.make());
    EXPECT_TRUE(run.built()) << run.built().error().message;
    EXPECT_THAT(skill::Check(run.table()), ::testing::IsEmpty()) << entry.name;
  }
  // [check end]
  EXPECT_EQ(registry_.All().size(), 6U);
}

TEST_F(TheTutorial, ShowsThePictureOfItsSkill) {
  std::ifstream file(SourceDir() + "/docs/skills.md", std::ios::binary);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const skill::Run run("navigate_to", registry_.Find("navigate_to")->make());
  EXPECT_THAT(page, ::testing::HasSubstr("```mermaid\n" + fsm::ToMermaid(run.chart()) + "```\n"));
}

}  // namespace musher::skill::tutorial_test
