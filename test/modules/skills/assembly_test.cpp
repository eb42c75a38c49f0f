// The skill assembly: the held part comes to its place at a station, which is checked, or it fails
// with the reason.

#include <gmock/gmock.h>

#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::assembly_test {

using skill::Numbers;
using skill::Status;
using testing::Bench;
using ::testing::EndsWith;
using testing::Reply;
using ::testing::StartsWith;

class Assembly : public ::testing::Test, public Bench {
 protected:
  Assembly() : Bench("jetbot_0", "jetbot") {
    robot.seen = {{"gear", "part", {{0.3, 0, 0.4}, 0}, "jetbot_0"},
                  {"dock", "station", {{2, 0.5, 0.1}, 0}, ""}};
  }
  skill::Values Parameters() const { return {{"station", "dock"}, {"offset", Numbers{0, 0, 0.1}}}; }
  std::string End() {
    RunOut();
    EXPECT_EQ(robot.command, navigation::Velocity{});
    return feedback().message;
  }
};

TEST_F(Assembly, PutsThePartOnTheStationAndChecksThatItStandsThere) {
  Start("assembly", Parameters());
  EXPECT_EQ(End(), "Assembled: gear stands at dock");
  EXPECT_EQ(feedback().status, Status::kCompleted);
  EXPECT_EQ(robot.Held(), "");
  const navigation::Point& gear = robot.Object("gear").pose.at;
  EXPECT_NEAR(gear.x_m, 2, 0.02);
  EXPECT_NEAR(gear.y_m, 0.5, 0.02);
  EXPECT_NEAR(gear.z_m, 0.2, 0.02);
  EXPECT_NEAR(std::hypot(2 - robot.body.at.x_m, 0.5 - robot.body.at.y_m), 0.8, 0.06);
}

TEST_F(Assembly, FailsWhereThePartDoesNotStandAtItsPlace) {
  robot.slips = true;  // it ends half a metre beside
  Start("assembly", Parameters());
  EXPECT_EQ(End(), "gear stands 0.50 m off its place at dock, the tolerance is 0.05 m");
}

TEST_F(Assembly, FailsWhereThePartHasFallen) {
  Start("assembly", Parameters());
  while (run().running()) {
    Step();
    if (robot.Held().empty()) robot.Object("gear").pose.at.z_m = 0.03;
  }
  EXPECT_EQ(End(), "gear has fallen: it is 0.17 m below its place at dock");
}

TEST_F(Assembly, FailsWhereThePartIsNotSeenAnyMore) {
  Start("assembly", Parameters());
  while (run().running()) {
    Step();
    if (robot.Held().empty()) robot.seen[0].name = "gone";
  }
  EXPECT_EQ(End(), "Not verified: gear and dock are not seen together; the part is released");
}

TEST_F(Assembly, KeepsThePartWithoutASightingOfTheStation) {
  robot.seen[1].name = "bench";
  Start("assembly", Parameters());
  EXPECT_EQ(End(), "dock is not seen");
  robot.has_detector = false;
  Start("assembly", Parameters());
  EXPECT_EQ(End(), "jetbot_0 has no detector");
  robot.has_detector = true;
  robot.seen.push_back({"dock", "station", {{1, 0, 0.1}, 0}, ""});
  robot.seen.push_back({"dock", "station", {{2, 0, 0.1}, 0}, ""});
  Start("assembly", Parameters());
  EXPECT_THAT(End(), StartsWith("2 things are dock"));
  EXPECT_EQ(robot.Held(), "gear");
}

TEST_F(Assembly, ComesBeforeAStationThatMovesAwayOnlyAsLongAsItIsSeen) {
  robot.Object("dock").pose.at.x_m = 4;
  Start("assembly", Parameters());
  StepFor(5);
  robot.seen.pop_back();
  StepFor(1);
  EXPECT_EQ(robot.command, navigation::Velocity{});
  EXPECT_THAT(End(), StartsWith("dock is not seen for 2."));
  EXPECT_EQ(robot.Held(), "gear");
}

TEST_F(Assembly, TriesAgainAfterALostReplyAndFailsWhereTheHandRefuses) {
  int requests = 0;
  robot.hand_replies = [&](const HandRequest&) {
    return ++requests == 1 ? Reply::kAbandoned : Reply::kGiven;
  };
  Start("assembly", Parameters());
  EXPECT_EQ(End(), "Assembled: gear stands at dock");
  EXPECT_EQ(requests, 2);
  robot.seen[0].held_by = "jetbot_0";
  StepFor(1.5);  // the objects are known again
  robot.reach_m = 0.5;
  robot.body = {};
  Start("assembly", Parameters());
  EXPECT_THAT(End(), StartsWith("Too far"));
  EXPECT_EQ(robot.Held(), "gear");
}

TEST_F(Assembly, IsRefusedWithoutAHandAPartOrAPlace) {
  robot.has_hand = false;
  Start("assembly", Parameters());
  EXPECT_EQ(End(), "jetbot_0 has no hand");
  robot.has_hand = true;
  Start("assembly", {{"station", "dock"}, {"offset", Numbers{1}}});
  EXPECT_EQ(End(), "Invalid offset: expected three numbers");
  Start("assembly", {{"station", "gear"}});
  EXPECT_EQ(End(), "station is the part itself");
  Start("assembly", {{"station", "dock"}, {"distance", 0.1}});
  EXPECT_THAT(End(), StartsWith("distance is 0.1 m"));
  robot.seen[0].held_by = "";
  Start("assembly", Parameters());
  EXPECT_THAT(End(), EndsWith("holds nothing"));
}

TEST_F(Assembly, WaitsAtACancellationForTheHand) {
  Start("assembly", Parameters());
  while (robot.hand_requests.empty()) Step();
  ASSERT_TRUE(manager().Cancel("assembly", "by the test"));
  End();
  EXPECT_EQ(feedback().status, Status::kCancelled);
  EXPECT_EQ(robot.Held(), "");
}

TEST_F(Assembly, GoesOnInAnotherProcess) {
  Start("assembly", Parameters());
  StepFor(4);
  Restore();
  EXPECT_EQ(End(), "Assembled: gear stands at dock");
}

}  // namespace musher::skills::assembly_test
