// Transitions to any state of the hierarchy: what they leave and enter, in UML's order.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "musher/behavior/fsm/graph.hpp"
#include "musher/behavior/fsm/snapshot.hpp"
#include "musher/test/behavior/fsm/hierarchy_fixture.hpp"

namespace musher::fsm::hierarchy_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// IDLE; SHOW with ASK and PHOTO, and in PHOTO POSE and SHOOT; WALK with STEP and TURN.
class HierarchyTest : public HierarchyFixture {
 protected:
  void Make() {
    auto photo = NewMachine("photo");
    photo->AddEvent("stop");
    pose_ = &Add(*photo, "POSE",
                 {"SHOOT", "IDLE", "WALK/TURN", "/SHOW/ASK", "SHOW", "PHOTO", "SHOW/PHOTO/SHOOT"});
    shoot_ = &Add(*photo, "SHOOT", {"POSE"});
    auto show = NewMachine("show inside");
    show->AddEvent("stop");
    ask_ = &Add(*show, "ASK", {"PHOTO", "PHOTO/SHOOT"});
    photo_ = photo.get();
    AddNested(*show, "PHOTO", std::move(photo), "POSE");
    auto walk = NewMachine("walk");
    step_ = &Add(*walk, "STEP", {"TURN", "/SHOW/PHOTO/SHOOT"});
    turn_ = &Add(*walk, "TURN", {"STEP"});
    machine_.AddEvent("stop");
    machine_.AddSafetyCheck("distance", [this](const Tick&) { return safe_; });
    idle_ = &Add("IDLE", {"SHOW", "SHOW/PHOTO/SHOOT", "WALK"});
    show_ = &AddNested(machine_, "SHOW", std::move(show), "ASK");
    show_->declare = [this](Transitions& transitions) {
      into_photo_ = transitions.To("SHOW/PHOTO/SHOOT", "again");
    };
    AddNested(machine_, "WALK", std::move(walk), "STEP");
    Add("SAFE", {"IDLE"}, Role::kSafe);
    Start("IDLE");
  }
  // To SHOW/PHOTO/POSE.
  void EnterPose() {
    idle_->Go("SHOW");
    Run();
    ask_->Go("PHOTO");
    Run();
    ASSERT_EQ(machine_.Path(), "SHOW/PHOTO/POSE");
  }
  Log Goes(LoggingState& from, const std::string& to) {
    from.Go(to);
    return TickLog();
  }

  LoggingState* idle_ = nullptr;
  LoggingNested* show_ = nullptr;
  LoggingState* ask_ = nullptr;
  LoggingState* pose_ = nullptr;
  LoggingState* shoot_ = nullptr;
  LoggingState* step_ = nullptr;
  LoggingState* turn_ = nullptr;
  Machine* photo_ = nullptr;
  StateId into_photo_ = kNoState;
  bool safe_ = true;
};

TEST_F(HierarchyTest, LeavesInnermostFirstUpToTheMachineOfTheTarget) {
  Make();
  EnterPose();
  EXPECT_THAT(Goes(*pose_, "IDLE"),
              ElementsAre("POSE exit", "PHOTO exit", "SHOW exit", "IDLE enter"));
  EXPECT_EQ(machine_.Path(), "IDLE");
  EXPECT_EQ(machine_.history().back().cause, Cause::kDecided);
}

TEST_F(HierarchyTest, EntersOutermostFirstDownToTheTarget) {
  Make();
  EXPECT_THAT(Goes(*idle_, "SHOW/PHOTO/SHOOT"),
              ElementsAre("IDLE exit", "SHOW enter", "PHOTO enter", "SHOOT enter"));
  EXPECT_EQ(machine_.Path(), "SHOW/PHOTO/SHOOT");
}

TEST_F(HierarchyTest, GoesFromOneInnerMachineIntoAnother) {
  Make();
  EnterPose();
  EXPECT_THAT(Goes(*pose_, "WALK/TURN"),
              ElementsAre("POSE exit", "PHOTO exit", "SHOW exit", "WALK enter", "TURN enter"));
  EXPECT_THAT(Goes(*turn_, "STEP"), ElementsAre("TURN exit", "STEP enter"));
  EXPECT_THAT(Goes(*step_, "/SHOW/PHOTO/SHOOT"),
              ElementsAre("STEP exit", "WALK exit", "SHOW enter", "PHOTO enter", "SHOOT enter"));
}

TEST_F(HierarchyTest, LeavesOnlyWhatTheTargetIsNotIn) {
  Make();
  EnterPose();
  EXPECT_THAT(Goes(*pose_, "/SHOW/ASK"), ElementsAre("POSE exit", "PHOTO exit", "ASK enter"));
  EXPECT_THAT(Goes(*ask_, "PHOTO/SHOOT"), ElementsAre("ASK exit", "PHOTO enter", "SHOOT enter"));
}

TEST_F(HierarchyTest, LeavesAndReentersAStateAroundItThatIsTheTarget) {
  Make();
  EnterPose();
  EXPECT_THAT(Goes(*pose_, "PHOTO"),
              ElementsAre("POSE exit", "PHOTO exit", "PHOTO enter", "POSE enter"));
  EXPECT_THAT(Goes(*pose_, "SHOW"),
              ElementsAre("POSE exit", "PHOTO exit", "SHOW exit", "SHOW enter", "ASK enter"));
}

TEST_F(HierarchyTest, LeavesAndReentersAStateThatGoesIntoItself) {
  Make();
  EnterPose();
  show_->decide = [this](const Tick&) {
    show_->decide = nullptr;
    return Next::To(into_photo_);
  };
  EXPECT_THAT(TickLog(), ElementsAre("POSE exit", "PHOTO exit", "SHOW exit", "SHOW enter",
                                     "PHOTO enter", "SHOOT enter"));
}

// SHOOT is in the machine of POSE, so that the way over its path leaves no more than POSE.
TEST_F(HierarchyTest, APathToAStateOfTheSameMachineIsAPlainTransition) {
  Make();
  EnterPose();
  EXPECT_THAT(Goes(*pose_, "SHOW/PHOTO/SHOOT"), ElementsAre("POSE exit", "SHOOT enter"));
}

TEST_F(HierarchyTest, AGradualTransitionRunsInTheStateThatDecidedIt) {
  Make();
  EnterPose();
  pose_->Go("WALK/TURN", 2 * kStep);
  EXPECT_THAT(TickLog(), ElementsAre("POSE transition"));
  EXPECT_THAT(TickLog(), ElementsAre("POSE transition"));
  EXPECT_THAT(TickLog(),
              ElementsAre("POSE exit", "PHOTO exit", "SHOW exit", "WALK enter", "TURN enter"));
}

TEST_F(HierarchyTest, AGradualTransitionIsRestored) {
  Make();
  EnterPose();
  pose_->Go("WALK/TURN", 2 * kStep);
  Run();
  const Result<Snapshot> saved = machine_.Save();
  ASSERT_TRUE(saved);
  ASSERT_TRUE(machine_.Stop());
  ASSERT_THAT(machine_.Restore(saved.value(), now_), IsEmpty());
  Run(2);
  EXPECT_EQ(machine_.Path(), "WALK/TURN");
}

TEST_F(HierarchyTest, HasTheCommandOfTheInnerStateInTheHistoryOfTheOuterMachine) {
  Make();
  EnterPose();
  pose_->check = [this](const Tick& tick) {
    if (tick.command == kNoEvent) return Next::Stay();
    pose_->Go("IDLE");
    return pose_->CheckTransition({});
  };
  ASSERT_TRUE(machine_.Send("stop"));
  Run();
  EXPECT_EQ(machine_.Path(), "IDLE");
  EXPECT_EQ(machine_.Name(machine_.history().back().command), "stop");
  EXPECT_EQ(machine_.counts().unhandled + photo_->counts().unhandled, 0U);
}

TEST_F(HierarchyTest, AnUnsafeMachineIsInItsSafeStateAtTheEndOfTheTick) {
  Make();
  EnterPose();
  pose_->on["exit"] = [this](const Tick&) { safe_ = false; };
  EXPECT_THAT(Goes(*pose_, "WALK/TURN"),
              ElementsAre("POSE exit", "PHOTO exit", "SHOW exit", "WALK enter", "TURN enter",
                          "TURN exit", "WALK exit", "SAFE enter"));
}

TEST_F(HierarchyTest, AFailureOnTheWayInLeadsToTheSafeStateAndTheNextEntryIsFromTheStart) {
  Make();
  show_->state().on["enter"] = [](const Tick&) { throw std::runtime_error("no arm"); };
  EXPECT_THAT(Goes(*idle_, "SHOW/PHOTO/SHOOT"),
              ElementsAre("IDLE exit", "SHOW enter", "SAFE enter"));
  show_->state().on.clear();
  ASSERT_TRUE(machine_.Force("SHOW"));
  EXPECT_EQ(machine_.Path(), "SHOW/ASK");
}

TEST_F(HierarchyTest, DrawsTransitionsBetweenMachines) {
  Make();
  const std::string dot = ToDot(machine_.chart());
  EXPECT_THAT(dot, HasSubstr("\n  s0 -> s1_1_1 [label=\"commanded\"];\n"));
  EXPECT_THAT(dot, HasSubstr("\n  s1_1_0 -> s0 [label=\"commanded\"];\n"));
  EXPECT_THAT(dot, HasSubstr("\n  s1_1_0 -> s1_start [label=\"commanded\", lhead=cluster_s1];\n"));
  const std::string mermaid = ToMermaid(machine_.chart());
  EXPECT_THAT(mermaid, HasSubstr("\n  s1_1_0 --> s2_1 : commanded\n"));
}

TEST_F(HierarchyFixture, AStateInsideThatOnlyLeavesItsMachineIsNoDeadEnd) {
  auto show = NewMachine("inside");
  Add(*show, "ASK", {"TELL"});
  Add(*show, "TELL", {"IDLE"});
  Add("IDLE", {"SHOW/TELL"});
  AddNested(machine_, "SHOW", std::move(show), "ASK");
  Start("IDLE");
  EXPECT_THAT(machine_.warnings(), IsEmpty());
}

TEST_F(HierarchyFixture, AnUnknownPathIsAnErrorOfBuild) {
  auto show = NewMachine("inside");
  Add(*show, "ASK", {"/SHOW/NOWHERE"});
  Add("IDLE", {"SHOW/ASK/DEEPER"});
  AddNested(machine_, "SHOW", std::move(show), "ASK");
  const Result<> built = machine_.Build("IDLE");
  ASSERT_FALSE(built);
  EXPECT_THAT(built.error().message, HasSubstr("show: IDLE: there is no state SHOW/ASK/DEEPER"));
  EXPECT_THAT(built.error().message, HasSubstr("ASK: there is no state /SHOW/NOWHERE"));
}

TEST_F(HierarchyFixture, ATransitionBelongsToTheStateThatDeclaredIt) {
  auto show = NewMachine("inside");
  Add(*show, "ASK", {"IDLE"});
  LoggingState& idle = Add("IDLE", {"SHOW/ASK"});
  LoggingState& other = Add("OTHER", {"IDLE", "SHOW/ASK"});
  StateId of_other = kNoState;
  AddNested(machine_, "SHOW", std::move(show), "ASK");
  Start("IDLE");
  other.check = [](const Tick&) { return Next::Stay(); };
  of_other = static_cast<StateId>(machine_.chart().states.size() + 1);
  idle.check = [&](const Tick&) { return Next::To(of_other); };
  Run();
  EXPECT_EQ(machine_.Describe(*machine_.fault()),
            "IDLE: CheckTransition: it went to SHOW/ASK, which it has not declared");
}

// SHOW with ASK and PHOTO, and in PHOTO POSE and SHOOT; IDLE enters it in three ways.
class HistoryTest : public HierarchyFixture {
 protected:
  void Make(Machine& machine) {
    auto photo = NewMachine("photo");
    pose_ = &Add(*photo, "POSE", {"SHOOT"});
    Add(*photo, "SHOOT", {"POSE"});
    auto show = NewMachine("inside");
    ask_ = &Add(*show, "ASK", {"PHOTO"});
    AddNested(*show, "PHOTO", std::move(photo), "POSE").declare = [](Transitions& transitions) {
      transitions.To("ASK", "later");
    };
    auto idle = std::make_unique<LoggingState>("IDLE", log_);
    idle_ = idle.get();
    idle_->declare = [this](Transitions& transitions) {
      by_start_ = transitions.To("SHOW", "from its start");
      by_history_ = transitions.To("SHOW", "on", Into::kHistory);
      by_deep_history_ = transitions.To("SHOW", "on deep", Into::kDeepHistory);
    };
    machine.Add("IDLE", std::move(idle));
    AddNested(machine, "SHOW", std::move(show), "ASK").declare = [](Transitions& transitions) {
      transitions.To("IDLE", "later");
    };
  }
  // To SHOW/PHOTO/SHOOT, and back to IDLE.
  void BeInShoot() {
    EnterBy(by_start_);
    ask_->Go("PHOTO");
    Run();
    pose_->Go("SHOOT");
    Run();
    ASSERT_EQ(machine_.Path(), "SHOW/PHOTO/SHOOT");
    ASSERT_TRUE(machine_.Force("IDLE"));
  }
  Log EnterBy(StateId way) {
    idle_->check = [this, way](const Tick&) {
      idle_->check = nullptr;
      return Next::To(way);
    };
    return TickLog();
  }

  LoggingState* idle_ = nullptr;
  LoggingState* ask_ = nullptr;
  LoggingState* pose_ = nullptr;
  StateId by_start_ = kNoState;
  StateId by_history_ = kNoState;
  StateId by_deep_history_ = kNoState;
};

TEST_F(HistoryTest, ShallowHistoryEntersTheStateThatWasLeftAndItsStart) {
  Make(machine_);
  Start("IDLE");
  BeInShoot();
  EXPECT_THAT(EnterBy(by_history_),
              ElementsAre("IDLE exit", "SHOW enter", "PHOTO enter", "POSE enter"));
}

TEST_F(HistoryTest, DeepHistoryEntersTheInnermostStateThatWasLeft) {
  Make(machine_);
  Start("IDLE");
  BeInShoot();
  EXPECT_THAT(EnterBy(by_deep_history_),
              ElementsAre("IDLE exit", "SHOW enter", "PHOTO enter", "SHOOT enter"));
}

TEST_F(HistoryTest, AnEntryWithoutHistoryBeginsAtTheStart) {
  Make(machine_);
  Start("IDLE");
  BeInShoot();
  EXPECT_THAT(EnterBy(by_start_), ElementsAre("IDLE exit", "SHOW enter", "ASK enter"));
}

TEST_F(HistoryTest, TheFirstEntryByHistoryBeginsAtTheStart) {
  Make(machine_);
  Start("IDLE");
  EXPECT_THAT(EnterBy(by_deep_history_), ElementsAre("IDLE exit", "SHOW enter", "ASK enter"));
}

TEST_F(HistoryTest, IsDrawnAsACircle) {
  Make(machine_);
  Start("IDLE");
  const std::string dot = ToDot(machine_.chart());
  EXPECT_THAT(dot, HasSubstr("subgraph cluster_s1 { s1_deep [shape=circle, label=\"H*\"] };"));
  EXPECT_THAT(dot, HasSubstr("s0 -> s1_deep [label=\"on deep\"];"));
  EXPECT_THAT(dot, HasSubstr("s0 -> s1_history [label=\"on\"];"));
  EXPECT_THAT(ToMermaid(machine_.chart()), HasSubstr("s0 --> s1 : on deep (H*)\n"));
}

TEST_F(HistoryTest, IsRestored) {
  Make(machine_);
  Start("IDLE");
  BeInShoot();
  const Result<Snapshot> saved = machine_.Save();
  ASSERT_TRUE(saved);
  Machine other({.name = "show"});
  Make(other);
  ASSERT_TRUE(other.Build("IDLE"));
  ASSERT_THAT(other.Restore(saved.value(), now_), IsEmpty());
  idle_->check = [this](const Tick&) { return Next::To(by_deep_history_); };
  other.RunOnce(now_ + kStep);
  EXPECT_EQ(other.Path(), "SHOW/PHOTO/SHOOT");
}

TEST_F(HierarchyFixture, AStateWithoutAMachineHasNoHistory) {
  auto idle = std::make_unique<LoggingState>("IDLE", log_);
  idle->declare = [](Transitions& transitions) { transitions.To("WAIT", "on", Into::kHistory); };
  machine_.Add("IDLE", std::move(idle));
  Add("WAIT", {"IDLE"});
  const Result<> built = machine_.Build("IDLE");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message, "show: IDLE: WAIT holds no machine, and has no history");
}

// SHOW with the machines "arms" (WAVE, DOWN) and "face" (SMILE, SLEEP).
class RegionTest : public HierarchyFixture {
 protected:
  void Make(Role role = Role::kNormal, Nested::Options options = {}) {
    auto arms = NewMachine("arms");
    auto face = NewMachine("face");
    for (Machine* machine : {&machine_, arms.get(), face.get()}) machine->AddEvent("go");
    face->AddEvent("only face");
    machine_.AddEvent("only face");
    wave_ = &Add(*arms, "WAVE", {"DOWN", "IDLE", "SHOW/SLEEP"});
    down_ = &Add(
        *arms, "DOWN",
        role == Role::kFinal ? std::vector<std::string>{} : std::vector<std::string>{"WAVE"}, role);
    smile_ = &Add(*face, "SMILE", {"SLEEP", "IDLE"});
    sleep_ =
        &Add(*face, "SLEEP",
             role == Role::kFinal ? std::vector<std::string>{} : std::vector<std::string>{"SMILE"},
             role);
    idle_ = &Add("IDLE", {"SHOW", "SHOW/SLEEP"});
    std::vector<Nested::Region> regions;
    regions.push_back({std::move(arms), "WAVE"});
    regions.push_back({std::move(face), "SMILE"});
    AddNested(machine_, "SHOW", std::move(regions), std::move(options));
    Start("IDLE");
  }
  void Enter() {
    idle_->Go("SHOW");
    Run();
    log_.clear();
  }

  LoggingState* idle_ = nullptr;
  LoggingState* wave_ = nullptr;
  LoggingState* down_ = nullptr;
  LoggingState* smile_ = nullptr;
  LoggingState* sleep_ = nullptr;
};

TEST_F(RegionTest, RunSideBySide) {
  Make();
  idle_->Go("SHOW");
  EXPECT_THAT(TickLog(), ElementsAre("IDLE exit", "SHOW enter", "WAVE enter", "SMILE enter"));
  EXPECT_EQ(machine_.Path(), "SHOW/(WAVE|SMILE)");
  EXPECT_THAT(TickLog(), ElementsAre("WAVE run", "SMILE run"));
  wave_->Go("DOWN");
  EXPECT_THAT(TickLog(), ElementsAre("WAVE exit", "DOWN enter", "SMILE run"));
  EXPECT_EQ(machine_.Path(), "SHOW/(DOWN|SMILE)");
}

TEST_F(RegionTest, AreAllLeftWhenOneOfThemLeavesTheState) {
  Make();
  Enter();
  wave_->Go("IDLE");
  EXPECT_THAT(TickLog(), ElementsAre("SMILE exit", "WAVE exit", "SHOW exit", "IDLE enter"));
  Enter();
  smile_->Go("IDLE");
  EXPECT_THAT(TickLog(),
              ElementsAre("WAVE run", "SMILE exit", "WAVE exit", "SHOW exit", "IDLE enter"));
}

TEST_F(RegionTest, AreEnteredAtTheTargetAndElseAtTheirStart) {
  Make();
  idle_->Go("SHOW/SLEEP");
  EXPECT_THAT(TickLog(), ElementsAre("IDLE exit", "SHOW enter", "WAVE enter", "SLEEP enter"));
}

TEST_F(RegionTest, ATransitionFromOneToAnotherReentersTheState) {
  Make();
  Enter();
  wave_->Go("SHOW/SLEEP");
  EXPECT_THAT(TickLog(), ElementsAre("SMILE exit", "WAVE exit", "SHOW exit", "SHOW enter",
                                     "WAVE enter", "SLEEP enter"));
}

TEST_F(RegionTest, ACommandGoesToAllThatHaveIt) {
  Make();
  Enter();
  std::vector<std::string> got;
  wave_->check = [&](const Tick& tick) {
    if (tick.command != kNoEvent) got.emplace_back("arms");
    return Next::Handle();
  };
  smile_->check = [&](const Tick& tick) {
    if (tick.command != kNoEvent) got.emplace_back("face");
    return Next::Handle();
  };
  ASSERT_TRUE(machine_.Send("go"));
  Run();
  EXPECT_THAT(got, ElementsAre("arms", "face"));
  ASSERT_TRUE(machine_.Send("only face"));
  Run();
  EXPECT_THAT(got, ElementsAre("arms", "face", "face"));
}

TEST_F(RegionTest, AreFinishedOnceAllAre) {
  Make(Role::kFinal, {.finished = "IDLE"});
  Enter();
  wave_->Go("DOWN");
  Run(3);
  EXPECT_EQ(machine_.Path(), "SHOW/(DOWN|SMILE)");
  smile_->Go("SLEEP");
  Run(2);
  EXPECT_EQ(machine_.Path(), "IDLE");
}

TEST_F(RegionTest, AreDrawnSideBySideWithTheirPresentStates) {
  Make();
  Enter();
  const std::string dot = ToDot(machine_.chart(), machine_.Path());
  EXPECT_THAT(dot, HasSubstr("subgraph cluster_s1_region1 {\n"
                             "      graph [label=\"face\", style=\"dashed\"];\n"));
  EXPECT_THAT(dot, HasSubstr("s1_0 [label=\"WAVE\", fillcolor=gold, penwidth=2]"));
  EXPECT_THAT(dot, HasSubstr("s1_r1_0 [label=\"SMILE\", fillcolor=gold, penwidth=2]"));
  const std::string mermaid = ToMermaid(machine_.chart(), machine_.Path());
  EXPECT_THAT(mermaid, HasSubstr("    --\n    state \"SMILE\" as s1_r1_0\n"));
  EXPECT_THAT(mermaid, HasSubstr("class s1_r1_0 present\n"));
}

TEST_F(RegionTest, AreSavedAndRestored) {
  Make();
  Enter();
  smile_->Go("SLEEP");
  Run();
  Result<Snapshot> saved = machine_.Save();
  ASSERT_TRUE(saved);
  EXPECT_EQ(saved.value().inside[1].state, "SHOW/face");
  ASSERT_TRUE(machine_.Stop());
  ASSERT_THAT(machine_.Restore(saved.value(), now_), IsEmpty());
  EXPECT_EQ(machine_.Path(), "SHOW/(WAVE|SLEEP)");
  ASSERT_TRUE(machine_.Stop());
  saved.value().inside[1].state = "SHOW/legs";
  const auto faults = machine_.Restore(saved.value(), now_);
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_EQ(faults[1].what, "SHOW holds no such machine");
}

TEST_F(HierarchyFixture, RegionsWithStatesOfTheSameNameAreAnErrorOfBuild) {
  std::vector<Nested::Region> regions;
  for (const char* name : {"arms", "face"}) {
    auto machine = NewMachine(name);
    Add(*machine, "WAIT");
    regions.push_back({std::move(machine), "WAIT"});
  }
  AddNested(machine_, "SHOW", std::move(regions));
  const Result<> built = machine_.Build("SHOW");
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().message, "show: SHOW: both arms and face have a state WAIT");
}

}  // namespace musher::fsm::hierarchy_test
