#include "musher/behavior/skill/manager.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/skill/snapshot.hpp"
#include "musher/behavior/skill/toml/snapshot_toml.hpp"
#include "musher/test/behavior/skill/skills.hpp"

namespace musher::skill::manager_test {

using testing::CompletesAfter;
using ::testing::ElementsAre;
using testing::InExecuting;
using testing::Script;
using testing::Scripted;

class AManager : public ::testing::Test {
 protected:
  AManager() {
    EXPECT_TRUE(registry_.Add<Scripted>("walk", walk_));
    EXPECT_TRUE(registry_.Add<Scripted>("look", look_));
    manager_ = std::make_unique<Manager>(registry_.All());
  }
  void Steps(int count) {
    for (int i = 0; i < count; ++i) manager_->RunOnce(now_ += Milliseconds(100));
  }
  std::string ErrorOf(const Result<>& result) { return result ? "" : result.error().message; }
  std::string StateOf(const std::string& skill) { return manager_->StateOf(skill).value_or("?"); }

  Script walk_;
  Script look_;
  Registry registry_;
  std::unique_ptr<Manager> manager_;
  Time now_{};
};

TEST_F(AManager, RunsSeveralSkillsAtOnceEachWithItsOwnState) {
  walk_.step = CompletesAfter(1);
  look_.step = CompletesAfter(3);
  EXPECT_EQ(StateOf("walk"), "IDLE");
  ASSERT_TRUE(manager_->Start("walk", {{"speed", 1.0}}));
  ASSERT_TRUE(manager_->StartWithTexts("look", {{"goal", "[1, 2]"}}));
  Steps(2);
  EXPECT_EQ(StateOf("walk"), "SUCCEEDED");
  EXPECT_EQ(StateOf("look"), "EXECUTING");
  EXPECT_EQ(manager_->Find("look")->parameters().Get<Numbers>("goal", {}), (Numbers{1, 2}));
  EXPECT_EQ(manager_->Find("walk")->parameters().Number("speed"), 1.0);
  EXPECT_TRUE(manager_->running());
  Steps(2);
  EXPECT_FALSE(manager_->running());
}

TEST_F(AManager, TakesATimeoutWithEachRequestAndRefusesOneThatIsNone) {
  for (const char* text : {"0", "-1", "nan", "soon", ""}) {
    const Result<> refused = manager_->StartWithTexts("look", {{"goal", "[1]"}, {"timeout", text}});
    ASSERT_FALSE(refused) << text;
    EXPECT_EQ(refused.error().message,
              "look: timeout is '" + std::string(text) + "'; expected seconds, more than 0");
  }
  ASSERT_TRUE(manager_->StartWithTexts("look", {{"goal", "[1, 2]"}, {"timeout", "60"}}));
  EXPECT_EQ(manager_->Find("look")->table().limits().run, std::chrono::seconds(60));
  EXPECT_EQ(manager_->Find("look")->parameters().Find("timeout"), nullptr);
  EXPECT_FALSE(manager_->StartWithTexts("look", {{"timeout", "60"}})) << "it needs a goal";
}

TEST_F(AManager, RefusesASkillThatRunsWithItsNameAndLeavesItRunning) {
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(1);
  const Result<> again = manager_->Start("walk");
  EXPECT_EQ(ErrorOf(again), "walk is running already");
  EXPECT_EQ(again.error().code, RobotCode(KeyCode::kTargetBusy));
  EXPECT_TRUE(manager_->Find("walk")->running());
}

TEST_F(AManager, RefusesASkillThatNeedsAPartOfTheRobotInUseUntilItIsFree) {
  walk_.uses = {"base"};
  look_.uses = {"camera", "base"};
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(1);
  const Result<> second = manager_->Start("look");
  EXPECT_EQ(ErrorOf(second),
            "look needs the base, which walk is using; cancel walk first or wait for its end");
  EXPECT_EQ(second.error().code, RobotCode(KeyCode::kTargetBusy));
  EXPECT_EQ(StateOf("walk"), "INITIALIZING") << "it goes on";
  ASSERT_TRUE(manager_->Cancel("walk", "a person"));
  EXPECT_FALSE(manager_->Start("look")) << "it may still brake";
  Steps(1);
  EXPECT_TRUE(manager_->Start("look"));
}

TEST_F(AManager, RunsSkillsThatUseOtherPartsOfTheRobotAtOnce) {
  walk_.uses = {"base"};
  look_.uses = {"camera"};
  ASSERT_TRUE(manager_->Start("walk"));
  EXPECT_TRUE(manager_->Start("look"));
}

TEST_F(AManager, UsesAPartOfTheRobotOnlyForRequestsThatNeedIt) {
  walk_.uses = {"base"};
  look_.uses_when_fast = {"base"};
  ASSERT_TRUE(manager_->Start("walk"));
  ASSERT_TRUE(manager_->Start("look"));
  ASSERT_TRUE(manager_->Reset("look"));
  EXPECT_EQ(ErrorOf(manager_->Start("look", {{"speed", 2.0}})),
            "look needs the base, which walk is using; cancel walk first or wait for its end");
  ASSERT_TRUE(manager_->Reset("walk"));
  ASSERT_TRUE(manager_->Start("look", {{"speed", 2.0}}));
  EXPECT_FALSE(manager_->Start("walk"));
}

TEST_F(AManager, PausesOneSkillAndLetsTheOthersGoOn) {
  int walked = 0, looked = 0;
  walk_.step = [&](Tick&) { return ++walked, Next::Stay(); };
  look_.step = [&](Tick&) { return ++looked, Next::Stay(); };
  ASSERT_TRUE(manager_->Start("walk"));
  ASSERT_TRUE(manager_->Start("look"));
  Steps(3);
  ASSERT_TRUE(manager_->Pause("walk", "by a request"));
  EXPECT_EQ(walk_.log, std::vector<std::string>{"OnPause"});
  const Duration before = manager_->Find("walk")->now();
  Steps(50);
  EXPECT_EQ(walked, 3);
  EXPECT_EQ(looked, 53);
  EXPECT_EQ(manager_->Find("walk")->now(), before) << "its time stands still";
  EXPECT_TRUE(manager_->Find("walk")->feedback().paused);
  EXPECT_EQ(manager_->Find("walk")->pause_why(), "by a request");
  ASSERT_TRUE(manager_->Resume("walk"));
  Steps(1);
  EXPECT_EQ(walked, 4);
  EXPECT_EQ(manager_->Find("walk")->now(), before);
  EXPECT_FALSE(manager_->Find("walk")->feedback().paused);
  EXPECT_THAT(walk_.log, ElementsAre("OnPause", "MayResume", "OnResume"));
}

// EXECUTING lasts 1 s at most, the run 10 s.
TEST_F(AManager, CountsNoTimeOfASkillThatIsPaused) {
  walk_.step = InExecuting([](Tick&) { return Next::Stay(); });
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(5);
  ASSERT_TRUE(manager_->Pause("walk", ""));
  Steps(1000);
  ASSERT_TRUE(manager_->Resume("walk"));
  Steps(5);
  EXPECT_EQ(StateOf("walk"), "EXECUTING");
  Steps(5);
  EXPECT_EQ(StateOf("walk"), "FAILED");
}

TEST_F(AManager, KeepsASkillPausedOverAPauseOfAll) {
  int walked = 0;
  walk_.step = [&](Tick&) { return ++walked, Next::Stay(); };
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(1);
  ASSERT_TRUE(manager_->Pause("walk", ""));
  manager_->Pause();
  Steps(10);
  EXPECT_EQ(walked, 1);
  ASSERT_TRUE(manager_->Resume("walk"));
  Steps(1);
  EXPECT_EQ(walked, 2);
  // The other way round: all are paused first.
  manager_->Pause();
  ASSERT_TRUE(manager_->Pause("walk", ""));
  Steps(10);
  EXPECT_EQ(walked, 2);
  EXPECT_THAT(walk_.log, ElementsAre("OnPause", "MayResume", "OnResume", "OnPause")) << "once each";
}

TEST_F(AManager, RefusesAPauseWithTheReason) {
  EXPECT_EQ(ErrorOf(manager_->Pause("wlak", "")),
            "there is no skill 'wlak'; did you mean 'walk'? There are walk and look");
  EXPECT_EQ(ErrorOf(manager_->Pause("walk", "")), "walk does not run");
  EXPECT_EQ(ErrorOf(manager_->Resume("walk")), "walk does not run");
  walk_.cannot_pause = "its hand cannot be stopped halfway";
  ASSERT_TRUE(manager_->Start("walk"));
  EXPECT_EQ(ErrorOf(manager_->Pause("walk", "")),
            "walk cannot be paused: its hand cannot be stopped halfway");
  ASSERT_TRUE(manager_->Start("look"));
  EXPECT_EQ(ErrorOf(manager_->Resume("look")), "look is not paused by a request");
  ASSERT_TRUE(manager_->Pause("look", ""));
  EXPECT_EQ(ErrorOf(manager_->Pause("look", "")), "look is paused already");
  ASSERT_TRUE(manager_->Resume("look"));
  ASSERT_TRUE(manager_->Cancel("look", "a person"));
  EXPECT_EQ(ErrorOf(manager_->Pause("look", "")), "look is being cancelled");
}

TEST_F(AManager, ChecksAtAResumptionThatTheSkillMayStillRun) {
  walk_.uses = look_.uses = {"base"};
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(1);
  ASSERT_TRUE(manager_->Pause("walk", ""));
  ASSERT_TRUE(manager_->Start("look")) << "the base is free meanwhile";
  EXPECT_EQ(ErrorOf(manager_->Start("walk")), "walk is running already");
  EXPECT_EQ(
      ErrorOf(manager_->Resume("walk")),
      "walk stays paused: walk needs the base, which look is using; cancel look first or wait "
      "for its end");
  EXPECT_TRUE(manager_->Find("walk")->pause_requested());
  ASSERT_TRUE(manager_->Reset("look"));
  walk_.may_not_resume = "it has landed";
  EXPECT_EQ(ErrorOf(manager_->Resume("walk")), "walk stays paused: it has landed");
  walk_.may_not_resume.clear();
  walk_.throws = {{"MayResume", "no odometry"}};
  EXPECT_EQ(ErrorOf(manager_->Resume("walk")), "walk stays paused: MayResume: no odometry");
  walk_.throws.clear();
  EXPECT_TRUE(manager_->Resume("walk"));
}

// Its own cancellation would use the parts of the robot that another skill has taken since.
TEST_F(AManager, EndsASkillThatIsPausedByARequestAtOnceWhenItIsCancelled) {
  for (const bool all : {false, true}) {
    walk_.log.clear();
    ASSERT_TRUE(manager_->Start("walk"));
    Steps(1);
    ASSERT_TRUE(manager_->Pause("walk", ""));
    if (all) {
      manager_->CancelAll("a person");
    } else {
      ASSERT_TRUE(manager_->Cancel("walk", "a person"));
    }
    EXPECT_EQ(StateOf("walk"), "CANCELLED");
    EXPECT_EQ(manager_->Find("walk")->feedback().message, "a person");
    EXPECT_FALSE(manager_->Find("walk")->feedback().paused);
    EXPECT_FALSE(manager_->Find("walk")->pause_requested());
    Steps(1);
    EXPECT_THAT(walk_.log, ElementsAre("OnPause", "OnEnd cancelled in its pause"));
  }
}

TEST_F(AManager, SaysToASkillWhetherItEndsInItsPause) {
  ASSERT_TRUE(manager_->Start("walk"));
  ASSERT_TRUE(manager_->Start("look"));
  Steps(1);
  ASSERT_TRUE(manager_->Pause("walk", ""));
  ASSERT_TRUE(manager_->Reset("walk"));
  ASSERT_TRUE(manager_->Pause("look", ""));
  ASSERT_TRUE(manager_->Resume("look"));
  Steps(1);
  ASSERT_TRUE(manager_->Reset("look"));
  EXPECT_THAT(walk_.log, ElementsAre("OnPause", "OnEnd cancelled in its pause"));
  EXPECT_THAT(look_.log, ElementsAre("OnPause", "MayResume", "OnResume", "OnEnd cancelled"));
}

TEST_F(AManager, FailsASkillWhoseOutputsAreNotNeutralInItsPause) {
  walk_.throws = {{"OnPause", "no brake"}};
  ASSERT_TRUE(manager_->Start("walk"));
  EXPECT_EQ(ErrorOf(manager_->Pause("walk", "")), "walk has failed: OnPause: no brake");
  EXPECT_EQ(StateOf("walk"), "FAILED");
  EXPECT_THAT(walk_.log, ElementsAre("OnPause", "OnEnd failed")) << "it has to stop itself";
}

TEST_F(AManager, RestoresASkillThatIsPausedAsPaused) {
  walk_.uses = look_.uses = {"base"};
  int walked = 0;
  walk_.step = [&](Tick&) { return ++walked, Next::Stay(); };
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(1);
  ASSERT_TRUE(manager_->Pause("walk", "by a request"));
  ASSERT_TRUE(manager_->Start("look"));
  const auto text = WriteSnapshot(manager_->Save().value());
  ASSERT_TRUE(text);
  Manager next(registry_.All());
  ASSERT_TRUE(RestoreSnapshot(next, text.value(), "saved.toml"));
  for (int i = 0; i < 10; ++i) next.RunOnce(now_ += Milliseconds(100));
  EXPECT_EQ(walked, 1) << "nothing moves by itself";
  EXPECT_TRUE(next.Find("walk")->feedback().paused);
  EXPECT_EQ(next.Find("walk")->pause_why(), "by a request");
  ASSERT_TRUE(next.Reset("look"));
  ASSERT_TRUE(next.Resume("walk"));
  next.RunOnce(now_ += Milliseconds(100));
  EXPECT_EQ(walked, 2);
}

TEST_F(AManager, StartsAnEndedSkillAgainFromTheBeginning) {
  walk_.step = InExecuting([](Tick&) { return Next::Fail("no path"); });
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(2);
  EXPECT_EQ(StateOf("walk"), "FAILED");
  ASSERT_TRUE(manager_->Start("walk"));
  EXPECT_EQ(StateOf("walk"), "INITIALIZING");
  EXPECT_EQ(manager_->Find("walk")->errors().size(), 0U);
  EXPECT_EQ(manager_->Runs().size(), 1U);
}

TEST_F(AManager, KeepsTheEndOfASkillWhenAnotherStartIsRefused) {
  walk_.step = CompletesAfter(1);
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(2);
  EXPECT_FALSE(manager_->Start("walk", {{"speed", true}}));
  EXPECT_EQ(StateOf("walk"), "SUCCEEDED");
}

TEST_F(AManager, RefusesAnUnknownSkillWithTheNearest) {
  EXPECT_EQ(ErrorOf(manager_->Start("wlak")),
            "there is no skill 'wlak'; did you mean 'walk'? There are walk and look");
  EXPECT_FALSE(manager_->Cancel("wlak", ""));
  EXPECT_FALSE(manager_->Reset("wlak"));
  EXPECT_EQ(manager_->StateOf("wlak"), std::nullopt);
}

TEST_F(AManager, CancelsOneOrAllAndNamesASkillThatDoesNotRun) {
  ASSERT_TRUE(manager_->Start("walk"));
  ASSERT_TRUE(manager_->Start("look"));
  ASSERT_TRUE(manager_->Cancel("walk", "a person"));
  Steps(1);
  EXPECT_EQ(StateOf("walk"), "CANCELLED");
  EXPECT_EQ(StateOf("look"), "INITIALIZING");
  EXPECT_EQ(ErrorOf(manager_->Cancel("walk", "")), "walk does not run");
  ASSERT_TRUE(manager_->Start("walk"));
  manager_->CancelAllNow("emergency stop");
  EXPECT_EQ(StateOf("walk"), "CANCELLED");
  EXPECT_EQ(StateOf("look"), "CANCELLED");
  EXPECT_FALSE(manager_->running());
}

TEST_F(AManager, ResetsOneOrAll) {
  ASSERT_TRUE(manager_->Start("walk"));
  ASSERT_TRUE(manager_->Start("look"));
  Steps(1);
  ASSERT_TRUE(manager_->Reset("walk"));
  EXPECT_EQ(StateOf("walk"), "IDLE");
  EXPECT_EQ(manager_->Find("walk"), nullptr);
  EXPECT_THAT(walk_.log, ElementsAre("OnEnd cancelled")) << "a running skill is ended before";
  EXPECT_TRUE(manager_->Find("look")->running());
  manager_->ResetAll();
  EXPECT_TRUE(manager_->Runs().empty());
  EXPECT_THAT(look_.log, ElementsAre("OnEnd cancelled"));
}

TEST_F(AManager, ShowsTheEndOfEachRunBeforeItIsRemoved) {
  std::vector<std::string> removed;
  manager_->OnRemoval(
      [&](const skill::Run& run) { removed.push_back(run.name() + " " + ToText(run.feedback())); });
  walk_.step = CompletesAfter(1);
  look_.step = InExecuting([](const Tick&) { return Next::Stay(); });
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(2);
  ASSERT_TRUE(manager_->Start("walk"));
  ASSERT_TRUE(manager_->Start("look"));
  Steps(1);
  EXPECT_EQ(removed.size(), 1U);
  manager_->ResetAll();
  EXPECT_THAT(removed, ElementsAre("walk completed: done (100%)",
                                   "look cancelled: all skills are reset (0%)",
                                   "walk cancelled: all skills are reset (0%)"));
}

TEST_F(AManager, SaysEachChangeOfAState) {
  std::vector<std::string> changes;
  manager_->OnStateChanged([&](const skill::Run& run, const skill::Change& change) {
    changes.push_back(run.name() + " " + std::string(run.table().Name(change.from)) + " > " +
                      std::string(run.table().Name(change.to)));
  });
  walk_.step = CompletesAfter(1);
  look_.step = InExecuting([](const Tick&) { return Next::Stay(); });
  ASSERT_TRUE(manager_->Start("walk"));
  ASSERT_THAT(changes, ElementsAre(::testing::StartsWith("walk IDLE > ")));
  Steps(2);
  EXPECT_THAT(changes.back(), ::testing::EndsWith(" > SUCCEEDED"));
  ASSERT_TRUE(manager_->Start("look"));
  Steps(1);
  ASSERT_TRUE(manager_->CancelNow("look", "by the test"));
  EXPECT_THAT(changes.back(), ::testing::EndsWith(" > CANCELLED"));
  EXPECT_EQ(changes.size(),
            manager_->Find("walk")->history().size() + manager_->Find("look")->history().size());
}

TEST_F(AManager, ThePauseIsNoTimeOfItsSkills) {
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(3);
  manager_->Pause();
  now_ += std::chrono::hours(5);
  Steps(2);
  EXPECT_EQ(ToMilliseconds(manager_->Find("walk")->now()), 300);
  now_ -= std::chrono::hours(5);
  Steps(1);
  EXPECT_EQ(ToMilliseconds(manager_->Find("walk")->now()), 300) << "time that runs back is no time";
}

TEST_F(AManager, RefusesASkillThatChangesSkillsWithinAStep) {
  std::vector<std::string> errors;
  walk_.step = [&](Tick&) {
    errors = {ErrorOf(manager_->Start("look")), ErrorOf(manager_->Reset("walk")),
              ErrorOf(manager_->Cancel("walk", "")), ErrorOf(manager_->Pause("walk", ""))};
    manager_->RunOnce(now_);
    manager_->ResetAll();
    manager_->Pause();
    return Next::Stay();
  };
  ASSERT_TRUE(manager_->Start("walk"));
  Steps(1);
  EXPECT_THAT(
      errors,
      ElementsAre("look: skills are not started, paused, cancelled or reset within a step",
                  "walk: skills are not started, paused, cancelled or reset within a step",
                  "walk: skills are not started, paused, cancelled or reset within a step",
                  "walk: skills are not started, paused, cancelled or reset within a step"));
  EXPECT_TRUE(manager_->Find("walk")->running());
}

TEST(ARegistry, RefusesASkillThatCannotRun) {
  Script script;
  Registry registry;
  ASSERT_TRUE(registry.Add<Scripted>("walk", script));
  EXPECT_EQ(registry.Add<Scripted>("walk", script).error().message,
            "skill walk is registered already");
  EXPECT_FALSE(registry.Add<Scripted>("", script));
  EXPECT_FALSE(registry.Add<Scripted>("a/b", script));
  EXPECT_EQ(registry.Add("none", Factory()).error().message,
            "skill none: its factory returns no skill");
  const Factory endless = [] {
    return std::make_unique<StepFunction>([](Table& table) { table.State("A"); },
                                          [](Tick&) { return Next::Stay(); });
  };
  EXPECT_EQ(registry.Add("endless", endless).error().message,
            "endless: A: no declared transitions lead from it to an end");
  EXPECT_THAT(registry.Names(), ElementsAre("walk"));
}

TEST(ARegistry, HasTheSkillsOfAKindOfRobot) {
  Script script;
  Registry registry;
  for (const char* name : {"walk", "take_off", "look"}) {
    ASSERT_TRUE(registry.Add<Scripted>(name, script));
  }
  const Config config{{{"base", {}, {"look"}},
                       {"ground", {"jetbot", "h1"}, {"walk", "look"}},
                       {"drone", {"cf2x"}, {"take_off"}}},
                      {}};
  const auto of = [&](const std::string& robot) {
    std::vector<std::string> names;
    const auto entries = registry.Of(config, robot);
    if (!entries) return std::vector<std::string>{entries.error().message};
    for (const Entry& entry : entries.value()) names.push_back(entry.name);
    return names;
  };
  EXPECT_THAT(of("h1"), ElementsAre("look", "walk"));
  EXPECT_THAT(of("cf2x"), ElementsAre("look", "take_off"));
  EXPECT_THAT(of("cf2"), ElementsAre("there is no kind of robot 'cf2'; did you mean 'cf2x'? There "
                                     "are cf2x, h1 and jetbot"));
  const Config wrong{{{"drone", {"cf2x"}, {"take_of"}}}, {}};
  EXPECT_EQ(registry.Of(wrong, "cf2x").error().message,
            "there is no skill 'take_of'; did you mean 'take_off'? There are walk, take_off and "
            "look");
}

TEST(ARegistry, TakesSettingsOverOrRefusesAllOfThem) {
  Script script;
  Registry registry;
  ASSERT_TRUE(registry.Add<Scripted>("walk", script));
  Settings slow{.retries = 9};
  ASSERT_TRUE(registry.Configure({{}, {{"walk", slow}}}));
  EXPECT_EQ(registry.Find("walk")->settings, slow);
  Settings wrong{.retries = 1};
  wrong.parameters.Set("sped", 1.0);
  EXPECT_EQ(registry.Configure({{}, {{"walk", wrong}, {"wlk", slow}}}).error().message,
            "walk: there is no parameter sped; did you mean 'speed'?\n"
            "there is no skill 'wlk'; did you mean 'walk'? There is only walk");
  EXPECT_EQ(registry.Find("walk")->settings, slow);
}

}  // namespace musher::skill::manager_test
