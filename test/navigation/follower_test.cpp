// The follower: arrival, lateness, obstacles and bad input. The body here executes each command at
// once.

#include "musher/navigation/controller/follower.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation::follower_test {

using std::chrono::seconds;
using ::testing::HasSubstr;

const Path kAhead = {{{0, 0, 0}, 0}, {{4, 0, 0}, 0}};

struct Body {
  explicit Body(FollowerRules rules = {}) : follower(rules) {}

  void Start(const Path& path) {
    ASSERT_TRUE(follower.Start(MakeTrajectory(path, {}).value(), now).ok());
  }

  // Until its progress changes or the time has passed.
  Command Run(double longest_s, const std::vector<Point>& obstacles = {}) {
    Command command;
    const Progress begin = follower.progress();
    for (int i = 0; i < longest_s * 60; ++i) {
      command = Step(obstacles);
      if (command.progress != begin) break;
    }
    return command;
  }

  Command Step(const std::vector<Point>& obstacles = {}) {
    now += std::chrono::microseconds(16'667);
    const Command command = follower.Update(now, pose, velocity, obstacles);
    if (!stuck) velocity = command.velocity;
    pose.at.x_m += velocity.x_m_s / 60;
    pose.at.y_m += velocity.y_m_s / 60;
    pose.at.z_m += velocity.z_m_s / 60;
    pose.yaw_rad += velocity.yaw_rad_s / 60;
    return command;
  }

  Follower follower;
  Time now{};
  Pose pose;
  Velocity velocity;
  bool stuck = false;
};

TEST(Follower, ArrivesInTheTrajectorysTime) {
  Body body;
  body.Start(kAhead);
  const Command command = body.Run(20);
  EXPECT_EQ(command.progress, Progress::kArrived);
  EXPECT_EQ(command.velocity, Velocity{});
  EXPECT_LT(Distance(body.pose.at, {4, 0, 0}), 0.02);
  const Duration planned = MakeTrajectory(kAhead, {}).value().duration();
  EXPECT_NEAR(ToSeconds(body.now - Time{} - planned), 0, 0.1);
  EXPECT_EQ(body.Step().velocity, Velocity{}) << "and stays there";
}

TEST(Follower, BrakesToALimitOfTheSpeedAndIsNotLateForIt) {
  Body body;
  body.Start({{{0, 0, 0}, 0}, {{12, 0, 0}, 0}});
  body.Run(3);
  EXPECT_GT(body.velocity.x_m_s, 1.4);
  body.follower.LimitSpeed(0.4);
  double before_m_s = body.velocity.x_m_s, hardest_m_s2 = 0;
  for (int i = 0; i < 120; ++i) {
    body.Step();
    hardest_m_s2 = std::max(hardest_m_s2, (before_m_s - body.velocity.x_m_s) * 60);
    before_m_s = body.velocity.x_m_s;
  }
  EXPECT_LE(body.velocity.x_m_s, 0.401);
  EXPECT_LT(hardest_m_s2, 1);
  EXPECT_EQ(body.Run(60).progress, Progress::kArrived);
  EXPECT_GT(ToSeconds(body.now - Time{}), 20);
}

TEST(Follower, GoesFasterAgainWithoutTheLimit) {
  Body body;
  body.follower.LimitSpeed(0.4);
  body.Start({{{0, 0, 0}, 0}, {{12, 0, 0}, 0}});
  body.Run(5);
  EXPECT_NEAR(body.velocity.x_m_s, 0.4, 0.01) << "also in a trajectory that begins later";
  body.follower.LimitSpeed(std::numeric_limits<double>::infinity());
  body.Run(2);
  EXPECT_GT(body.velocity.x_m_s, 1.2);
}

TEST(Follower, IsLateAlsoAtALimitOfTheSpeed) {
  Body body;
  body.follower.LimitSpeed(0.4);
  body.Start(kAhead);
  body.stuck = true;
  body.Run(60);
  EXPECT_EQ(body.follower.progress(), Progress::kFailed);
}

TEST(Follower, LeadsABodyBackToItsWay) {
  Body body;
  body.pose.at.y_m = 0.3;
  body.Start(kAhead);
  body.Run(3);
  EXPECT_NEAR(body.pose.at.y_m, 0, 0.02);
}

TEST(Follower, ArrivesOnlyInTheDirectionOfTheGoal) {
  Body body;
  body.pose.yaw_rad = 1;
  body.Start({{{0, 0, 0}, 0}, {{0.01, 0, 0}, 0}});
  EXPECT_EQ(body.Run(0.3).progress, Progress::kFollowing) << "it has not turned yet";
  EXPECT_EQ(body.Run(5).progress, Progress::kArrived);
  EXPECT_NEAR(body.pose.yaw_rad, 0, 0.1);
}

TEST(Follower, GivesUpFiveSecondsLateAndSaysSo) {
  Body body;
  body.stuck = true;
  body.Start(kAhead);
  const Command command = body.Run(60);
  EXPECT_EQ(command.progress, Progress::kFailed);
  EXPECT_EQ(command.velocity, Velocity{});
  ASSERT_TRUE(command.failure);
  EXPECT_TRUE(Is(*command.failure, Fault::kLate));
  EXPECT_THAT(command.failure->message, HasSubstr("not arrived 5.0 s after"));
  EXPECT_THAT(command.failure->message, HasSubstr("4.00 m and 0.00 rad are left"));
  const Duration planned = MakeTrajectory(kAhead, {}).value().duration();
  EXPECT_NEAR(ToSeconds(body.now - Time{} - planned), 5, 0.1);
  EXPECT_EQ(body.Step().progress, Progress::kFailed);
}

TEST(Follower, WaitsForABodyThatIsBehind) {
  Body body;
  body.stuck = true;
  body.Start(kAhead);
  Command command;
  for (int i = 0; i < 60 * 5; ++i) command = body.Step();
  const double lead_m =
      MakeTrajectory(kAhead, {}).value().At(command.reference).pose.at.x_m - body.pose.at.x_m;
  EXPECT_LT(lead_m, 1.5) << "0.5 m and the path to a stop";
}

// The body drives at full speed when an obstacle appears.
TEST(Follower, StopsWithinItsBrakingDistanceBeforeAnObstacleThatAppears) {
  Body body;
  body.Start({{{0, 0, 0}, 0}, {{20, 0, 0}, 0}});
  body.Run(4);
  ASSERT_NEAR(body.velocity.x_m_s, 1.5, 0.01);
  const double at_m = body.pose.at.x_m;
  const FollowerRules rules;
  const double braking_m = BrakingDistance(1.5, rules.obstacles);
  const Point obstacle = {at_m + braking_m + 0.4, 0, 0};
  Command command;
  double hardest_m_s2 = 0;
  for (int i = 0; i < 60 * 4; ++i) {
    const double before_m_s = body.velocity.x_m_s;
    command = body.Step({obstacle});
    hardest_m_s2 = std::max(hardest_m_s2, (before_m_s - body.velocity.x_m_s) * 60);
  }
  EXPECT_EQ(command.progress, Progress::kWaiting);
  EXPECT_NEAR(body.velocity.x_m_s, 0, 0.02);
  EXPECT_LE(body.pose.at.x_m, at_m + braking_m + 0.01);
  EXPECT_GT(body.pose.at.x_m, at_m + 1) << "it brakes evenly";
  EXPECT_LT(hardest_m_s2, 1.1);
  EXPECT_NEAR(body.pose.at.y_m, 0, 0.01);
}

// It crept: 2 cm beyond its margin it had 0.05 m/s.
TEST(Follower, PassesAnObstacleAtAClearSpeedOrWaits) {
  for (const double beyond_m : {-0.02, 0.005, 0.02, 0.05, 0.1, 0.2}) {
    Body body;
    const ObstacleRules rules;
    std::vector<Point> person;
    for (int i = 0; i <= 10; ++i) {
      person.push_back({2 + 0.05 * i, rules.radius_m + rules.margin_m + beyond_m, 0});
    }
    body.Start(kAhead);
    double slowest_m_s = 10;
    bool waits = false;
    for (int i = 0; i < 20 * 60 && body.follower.progress() != Progress::kArrived; ++i) {
      waits = body.Step(person).progress == Progress::kWaiting || waits;
      const double x_m = body.pose.at.x_m;
      if (x_m > 1 && x_m < 3.2) slowest_m_s = std::min(slowest_m_s, body.velocity.x_m_s);
    }
    EXPECT_EQ(waits, beyond_m < 0) << beyond_m;
    EXPECT_EQ(body.follower.progress() == Progress::kArrived, beyond_m >= 0) << beyond_m;
    if (beyond_m < 0) continue;
    EXPECT_GT(slowest_m_s, 0.15) << beyond_m;
    EXPECT_LT(slowest_m_s, beyond_m < 0.05 ? 0.3 : 1) << "it is slow there";
  }
}

TEST(Follower, GoesOnWhenTheObstacleHasLeft) {
  Body body;
  body.Start(kAhead);
  for (int i = 0; i < 60 * 4; ++i) body.Step({{2, 0.1, 0}});
  EXPECT_LT(body.pose.at.x_m, 1.61);
  EXPECT_EQ(body.follower.progress(), Progress::kWaiting);
  EXPECT_EQ(body.Run(10).progress, Progress::kFollowing);
  EXPECT_EQ(body.Run(10).progress, Progress::kArrived);
}

TEST(Follower, RequestsANewPlanWhenTheObstacleStays) {
  Body body;
  body.Start(kAhead);
  Command command = body.Run(3, {{2, 0, 0}});
  ASSERT_EQ(command.progress, Progress::kWaiting);
  const Time begin = body.now;
  while (!command.replan) command = body.Step({{2, 0, 0}});
  EXPECT_NEAR(ToSeconds(body.now - begin), 2, 0.05);
  ASSERT_TRUE(command.obstruction);
  EXPECT_EQ(command.obstruction->at, (Point{2, 0, 0}));
  // Around it.
  body.Start({body.pose, {{1.2, 1, 0}, 0}, {{4, 1, 0}, 0}});
  EXPECT_EQ(body.Run(20, {{2, 0, 0}}).progress, Progress::kArrived);
}

// A planner that plans each second.
TEST(Follower, RequestsANewPlanAlsoWhereNewTrajectoriesLeadToTheObstacle) {
  Body body;
  body.Start(kAhead);
  ASSERT_EQ(body.Run(3, {{2, 0, 0}}).progress, Progress::kWaiting);
  const Time begin = body.now;
  Command command;
  for (int steps = 1; steps < 60 * 5 && !command.replan; ++steps) {
    if (steps % 60 == 0) body.Start({body.pose, {{4, 0.001, 0}, 0}});
    command = body.Step({{2, 0, 0}});
  }
  EXPECT_TRUE(command.replan);
  EXPECT_NEAR(ToSeconds(body.now - begin), 2, 0.05);
  // One that leads elsewhere has its own time.
  body.Start({body.pose, {{body.pose.at.x_m, 3, 0}, M_PI / 2}});
  EXPECT_FALSE(body.Step({{2, 0, 0}}).replan);
  EXPECT_EQ(body.Run(1, {{2, 0, 0}}).progress, Progress::kFollowing);
  const std::vector<Point> next{{2, 0, 0}, {body.pose.at.x_m, body.pose.at.y_m + 0.3, 0}};
  EXPECT_FALSE(body.Step(next).replan);
  EXPECT_EQ(body.follower.progress(), Progress::kWaiting);
}

TEST(Follower, FailsWhenTheObstacleStaysForever) {
  Body body;
  body.Start(kAhead);
  body.Run(3, {{2, 0.25, 0}});
  const Command command = body.Run(60, {{2, 0.25, 0}});
  EXPECT_EQ(command.progress, Progress::kFailed);
  EXPECT_TRUE(Is(*command.failure, Fault::kObstacle));
  EXPECT_EQ(command.failure->message, "an obstacle at (2.00, 0.25) has been in the way for 30 s");
  body.Start({body.pose, kAhead.back()});
  EXPECT_EQ(body.Run(1, {{2, 0.25, 0}}).progress, Progress::kWaiting) << "it is a new attempt";
}

TEST(Follower, IsLateAlsoAfterAnObstacleHasSlowedItDown) {
  Body body;
  body.Start(kAhead);
  body.Run(2);
  for (int i = 0; i < 60; ++i) body.Step({{body.pose.at.x_m + 1.2, 0.42, 0}});  // beside its way
  body.stuck = true;
  body.velocity = {};
  const Time begin = body.now;
  const Command command = body.Run(60);
  ASSERT_EQ(command.progress, Progress::kFailed);
  EXPECT_TRUE(Is(*command.failure, Fault::kLate));
  EXPECT_LT(ToSeconds(body.now - begin), 4.6 + 5 + 3) << "the path takes 4.6 s";
}

// In the way for 1.5 s of 2 s: never long enough in one go.
TEST(Follower, EndsAlsoWhenObstaclesComeAndGo) {
  Body body;
  body.stuck = true;
  body.Start(kAhead);
  Command command;
  int steps = 0;
  for (; steps < 60 * 400 && !command.failure; ++steps) {
    const bool there = steps % 120 < 90;
    command = body.Step(there ? std::vector<Point>{{0.5, 0, 0}} : std::vector<Point>{});
  }
  ASSERT_TRUE(command.failure);
  EXPECT_LT(steps / 60.0, 4.6 * 3 + 5 + 90 + 5);
}

TEST(Follower, DoesNotCountTheTimeForWhichAGateSlowsTheBodyDown) {
  Body body;
  body.Start(kAhead);
  body.stuck = true;
  for (int i = 0; i < 60 * 20; ++i) {
    body.follower.NoteSlowed(body.now);
    ASSERT_EQ(body.Step().progress, Progress::kFollowing);
  }
  body.stuck = false;
  EXPECT_EQ(body.Run(30).progress, Progress::kArrived);
}

TEST(Follower, StandsWithoutAPoseAndIsLateAtLast) {
  Body body;
  body.Start(kAhead);
  body.Run(1);
  body.pose.at.x_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(body.Step().velocity, Velocity{});
  EXPECT_EQ(body.Run(60).progress, Progress::kFailed);
}

TEST(Follower, KeepsItsBoundsWithAnyVelocityOfTheBody) {
  Body body;
  body.Start({{{0, 0, 0}, 0}, {{4, 4, 0}, 0.5}});
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300}) {
    body.velocity = {value, value, value, value};
    body.pose = {{-30, 80, 0}, 2};
    const Command command = body.follower.Update(body.now, body.pose, body.velocity, {});
    EXPECT_LE(Speed(command.velocity), 1.5 + 1e-9);
    EXPECT_LE(std::abs(command.velocity.yaw_rad_s), 1.0 + 1e-9);
  }
}

TEST(Follower, DoesNotJumpAfterAPauseOfItsUpdates) {
  Body body;
  body.Start({{{0, 0, 0}, 0}, {{20, 0, 0}, 0}});
  body.Run(3);
  const Duration before = body.Step().reference;
  body.now += seconds(3);
  EXPECT_LT(body.Step().reference - before, Milliseconds(250));
  body.now -= seconds(2);
  EXPECT_EQ(body.Step().progress, Progress::kFollowing) << "nor when the time goes back";
}

TEST(Follower, IsIdleUntilItIsStartedAndAfterAStop) {
  Body body;
  EXPECT_EQ(body.Step().progress, Progress::kIdle);
  EXPECT_FALSE(body.follower.Start({}, body.now).ok());
  body.Start(kAhead);
  body.Run(2);
  body.follower.Stop();
  EXPECT_EQ(body.Step().progress, Progress::kIdle);
  EXPECT_EQ(body.Step().velocity, Velocity{});
}

TEST(Follower, FliesInSpace) {
  FollowerRules rules;
  rules.flat = false;
  Body body(rules);
  body.Start({{{0, 0, 0}, 0}, {{1, 1, 2}, 1}});
  EXPECT_EQ(body.Run(20).progress, Progress::kArrived);
  EXPECT_NEAR(body.pose.at.z_m, 2, 0.05);
}

}  // namespace musher::navigation::follower_test
