// The decorators of nav2, in virtual time. "a^" is a's first tick, "a" a further one.

#include "musher/behavior/tree/hooks.hpp"
#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::decorators_test {

using testing::HasSubstr;

std::string Around(const std::string& decorator, const std::string& does) {
  return "<" + decorator + ">" + SayXml("a", does) + "</" +
         decorator.substr(0, decorator.find(' ')) + ">";
}
// A decorator that is ticked in each tick, as in the trees of nav2, and is not reset.
std::string InPipeline(const std::string& decorator, const std::string& does) {
  return "<PipelineSequence>" + Around(decorator, does) + "<Say name=\"b\" does=\"R\"/>" +
         "</PipelineSequence>";
}

using ARateController = Nav2Tree;
TEST_F(ARateController, BeginsItsChildOnceAPeriodAfterItsLastSuccess) {
  Make(InPipeline("RateController hz=\"2\"", "S"));
  EXPECT_EQ(TickAt(0), "R a^ b^ ");
  EXPECT_EQ(TickAt(400), "R b ");
  EXPECT_EQ(TickAt(500), "R a^ b ");
  EXPECT_EQ(TickAt(990), "R b ");
  EXPECT_EQ(TickAt(1000), "R a^ b ");
}
TEST_F(ARateController, TicksAChildThatRunsInEachTickAndCountsFromItsEnd) {
  Make(InPipeline("RateController hz=\"10\"", "RRS"));
  EXPECT_EQ(TickAt(0), "R a^ ");
  EXPECT_EQ(TickAt(50), "R a ");
  EXPECT_EQ(TickAt(60), "R a b^ ");
  EXPECT_EQ(TickAt(150), "R b ");
  EXPECT_EQ(TickAt(160), "R a^ b ");
}
TEST_F(ARateController, BeginsAgainAfterAHaltAndFailsWithItsChild) {
  Make(InPipeline("RateController hz=\"1\"", "SF"));
  EXPECT_EQ(TickAt(0), "R a^ b^ ");
  ASSERT_TRUE(tree->Halt(At(10)));
  Take();
  EXPECT_EQ(TickAt(20), "F a^ ");
  EXPECT_EQ(TickAt(30), "R a^ b^ ");
}
TEST_F(ARateController, RefusesARateThatIsNotAbove0) {
  Make(InPipeline("RateController hz=\"0\"", "S"));
  EXPECT_EQ(TickAt(0), "! ");
  EXPECT_THAT(fault, HasSubstr("port 'hz' has to be above 0"));
}

using ADistanceController = Nav2Tree;
TEST_F(ADistanceController, BeginsItsChildEachTimeTheRobotHasTravelledSoFar) {
  Make(InPipeline("DistanceController distance=\"2\"", "S"));
  EXPECT_EQ(Next(), "R a^ b^ ");
  robot.at->x_m = 1.9;
  EXPECT_EQ(Next(), "R b ");
  robot.at->x_m = 2;
  EXPECT_EQ(Next(), "R a^ b ");
  robot.at->y_m = 1.9;
  EXPECT_EQ(Next(), "R b ") << "counts from where it was";
  robot.at->y_m = 2.1;
  EXPECT_EQ(Next(), "R a^ b ");
}
TEST_F(ADistanceController, FailsWithoutAPose) {
  Make(InPipeline("DistanceController", "R"));
  EXPECT_EQ(Next(), "R a^ ");
  robot.at.reset();
  EXPECT_EQ(Next(), "F a! ");
  EXPECT_EQ(Next(), "F ");
}

using ASpeedController = Nav2Tree;
TEST_F(ASpeedController, BeginsItsChildTheMoreOftenTheFasterTheRobotIs) {
  Make(InPipeline("SpeedController min_rate=\"1\" max_rate=\"5\" min_speed=\"0\" max_speed=\"1\"",
                  "S"));
  EXPECT_EQ(TickAt(0), "R a^ b^ ");
  EXPECT_EQ(TickAt(199), "R b ");
  EXPECT_EQ(TickAt(200), "R a^ b ") << "at first with the highest rate; now it stands: 1 s";
  robot.speed = 0.25;
  EXPECT_EQ(TickAt(1199), "R b ");
  EXPECT_EQ(TickAt(1200), "R a^ b ") << "the rate is now 2 Hz";
  EXPECT_EQ(TickAt(1699), "R b ");
  robot.speed = 7;
  EXPECT_EQ(TickAt(1700), "R a^ b ") << "the rate is now 5 Hz, the highest";
  EXPECT_EQ(TickAt(1900), "R a^ b ");
}
TEST_F(ASpeedController, BeginsItsChildAtOnceForANewGoal) {
  Make(InPipeline("SpeedController", "S"));
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(TickAt(0), "R a^ b^ ");
  EXPECT_EQ(TickAt(10), "R b ");
  Put("goal", Pose{.x_m = 2});
  EXPECT_EQ(TickAt(20), "R a^ b ");
  EXPECT_EQ(TickAt(30), "R b ");
}
TEST_F(ASpeedController, RefusesLimitsInTheWrongOrder) {
  Make(InPipeline("SpeedController min_speed=\"1\" max_speed=\"1\"", "S"));
  TickAt(0);
  EXPECT_EQ(TickAt(2000), "! b! ");
  EXPECT_THAT(fault, HasSubstr("min_speed is not below max_speed"));
}

using AGoalUpdatedController = Nav2Tree;
TEST_F(AGoalUpdatedController, BeginsItsChildAtFirstAndForEachNewGoal) {
  Make(InPipeline("GoalUpdatedController", "RS"));
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(NextTicks(3), "R a^ \nR a b^ \nR b \n");
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "R b ") << "the same again";
  Put("goal", Pose{.x_m = 1, .stamp = At(5)});
  EXPECT_EQ(Next(), "R a^ b ") << "the same place, sent again";
  Next();
  Put("goals", Goals{{Pose{}, Pose{.x_m = 3}}});
  EXPECT_EQ(Next(), "R a^ b ");
}
TEST_F(AGoalUpdatedController, ReadsTheEntryThatItsPortNames) {
  Make(InPipeline("GoalUpdatedController goal=\"{other}\"", "S"));
  EXPECT_EQ(NextTicks(2), "R a^ b^ \nR b \n");
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "R b ");
  Put("other", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "R a^ b ");
}

TEST_F(ADistanceController, RefusesADistanceThatIsNoNumber) {
  Make(InPipeline("DistanceController distance=\"nan\"", "S"));
  EXPECT_EQ(Next(), "! ");
  EXPECT_THAT(fault, HasSubstr("port 'distance' has to be a number from 0"));
}

using AGoalUpdater = Nav2Tree;
TEST_F(AGoalUpdater, DoesNotPassAnUpdateOfARunBeforeOnWhereTheGoalHasNoStamp) {
  Make(Around("GoalUpdater input_goal=\"{goal}\" output_goal=\"{to}\"", "RS"));
  const auto to = [this] { return tree->board().Get<Pose>("to").value().x_m; };
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "R a^ ");
  robot.new_goal = Pose{.x_m = 2};
  EXPECT_EQ(Next(), "S a ");
  EXPECT_EQ(to(), 2);
  Put("goal", Pose{.x_m = 3});
  EXPECT_EQ(Next(), "R a^ ");
  EXPECT_EQ(to(), 3) << "this goal was commanded after the update";
  robot.new_goal = Pose{.x_m = 4};
  EXPECT_EQ(Next(), "S a ");
  EXPECT_EQ(to(), 4);
}
TEST_F(AGoalUpdater, PassesTheGoalOnOrANewerOneOfItsTopic) {
  Make(
      Around("GoalUpdater input_goal=\"{goal}\" output_goal=\"{to}\" input_goals=\"{goals}\" "
             "output_goals=\"{all}\"",
             "R"));
  const auto to = [this] { return tree->board().Get<Pose>("to").value().x_m; };
  Put("goal", Pose{.x_m = 1, .stamp = At(100)});
  Put("goals", Goals{{Pose{.x_m = 5}}});
  EXPECT_EQ(Next(), "R a^ ");
  EXPECT_EQ(to(), 1);
  EXPECT_EQ(tree->board().Get<Goals>("all").value().poses[0].x_m, 5);
  robot.new_goal = Pose{.x_m = 2, .stamp = At(99)};
  EXPECT_EQ(Next(), "R a ");
  EXPECT_EQ(to(), 1) << "an older one does not count";
  robot.new_goal->stamp = At(101);
  robot.new_goals = Goals{{Pose{.x_m = 6}}};
  EXPECT_EQ(Next(), "R a ");
  EXPECT_EQ(to(), 2);
  EXPECT_EQ(tree->board().Get<Goals>("all").value().poses[0].x_m, 6);
}

TEST_F(AGoalUpdater, PassesAnUpdateOnInTheNextRunUnlessAGoalWasSetSince) {
  Make(Around("GoalUpdater input_goal=\"{goal}\" output_goal=\"{to}\"", "RF"));
  const auto to = [this] { return tree->board().Get<Pose>("to").value().x_m; };
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "R a^ ");
  robot.new_goal = Pose{.x_m = 2};
  EXPECT_EQ(Next(), "F a ");
  EXPECT_EQ(Next(), "R a^ ") << "the program runs the tree again";
  EXPECT_EQ(to(), 2);
  Put("goal", Pose{.x_m = 3});
  EXPECT_EQ(Next(), "F a ");
  EXPECT_EQ(Next(), "R a^ ");
  EXPECT_EQ(to(), 3);
  Make(Around("GoalUpdater input_goal=\"{goal}\" output_goal=\"{goal}\"", "RF"));
  Put("goal", Pose{.x_m = 1});
  robot.new_goal.reset();
  EXPECT_EQ(Next(), "R a^ ");
  robot.new_goal = Pose{.x_m = 2};
  EXPECT_EQ(NextTicks(2), "F a \nR a^ \n");
  EXPECT_EQ(tree->board().Get<Pose>("goal").value().x_m, 2);
}
TEST_F(AGoalUpdater, PassesAGoalOnThatIsSetWhileTheTreeRuns) {
  Make(Around("GoalUpdater input_goal=\"{goal}\" output_goal=\"{to}\"", "R"));
  const auto to = [this] { return tree->board().Get<Pose>("to").value().x_m; };
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "R a^ ");
  robot.new_goal = Pose{.x_m = 2};
  EXPECT_EQ(Next(), "R a ");
  EXPECT_EQ(to(), 2);
  Put("goal", Pose{.x_m = 3});
  EXPECT_EQ(Next(), "R a ");
  EXPECT_EQ(to(), 3) << "it was set after the update";
  EXPECT_EQ(Next(), "R a ");
  EXPECT_EQ(to(), 3);
  robot.new_goal = Pose{.x_m = 4};
  EXPECT_EQ(Next(), "R a ");
  EXPECT_EQ(to(), 4);
}
TEST_F(AGoalUpdater, PassesAnUpdateOnInTheNextRunThatCameAfterAGoalOfTheRunBefore) {
  Make(Around("GoalUpdater input_goal=\"{goal}\" output_goal=\"{to}\"", "RRF"));
  const auto to = [this] { return tree->board().Get<Pose>("to").value().x_m; };
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "R a^ ");
  Put("goal", Pose{.x_m = 3});
  EXPECT_EQ(Next(), "R a ");
  robot.new_goal = Pose{.x_m = 4};
  EXPECT_EQ(Next(), "F a ");
  EXPECT_EQ(to(), 4);
  EXPECT_EQ(Next(), "R a^ ");
  EXPECT_EQ(to(), 4);
}
TEST_F(AGoalUpdater, FailsWithoutAGoalAndDoesNotPassTheUpdateOfARunBeforeOn) {
  for (const std::string input : {"", "input_goal=\"{goal}\" input_goals=\"{goals}\" "}) {
    robot.new_goal.reset();
    Make(Around("GoalUpdater " + input + "output_goal=\"{to}\"", "RS"));
    EXPECT_EQ(Next(), "F ");
    robot.new_goal = Pose{.x_m = 2};
    EXPECT_EQ(NextTicks(2), "R a^ \nS a \n");
    EXPECT_EQ(NextTicks(2), "F \nF \n");
    robot.new_goal = Pose{.x_m = 3};
    EXPECT_EQ(NextTicks(2), "R a^ \nS a \n");
    EXPECT_EQ(tree->board().Get<Pose>("to").value().x_m, 3);
  }
}

using PacedNodes = Nav2Tree;
TEST_F(PacedNodes, StartAChildThatABreakpointHasHeldOnceItIsReleased) {
  for (const std::string decorator : {"RateController hz=\"1\"", "DistanceController",
                                      "SpeedController", "GoalUpdatedController"}) {
    now_ms = 0;
    Make(InPipeline(decorator, "RS"));
    const auto hooks = std::make_shared<Hooks>();
    hooks->Set({.node = 2});
    tree->Attach(hooks);
    EXPECT_EQ(NextTicks(2), "R \nR \n") << decorator;
    EXPECT_TRUE(hooks->Release(2, Status::kSkipped, true));
    EXPECT_EQ(NextTicks(3), "R a^ \nR a b^ \nR b \n") << decorator;
  }
}

struct APathLongerOnApproach : Nav2Tree {
  // In a reactive control, which resets it in each tick, as in nav2's tree with that node.
  void Follow(const std::string& does) {
    Make("<ReactiveSequence>" +
         Around("PathLongerOnApproach path=\"{path}\" prox_len=\"3\" length_factor=\"2\"", does) +
         SayXml("b", "R") + "</ReactiveSequence>");
  }
};
TEST_F(APathLongerOnApproach, TicksItsChildWhereThePathIsMuchLongerNearTheGoal) {
  Follow("RS");
  Put("path", Straight(2.9));
  EXPECT_EQ(NextTicks(2), "R b^ \nR b \n");
  Path around{{Pose{}, Pose{.y_m = 3}, Pose{.x_m = 2.9}}};
  Put("path", around);
  EXPECT_EQ(NextTicks(3), "R a^ b! \nR a b^ \nR b \n");
}
TEST_F(APathLongerOnApproach, HaltsItsChildOnceThePathIsNotLongerAnyMore) {
  Follow("R");
  Put("path", Straight(2.9));
  EXPECT_EQ(Next(), "R b^ ");
  Put("path", Path{{Pose{}, Pose{.y_m = 3}, Pose{.x_m = 2.9}}});
  EXPECT_EQ(NextTicks(2), "R a^ b! \nR a \n");
  Put("path", Straight(2.9));
  EXPECT_EQ(Next(), "R a! b^ ") << "the way is free again";
  Put("path", Path{{Pose{}, Pose{.y_m = 3}, Pose{.x_m = 2.9}}});
  EXPECT_EQ(Next(), "R a^ b! ");
  Put("path", Path{});
  EXPECT_EQ(Next(), "R a! b^ ") << "there is no path";
}
TEST_F(APathLongerOnApproach, DoesNotForOtherPaths) {
  Follow("R");
  Put("path", Straight(3.1));
  EXPECT_EQ(Next(), "R b^ ");
  Put("path", Path{{Pose{}, Pose{.y_m = 5}, Pose{.x_m = 3.1}}});
  EXPECT_EQ(Next(), "R b ") << "the goal is not near";
  Put("path", Straight(2));
  Next();
  Put("path", Path{{Pose{}, Pose{.y_m = 0.1}, Pose{.x_m = 2}}});
  EXPECT_EQ(Next(), "R b ") << "it is not twice as long";
  Put("path", Straight(9));
  EXPECT_EQ(Next(), "R b ") << "another goal";
}
TEST_F(APathLongerOnApproach, DoesNotCompareWithThePathOfARunBefore) {
  Follow("R");
  Put("path", Straight(2));
  EXPECT_EQ(Next(), "R b^ ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  Take();
  Put("path", Path{{Pose{}, Pose{.y_m = 5}, Pose{.x_m = 2}}});
  EXPECT_EQ(Next(), "R b^ ");
}

using ASingleTrigger = Nav2Tree;
TEST_F(ASingleTrigger, TicksItsChildUntilItHasEndedOnceAndFailsFromThenOn) {
  Make("<PipelineSequence><Inverter><Inverter>" + Around("SingleTrigger", "RS") +
       "</Inverter></Inverter>" + SayXml("b", "R") + "</PipelineSequence>");
  EXPECT_EQ(NextTicks(2), "R a^ \nR a b^ \n");
  Make("<PipelineSequence><Fallback>" + Around("SingleTrigger", "RS") + "</Fallback>" +
       SayXml("b", "R") + "</PipelineSequence>");
  EXPECT_EQ(NextTicks(2), "R a^ \nR a b^ \n");
  Make("<PipelineSequence>" + Around("SingleTrigger", "RS") + SayXml("b", "R") +
       "</PipelineSequence>");
  EXPECT_EQ(NextTicks(3), "R a^ \nR a b^ \nF b! \n");
  EXPECT_EQ(Next(), "R a^ ") << "after the end of its parent it begins again";
}

}  // namespace musher::tree::nav2::decorators_test
