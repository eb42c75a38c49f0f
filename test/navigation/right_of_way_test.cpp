// Which of two robots that meet goes first, and what is known of others.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "musher/navigation/traffic/known_robots.hpp"

namespace musher::navigation::right_of_way_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr MeetingRules kRules{};

RobotIntent Robot(const std::string& name, const Point& at, std::vector<Point> path,
                  int priority = 0) {
  return {.robot = name, .priority = priority, .at = at, .path = std::move(path)};
}

TEST(Meeting, IsWherePathsLieOnEachOtherInOppositeDirections) {
  const RobotIntent east = Robot("a", {0, 0, 0}, {{10, 0, 0}});
  const RobotIntent west = Robot("b", {6, 0.3, 0}, {{-5, 0.3, 0}});
  EXPECT_TRUE(MeetingOf(east, west, kRules));
  EXPECT_TRUE(MeetingOf(west, east, kRules));
}

TEST(Meeting, IsNoneForRobotsThatFollowCrossOrPassEachOther) {
  const RobotIntent east = Robot("a", {0, 0, 0}, {{10, 0, 0}});
  EXPECT_FALSE(MeetingOf(east, Robot("b", {2, 0, 0}, {{9, 0, 0}}), kRules)) << "the same way";
  EXPECT_FALSE(MeetingOf(east, Robot("b", {4, -3, 0}, {{4, 3, 0}}), kRules)) << "crosses";
  EXPECT_FALSE(MeetingOf(east, Robot("b", {6, 0.8, 0}, {{-5, 0.8, 0}}), kRules)) << "beside it";
  EXPECT_FALSE(MeetingOf(east, Robot("b", {6, 0, 0}, {}), kRules)) << "it stands";
  EXPECT_FALSE(MeetingOf(east, Robot("b", {-1, 0, 0}, {{-9, 0, 0}}), kRules)) << "it has passed";
  EXPECT_FALSE(MeetingOf(east, Robot("b", {30, 0, 0}, {{0, 0, 0}}), kRules)) << "far away";
}

TEST(Meeting, IsOneWhereEachLeadsThroughTheBodyOfTheOther) {
  const RobotIntent east = Robot("a", {0, 0, 0}, {{1, 0, 0}, {1, 5, 0}});
  const RobotIntent south = Robot("b", {0.9, 0.2, 0}, {{0, 0.1, 0}, {0, -5, 0}});
  EXPECT_TRUE(MeetingOf(east, south, kRules));
}

TEST(Meeting, CountsHeightsOnlyIfOneFlies) {
  RobotIntent east = Robot("a", {0, 0, 0.8}, {{10, 0, 0.8}});  // the pelvis of a humanoid
  RobotIntent west = Robot("b", {6, 0, 0}, {{-5, 0, 0}});
  EXPECT_TRUE(MeetingOf(east, west, kRules));
  east.flies = true;
  EXPECT_FALSE(MeetingOf(east, west, kRules));
}

TEST(RightOfWay, IsOfExactlyOneOfTwo) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    RobotIntent a = Robot("a", {}, {}), b = Robot("b", {}, {});
    for (RobotIntent* robot : {&a, &b}) {
      robot->priority = static_cast<int>(random() % 3);
      robot->cornered = random() % 2 == 0;
    }
    EXPECT_NE(GoesFirst(a, b), GoesFirst(b, a));
  }
}

TEST(RightOfWay, IsDecidedByCornersThenPriorityThenName) {
  RobotIntent a = Robot("a", {0, 0, 0}, {{10, 0, 0}});
  RobotIntent b = Robot("b", {6, 0, 0}, {{-5, 0, 0}});
  const auto first_of_b = [&] {
    std::vector<std::string> names;
    const std::vector<RobotIntent> others = {a};
    for (const RobotIntent* first : RightOfWayOf(b, others, kRules).first) {
      names.push_back(first->robot);
    }
    return names;
  };
  EXPECT_THAT(first_of_b(), ElementsAre("a"));
  b.priority = 1;
  EXPECT_THAT(first_of_b(), IsEmpty());
  EXPECT_TRUE(RightOfWayOf(b, {a}, kRules).meets);
  a.cornered = true;
  EXPECT_THAT(first_of_b(), ElementsAre("a"));
  b.cornered = true;
  EXPECT_THAT(first_of_b(), IsEmpty());
}

TEST(PathLeft, IsWhatTheRobotHasNotPassedAlsoWhereThePathCrossesItself) {
  PathLeft path;
  EXPECT_THAT(path.From({}), IsEmpty());
  path.Start({{{0, 0, 0}, 0}, {{4, 0, 0}, 0}, {{4, 2, 0}, 0}, {{2, 2, 0}, 0}, {{2, -2, 0}, 0}});
  EXPECT_THAT(path.From({1, 0.1, 0}), SizeIs(4));
  EXPECT_THAT(path.From({2, 0, 0}), SizeIs(4)) << "where it crosses itself";
  EXPECT_THAT(path.From({4.1, 1, 0}), SizeIs(3));
  EXPECT_THAT(path.From({2, 1.5, 0}), SizeIs(1));
  EXPECT_THAT(path.From({2, -2, 0}), ElementsAre(Point{2, -2, 0})) << "at its end";
}

class Known : public ::testing::Test {
 protected:
  Result<> Receive(RobotIntent intent, double stamp_s) {
    return robots_.Take(std::move(intent), FromSeconds(stamp_s), now_);
  }
  void Pass(double seconds) { now_ += FromSeconds(seconds); }

  KnownRobots robots_{"/dog/me"};
  Time now_ = Time{} + std::chrono::seconds(100);
};

TEST_F(Known, ForgetsARobotThatHasNotSaidAnythingForTwoSeconds) {
  EXPECT_TRUE(Receive(Robot("/dog/a", {1, 0, 0}, {}), 5));
  Pass(1.9);
  EXPECT_THAT(robots_.At(now_), SizeIs(1));
  Pass(0.2);
  EXPECT_THAT(robots_.At(now_), IsEmpty());
}

TEST_F(Known, IgnoresCopiesAndLateSamplesOfABridge) {
  EXPECT_TRUE(Receive(Robot("/dog/a", {1, 0, 0}, {}), 5));
  EXPECT_TRUE(Receive(Robot("/dog/a", {2, 0, 0}, {}), 6));
  EXPECT_TRUE(Receive(Robot("/dog/a", {1, 0, 0}, {}), 5)) << "late";
  EXPECT_EQ(robots_.At(now_).at(0).at.x_m, 2);
  for (int i = 0; i < 30; ++i) {
    Pass(0.1);
    EXPECT_TRUE(Receive(Robot("/dog/a", {2, 0, 0}, {}), 6)) << "doubled";
  }
  EXPECT_THAT(robots_.At(now_), IsEmpty()) << "copies keep nothing alive";
}

TEST_F(Known, AcceptsARobotWhoseClockWasSetBackOnceItIsForgotten) {
  EXPECT_TRUE(Receive(Robot("/dog/a", {1, 0, 0}, {}), 5000));
  Pass(3);
  EXPECT_TRUE(Receive(Robot("/dog/a", {2, 0, 0}, {}), 3));
  ASSERT_THAT(robots_.At(now_), SizeIs(1));
  EXPECT_EQ(robots_.At(now_)[0].at.x_m, 2);
}

TEST_F(Known, DoesNotKnowItself) {
  EXPECT_TRUE(Receive(Robot("/dog/me", {1, 0, 0}, {}), 5));
  EXPECT_THAT(robots_.At(now_), IsEmpty());
  EXPECT_TRUE(Receive(Robot("/cat/me", {1, 0, 0}, {}), 5)) << "of another machine";
  EXPECT_THAT(robots_.At(now_), SizeIs(1));
}

TEST_F(Known, RefusesNumbersThatAreNone) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Receive(Robot("", {}, {}), 1));
  EXPECT_FALSE(Receive(Robot("a", {kNan, 0, 0}, {}), 1));
  EXPECT_FALSE(Receive(Robot("a", {}, {{0, kNan, 0}}), 1));
  EXPECT_FALSE(Receive(Robot("a", {}, std::vector<Point>(KnownRobots::kMostPoints + 1)), 1));
  RobotIntent huge = Robot("a", {}, {});
  huge.radius_m = kNan;
  EXPECT_FALSE(Receive(huge, 1));
  EXPECT_THAT(robots_.At(now_), IsEmpty());
}

TEST_F(Known, IsBounded) {
  for (int i = 0; i < 1000; ++i) {
    Pass(0.001);
    EXPECT_TRUE(Receive(Robot("r" + std::to_string(i), {}, {}), 1));
  }
  EXPECT_THAT(robots_.At(now_), SizeIs(KnownRobots::kMost));
}

}  // namespace musher::navigation::right_of_way_test
