// The arm, the spear, the partner and the boxes of a field, and its report.

#include "musher/modules/world/simulation/field.hpp"

#include <gmock/gmock.h>

#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/modules/world/simulation/field_report.hpp"
#include "musher/test/modules/world/climber.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::field_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using Where = KfsBox::Where;

// A box ahead on the same level, at 1.0 m, as in a fetch.
FieldSpec FieldWithBoxes(const std::vector<double>& heights_mm) {
  FieldSpec field = Stairs(heights_mm);
  for (int row = 1; row < field.rows; ++row) {
    field.boxes.push_back({"box_" + std::to_string(row), KfsKind::kKfs2, {row, 0}});
  }
  field.robot.start_m.x() = 0.2;
  return field;
}

TEST(FieldArm, TakesTheBoxAheadAfterItsTimeAndIsDoneThen) {
  Climber climber(FieldWithBoxes({0, 0}));
  EXPECT_FALSE(climber.field().CommandArm(1, climber.now()));
  climber.For(2.9);
  EXPECT_FALSE(climber.field().arm().done);
  EXPECT_EQ(climber.field().boxes()[0].where, Where::kField);
  climber.For(0.12);
  EXPECT_TRUE(climber.field().arm().done);
  EXPECT_EQ(climber.field().boxes()[0].where, Where::kGripper);
}

TEST(FieldArm, IsNeverDoneWithoutABoxInReachAndReportsWhy) {
  FieldSpec field = FieldWithBoxes({0, 0});
  field.robot.start_m.x() = 0;  // 1.2 m from the box
  Climber far(field);
  EXPECT_FALSE(far.field().CommandArm(1, far.now()));
  far.For(20);
  EXPECT_FALSE(far.field().arm().done);
  EXPECT_THAT(far.log(), Contains("arm: command 1 is not done: no box is ahead within 1.10 m"));
  field.robot.start_m.x() = 0.2;
  field.robot.start_yaw_rad = M_PI / 2;
  Climber turned(field);
  EXPECT_FALSE(turned.field().CommandArm(1, turned.now()));
  turned.For(4);
  EXPECT_FALSE(turned.field().arm().done) << "the box is not in its heading";
}

TEST(FieldArm, ReachesAHigherBoxOnlyWithItsWheelsRaised) {
  Climber climber(FieldWithBoxes({0, 200}));
  EXPECT_FALSE(climber.field().CommandArm(1, climber.now()));
  climber.For(4);
  EXPECT_FALSE(climber.field().arm().done);
  EXPECT_THAT(climber.field().arm().result, HasSubstr("box_1 is 210 mm higher than the arm"));
  climber.Lift(230);
  climber.For(1);
  EXPECT_FALSE(climber.field().CommandArm(1, climber.now()));
  climber.For(4);
  EXPECT_TRUE(climber.field().arm().done);
}

TEST(FieldArm, PutsAHeldBoxIntoTheBodyForTheNextOneAndPlacesThemInTurn) {
  FieldSpec field = FieldWithBoxes({0, 0, 0, 0});
  field.robot.stores = 1;
  Climber climber(field);
  const auto command = [&](int number) {
    EXPECT_FALSE(climber.field().CommandArm(number, climber.now()));
    climber.For(4);
    return climber.field().arm().done;
  };
  EXPECT_TRUE(command(1));
  ASSERT_FALSE(climber.field().PutDown({1.4, 0}, 0, climber.now()));
  EXPECT_TRUE(command(1));
  EXPECT_EQ(climber.field().boxes()[0].where, Where::kBody);
  ASSERT_FALSE(climber.field().PutDown({2.6, 0}, 0, climber.now()));
  EXPECT_FALSE(command(1));
  EXPECT_EQ(climber.field().arm().result, "the gripper and the body are full");
  EXPECT_FALSE(command(2)) << "the body is full";
  EXPECT_TRUE(command(3));
  EXPECT_TRUE(command(5));
  EXPECT_EQ(climber.field().boxes()[1].where, Where::kMid);
  EXPECT_TRUE(command(4));
  EXPECT_EQ(climber.field().boxes()[0].where, Where::kGripper);
  EXPECT_TRUE(command(6));
  EXPECT_EQ(climber.field().boxes()[0].where, Where::kHigh);
  EXPECT_FALSE(command(5));
  EXPECT_EQ(climber.field().arm().result, "there is no box to place");
  EXPECT_TRUE(command(0));
}

TEST(FieldArm, TakesTheSameCommandForARepetitionWhileItIsBusyOrJustDone) {
  Climber climber(FieldWithBoxes({0, 0}));
  for (int i = 0; i < 155; ++i) {  // 3.1 s
    EXPECT_FALSE(climber.field().CommandArm(1, climber.now()));
    climber.Step();
  }
  EXPECT_TRUE(climber.field().arm().done);
  climber.For(0.3);
  EXPECT_FALSE(climber.field().CommandArm(1, climber.now()));
  EXPECT_FALSE(climber.field().arm().done) << "a new command";
}

TEST(FieldArm, RefusesUnknownCommands) {
  Climber climber(Stairs({0}));
  EXPECT_THAT(climber.field().CommandArm(7, climber.now()).value_or(""),
              "arm: the command 7 is refused: expected a whole number from 0 to 6");
  EXPECT_TRUE(climber.field().CommandArm(1.5, climber.now()));
  EXPECT_TRUE(climber.field().CommandArm(std::nan(""), climber.now()));
  EXPECT_TRUE(climber.field().CommandSpear(5, climber.now()));
}

TEST(FieldArm, IsNeverDoneWhileItIsStuck) {
  Climber climber(FieldWithBoxes({0, 0}));
  climber.faults() = {"arm stuck"};
  EXPECT_FALSE(climber.field().CommandArm(1, climber.now()));
  climber.For(20);
  EXPECT_FALSE(climber.field().arm().done);
  EXPECT_TRUE(climber.field().arm().busy);
}

TEST(FieldSpear, DocksWithThePartnerWhichIsReadyLaterUntilTheRelease) {
  Climber climber(Stairs({0}));
  EXPECT_FALSE(climber.field().CommandSpear(3, climber.now()));
  climber.For(2.1);
  EXPECT_TRUE(climber.field().spear().done);
  EXPECT_FALSE(climber.field().partner_ready());
  climber.For(3);
  EXPECT_TRUE(climber.field().partner_ready());
  EXPECT_FALSE(climber.field().CommandSpear(4, climber.now()));
  climber.For(2.1);
  EXPECT_FALSE(climber.field().partner_ready());
}

TEST(Field, HasBoxesThatTheRobotCannotDriveThrough) {
  FieldSpec field = FieldWithBoxes({0, 0});
  field.robot.start_m.x() = 0;
  Climber climber(field);
  climber.Drive({0.5, 0, 0});
  climber.For(5);
  EXPECT_NEAR(climber.robot().position_m().x(), 1.2 - kKfsSizeM / 2 - kLiftHalfM, 0.011);
  EXPECT_EQ(climber.robot().bumps(), 1);
  EXPECT_THAT(climber.log(), Contains(HasSubstr("bumped into the box box_1")));
}

TEST(Field, IsTheSameFromTheSameInputsAndContinuesFromACopy) {
  const auto run = [] {
    Climber climber(FieldWithBoxes({0, 0, 200}));
    climber.Drive({0.3, 0.2, 0.1});
    climber.For(3);
    return climber;
  };
  Climber a = run();
  Climber b = run();
  Climber copy = a;
  a.For(2);
  b.For(2);
  copy.For(2);
  EXPECT_EQ(a.robot().position_m(), b.robot().position_m());
  EXPECT_EQ(a.robot().position_m(), copy.robot().position_m());
  EXPECT_EQ(a.robot().yaw_rad(), b.robot().yaw_rad());
  EXPECT_EQ(a.reading().distances_mm, b.reading().distances_mm);
}

TEST(FieldScene, OfTheRepositoryHasTheHeightsOfBothSides) {
  const std::string path = SourceDir() + "/config/scenes/meilin.toml";
  for (const bool red : {false, true}) {
    SceneRun run;
    if (red) run.chosen["side"] = "red";
    const SceneReading reading = ReadSceneFile(path, run);
    ASSERT_TRUE(reading.scene && reading.scene->field);
    const FieldSpec& field = *reading.scene->field;
    EXPECT_EQ(field.side, red ? "red" : "blue");
    EXPECT_EQ(field.HeightMm(FieldCell{2, 0}), red ? 200 : 600);
    EXPECT_EQ(field.HeightMm(FieldCell{2, 2}), red ? 600 : 200);
    EXPECT_EQ(field.HeightMm(FieldCell{6, 0}), 0) << "outside of the grid";
    EXPECT_EQ(field.HeightMm(Eigen::Vector2d(1.2 + 3.59, 1.2 + 0.61)), 600) << "row 3, column 1";
    EXPECT_EQ(field.boxes.size(), 5u);
  }
}

TEST(FieldReport, HasPoseWheelsToolsBoxesAndEvents) {
  Scene scene = ReadSceneFile(SourceDir() + "/config/scenes/meilin.toml").scene.value();
  World world(scene);
  EXPECT_FALSE(world.CommandSpear(3));
  Pass(world, std::chrono::seconds(6));
  EXPECT_FALSE(world.PutDown({{1.2, 2.4}, 0}));
  const std::string report = FieldJson(world);
  for (const char* part :
       {R"("side":"blue","time_s":6.00,"pose":{"x_m":1.200,"y_m":2.400,"yaw_rad":0.0000})",
        R"("cell":[0,1],"platform_mm":0,"height_mm":20.0,"wheels_mm":[20.0,20.0,20.0,20.0])",
        R"("bumps":0,"falls":0,"arm":{"command":0,"busy":false,"done":false,"result":""})",
        R"("r1_ready":true,"placed_mid":0,"placed_high":0,"boxes":[{"name":"scroll_a",)",
        R"("kind":"fake","cell":[3,0],"where":"field"})",
        R"({"at_s":2.00,"what":"docked","x_m":0.00,"y_m":0.00,"text":"R1"})"}) {
    EXPECT_THAT(report, HasSubstr(part));
  }
  EXPECT_EQ(FieldJson(World(EmptyYard())), "{}");
}

}  // namespace musher::world::field_test
