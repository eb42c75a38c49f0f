// The referee: zones, their order, feet on lines. The robot is placed, and walks, by the test.

#include "musher/modules/world/simulation/referee.hpp"

#include <gmock/gmock.h>

#include "musher/modules/world/simulation/referee_report.hpp"
#include "musher/test/modules/world/scenes.hpp"

namespace musher::world::referee_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Zone ZoneAt(const std::string& name, double x, bool lie = false) {
  return {name, {x, 0}, {0.5, 0.5}, 0, lie};
}

// A passes, B is to lie in, C passes.
Scene ThreeZones() {
  Scene scene = EmptyYard();
  scene.zones = {ZoneAt("A", 1), ZoneAt("B", 3, true), ZoneAt("C", 5)};
  scene.referee.order = {"A", "B", "C"};
  return scene;
}

// The robot is there a second later.
class RefereeTest : public ::testing::Test {
 protected:
  void Watch(const Scene& scene) {
    scene_ = scene;
    referee_.emplace(scene_, RobotSeen{});
  }
  void Go(double x, double y = 0, bool lies = false, double yaw_rad = 0) {
    now_ += Seconds(1);
    referee_->Step(scene_, {{{x, y}, yaw_rad}, lies, false}, now_);
  }
  std::vector<std::string> Visited() const {
    std::vector<std::string> names;
    for (const ZoneVisit& visit : referee_->visits())
      names.push_back(scene_.zones[visit.zone].name);
    return names;
  }
  ZonesInOrder Compared() const { return CompareZones(scene_, referee_->visits()); }

  Scene scene_;
  std::optional<Referee> referee_;
  Duration now_{};
};

TEST_F(RefereeTest, FinishesWhenTheZonesWereReachedInTheirOrder) {
  Watch(ThreeZones());
  Go(1);
  Go(3, 0, true);
  EXPECT_FALSE(referee_->finished());
  Go(5);
  EXPECT_EQ(referee_->finished(), Seconds(3));
  EXPECT_THAT(Visited(), ElementsAre("A", "B", "C"));
  EXPECT_THAT(Compared().in_order, ElementsAre(true, true, true));
}

TEST_F(RefereeTest, CountsAZoneToLieInOnlyWhenTheWholeBodyLiesInIt) {
  Watch(ThreeZones());
  Go(1);
  Go(3);
  EXPECT_THAT(Visited(), ElementsAre("A")) << "stands in it";
  Go(3.25, 0, true);
  EXPECT_THAT(Visited(), ElementsAre("A")) << "its nose is outside";
  Go(3.2, 0, true, M_PI / 2);
  EXPECT_THAT(Visited(), ElementsAre("A", "B"));
}

TEST_F(RefereeTest, ReportsAZoneThatWasLeftOutAndTheOnesAhead) {
  Watch(ThreeZones());
  Go(1);
  EXPECT_THAT(Compared().ahead, ElementsAre("B", "C"));
  EXPECT_THAT(Compared().missing, IsEmpty());
  Go(5);
  EXPECT_FALSE(referee_->finished());
  EXPECT_THAT(Compared().missing, ElementsAre("B"));
  EXPECT_THAT(Compared().ahead, IsEmpty());
}

TEST_F(RefereeTest, ReportsWhereItLayOutOfTurnAndForgivesPassingThrough) {
  Watch(ThreeZones());
  Go(3, 0, true);
  Go(1);
  Go(2);
  Go(1);
  EXPECT_THAT(Compared().out_of_turn, ElementsAre("B"));
  EXPECT_THAT(Visited(), ElementsAre("B", "A", "A"));
  EXPECT_THAT(Compared().in_order, ElementsAre(false, true, false));
}

Scene WithLine(double width_m = 0.05) {
  Scene scene = EmptyYard();
  Line line;
  line.points_m = {{1, -5}, {1, 5}};
  line.width_m = width_m;
  line.watched = true;
  scene.lines = {line};
  return scene;
}

TEST_F(RefereeTest, ReportsAFootOnALineWithItsDepth) {
  Watch(WithLine());
  Go(0.7);  // the fore feet at 0.9, 0.075 m before the line
  EXPECT_EQ(referee_->touch_count(), 0U);
  Go(0.765);  // the discs reach 0.985, the line begins at 0.975
  ASSERT_EQ(referee_->touch_count(), 2U);
  const LineTouch& touch = referee_->touches().front();
  EXPECT_STREQ(kFeet.at(touch.foot), "left fore");
  EXPECT_NEAR(touch.depth_m, 0.01, 1e-9);
  EXPECT_NEAR(touch.where_m.y(), 0.15, 1e-9);
  EXPECT_FALSE(touch.whole_foot);
  Go(0.75);
  Go(0.7);
  Go(0.765);
  EXPECT_EQ(referee_->touch_count(), 4U);
  EXPECT_EQ(referee_->whole_foot_count(), 0U);
}

TEST_F(RefereeTest, CountsAFootThatGoesOverALineOnceAndAsAWholeFoot) {
  for (const double width_m : {0.02, 0.05, 0.1}) {
    Watch(WithLine(width_m));
    for (double x = 0.6; x < 1; x += 0.008) Go(x);
    EXPECT_EQ(referee_->touch_count(), 2U) << width_m;
    EXPECT_EQ(referee_->whole_foot_count(), 2U) << width_m;
    EXPECT_TRUE(referee_->touches()[0].whole_foot);
  }
}

TEST_F(RefereeTest, IgnoresOtherLinesAndFeetInTheAir) {
  Scene scene = WithLine();
  scene.lines[0].watched = false;
  Watch(scene);
  Go(0.8);
  EXPECT_EQ(referee_->touch_count(), 0U);
  Watch(WithLine());
  referee_->Step(scene_, {{{0.8, 0}, 0}, false, true}, Seconds(1));
  EXPECT_EQ(referee_->touch_count(), 0U);
}

TEST_F(RefereeTest, CountsTwoLinesThatMeetAsOneTouch) {
  Scene scene = WithLine();
  scene.lines[0].points_m = {{1, -5}, {1, 0.15}};
  scene.lines.push_back(scene.lines[0]);
  scene.lines[1].points_m = {{1, 0.15}, {1, 5}};
  Watch(scene);
  for (double y = -0.1; y < 0.1; y += 0.008) Go(0.8, y);
  EXPECT_EQ(referee_->touch_count(), 2U) << "of the two fore feet";
}

TEST(RefereeOfAWorld, WatchesTheRealBodyFromItsFirstMoveToItsEnd) {
  Scene scene = WithLine();
  scene.start_standing = false;
  scene.name = "lane \"1\"";
  scene.zones = {{"START", {0, 0}, {0.5, 0.5}, 0, true}, {"GOAL", {2, 0}, {0.6, 0.6}, 0, true}};
  scene.referee.order = {"START", "GOAL"};
  scene.boxes = {{"wall", {3, 0}, {0.1, 1}}};
  World world(scene);
  EXPECT_EQ(world.referee().visits().size(), 1U) << "it lies in START";
  Commander commander(world);
  commander.Do(12, 0);
  Pass(world, Seconds(4));
  EXPECT_FALSE(world.referee().began());
  commander.Walk({0.5, 0, 0}, Seconds(4));
  EXPECT_GT(world.referee().began().value_or(Duration{}), Seconds(4));
  EXPECT_EQ(world.referee().touch_count(), 4U);
  commander.Do(7, 1);
  Pass(world, Seconds(4));
  ASSERT_TRUE(world.referee().finished());
  EXPECT_EQ(world.referee().collisions(), 0U);
  const std::string text = RefereeText(world.scene(), world.referee(), world.now());
  EXPECT_THAT(text, HasSubstr("finished after "));
  EXPECT_THAT(text, HasSubstr("reached in order: START (0.0 s), GOAL ("));
  EXPECT_THAT(text, HasSubstr("feet on lines: 4, with the whole foot: 4"));
  const std::string json = RefereeJson(world.scene(), world.referee(), world.now());
  EXPECT_THAT(json, HasSubstr(R"({"name":"lane \"1\"","seed":1,"sampled":{},"finished":true,)"));
  EXPECT_THAT(json, HasSubstr(R"({"zone":"START","at_s":0.00,"in_order":true})"));
  EXPECT_THAT(json, HasSubstr(R"("missing":[],"ahead":[],"out_of_turn":[])"));
  EXPECT_THAT(json, HasSubstr(R"("collisions":0,"moved_by_hand":0})"));
}

TEST(RefereeOfAWorld, BeginsWithTheFirstStepAfterTheRobotWasMovedByHand) {
  World world(EmptyYard());
  EXPECT_FALSE(world.PutDown({{3, 0}, 0}));
  Pass(world, Seconds(1));
  EXPECT_FALSE(world.referee().began());
  Commander(world).Walk({0.5, 0, 0}, Seconds(1));
  EXPECT_TRUE(world.referee().began());
}

TEST(RefereeOfAWorld, CountsCollisionsAndBeingMovedByHandWithoutAFootOnALine) {
  Scene scene = WithLine();
  scene.boxes = {{"wall", {-1, 0}, {0.1, 1}}};
  World world(scene);
  Commander commander(world);
  commander.Walk({-0.5, 0, 0}, Seconds(4));
  EXPECT_EQ(world.referee().collisions(), 1U);
  EXPECT_FALSE(world.PutDown({{3, 0}, 0}));
  EXPECT_EQ(world.referee().carried(), 1U);
  EXPECT_EQ(world.referee().touch_count(), 0U);
  EXPECT_THAT(RefereeText(world.scene(), world.referee(), world.now()),
              HasSubstr("collisions: 1\nmoved by hand: 1"));
}

}  // namespace musher::world::referee_test
