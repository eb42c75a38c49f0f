// A flyer without a skill or drive keeps its place in the wind.

#include "musher/modules/skills/robot/flight_hold.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace musher::skills::flight_hold_test {

constexpr Duration kStep = Milliseconds(100);

// A body in gusts, whose velocity follows its command with a lag of 0.2 s.
struct Flyer {
  navigation::Pose pose{{3, 2, 1.2}, 0.7};
  navigation::Velocity velocity;  // by its commands
  double gust_x_m_s = 0, gust_y_m_s = 0;
  std::mt19937_64 random{7};
  std::normal_distribution<double> normal;

  void Move(const navigation::Velocity& command) {
    const double share = 1 - std::exp(-0.1 / 0.2), keep = std::exp(-0.1 / 2);
    const navigation::Velocity wanted = navigation::InBodyFrame(command, -pose.yaw_rad);
    velocity.x_m_s += share * (wanted.x_m_s - velocity.x_m_s);
    velocity.y_m_s += share * (wanted.y_m_s - velocity.y_m_s);
    velocity.z_m_s += share * (wanted.z_m_s - velocity.z_m_s);
    const double fresh = 0.05 * std::sqrt(1 - keep * keep);
    gust_x_m_s = keep * gust_x_m_s + fresh * normal(random);
    gust_y_m_s = keep * gust_y_m_s + fresh * normal(random);
    pose.at.x_m += (velocity.x_m_s + gust_x_m_s) * 0.1;
    pose.at.y_m += (velocity.y_m_s + gust_y_m_s) * 0.1;
    pose.at.z_m += velocity.z_m_s * 0.1;
  }
  double speed_m_s() const { return navigation::Speed(velocity); }
};

TEST(FlightHold, KeepsTheLastPlaceForMinutesInTheWind) {
  Flyer flyer;
  FlightHold hold;
  hold.Use();
  flyer.velocity = {0.8, 0, 0, 0};  // at the end of a drive
  double farthest_m = 0;
  navigation::Point place = flyer.pose.at;
  for (int i = 0; i < 3000; ++i) {
    const auto command = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
    ASSERT_TRUE(command) << "it is in the air";
    flyer.Move(*command);
    if (i == 20) place = flyer.pose.at;
    if (i > 50) farthest_m = std::max(farthest_m, navigation::Distance(flyer.pose.at, place));
  }
  EXPECT_LT(farthest_m, 0.3);
}

TEST(FlightHold, LeavesAFlyerAloneThatNoSkillHasMovedOrThatStands) {
  FlightHold hold;
  const navigation::Pose air{{0, 0, 1}, 0}, ground{{0, 0, 0}, 0}, roof{{0, 0, 1.5}, 0};
  EXPECT_FALSE(hold.Command(air, 0, kStep)) << "nothing moves because a process was started";
  hold.Use();
  EXPECT_TRUE(hold.Command(air, 0, kStep));
  EXPECT_FALSE(hold.Command(ground, 0, kStep));
  EXPECT_FALSE(hold.Command(air, 0, kStep)) << "a person lifts it";
  hold.Use();
  hold.Land();
  EXPECT_FALSE(hold.Command(roof, 0, kStep)) << "it has landed there";
}

TEST(FlightHold, StandsStillWithoutOdometryAndKeepsThePlaceAfterwards) {
  FlightHold hold;
  hold.Use();
  ASSERT_TRUE(hold.Command(navigation::Pose{{0, 0, 1}, 0}, 0, kStep));
  EXPECT_EQ(hold.Command(std::nullopt, 0, kStep), navigation::Velocity{});
  const auto back = hold.Command(navigation::Pose{{0.4, 0, 1}, 0}, 0, kStep);
  ASSERT_TRUE(back);
  EXPECT_LT(back->x_m_s, -0.3);
}

TEST(FlightHold, EndsWhenSomethingElseCarriesTheFlyerAway) {
  FlightHold hold;
  hold.Use();
  navigation::Pose pose{{0, 0, 1}, 0};
  ASSERT_TRUE(hold.Command(pose, 0, kStep));
  while (pose.at.x_m < 1.5) {
    ASSERT_TRUE(hold.Command(pose, 1.5, kStep));
    pose.at.x_m += 0.15;
  }
  EXPECT_FALSE(hold.Command(pose, 1.5, kStep));
  EXPECT_EQ(hold.ended(), "it was carried 1.6 m off its place against its commands");
  EXPECT_FALSE(hold.Command(navigation::Pose{{0, 0, 1}, 0}, 0, kStep)) << "until it is used again";
}

// It flew after a localisation that had jumped by 1 m, and one that jumped by 2 m gave it to the
// wind.
TEST(FlightHold, KeepsTheFlyerWhereItIsWhenItsPoseJumps) {
  for (const double jump_m : {1.0, 2.0, -30.0}) {
    FlightHold hold;
    hold.Use();
    Flyer flyer;
    for (int i = 0; i < 50; ++i) flyer.Move(*hold.Command(flyer.pose, flyer.speed_m_s(), kStep));
    const navigation::Pose was = flyer.pose;
    flyer.pose.at.x_m += jump_m;
    flyer.pose.at.y_m -= jump_m / 2;
    flyer.pose.yaw_rad += 0.4;
    double farthest_m = 0, most_turned_rad = 0;
    for (int i = 0; i < 600; ++i) {
      const auto command = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
      ASSERT_TRUE(command) << "it is in the air";
      flyer.Move(*command);
      farthest_m = std::max(farthest_m, std::hypot(flyer.pose.at.x_m - was.at.x_m - jump_m,
                                                   flyer.pose.at.y_m - was.at.y_m + jump_m / 2));
      most_turned_rad = std::max(most_turned_rad, std::abs(command->yaw_rad_s));
    }
    EXPECT_LT(farthest_m, 0.4) << jump_m;
    EXPECT_LT(most_turned_rad, 0.1) << jump_m;
  }
}

// It flew back to where its odometry had stood while it braked.
TEST(FlightHold, TakesNoPlaceFromAnOdometryThatStands) {
  FlightHold hold;
  hold.Use();
  navigation::Pose pose{{0, 0, 1}, 0};
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(hold.Command(pose, 0, kStep));
  pose.at.x_m = 0.9;
  auto command = hold.Command(pose, 0, kStep);
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->x_m_s, 0, 0.1);
  pose.at.x_m = 1.1;
  command = hold.Command(pose, 0, kStep);
  ASSERT_TRUE(command);
  EXPECT_LT(command->x_m_s, -0.3) << "from now on it is held there";
}

// Its place was at a height that the flyer has left meanwhile.
TEST(FlightHold, KeepsTheFlyerAtItsHeightWhenThatJumps) {
  for (const double jump_m : {1.5, -1.0}) {
    FlightHold hold;
    hold.Use();
    navigation::Pose pose{{0, 0, 2}, 0};
    ASSERT_TRUE(hold.Command(pose, 0, kStep));
    pose.at.z_m += jump_m;
    const auto command = hold.Command(pose, 0, kStep);
    ASSERT_TRUE(command) << "it is in the air";
    EXPECT_NEAR(command->z_m_s, 0, 0.1) << jump_m;
  }
}

// By a hand that is stronger than its commands, at up to 1 m/s.
void Carry(Flyer& flyer, FlightHold& hold, const navigation::Point& to) {
  const navigation::Point from = flyer.pose.at;
  const int steps = int(navigation::Distance(from, to) / 0.1) + 1;
  for (int i = 1; i <= steps; ++i) {
    flyer.pose.at = navigation::Between(from, to, double(i) / steps);
    (void)hold.Command(flyer.pose, 0, kStep);
  }
}

// It climbed back to where it had been held, out of the hand and off the table.
RC_GTEST_PROP(FlightHold, NeverMovesAFlyerThatWasPutDownByHand, ()) {
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  std::uniform_real_distribution<double> any(0, 1);
  Flyer flyer;
  FlightHold hold;
  hold.Use();
  for (int i = 0; i < 50; ++i) flyer.Move(*hold.Command(flyer.pose, flyer.speed_m_s(), kStep));
  const double under_m = 0.21;
  const navigation::Point put_down{flyer.pose.at.x_m + 2 * any(random) - 1,
                                   flyer.pose.at.y_m + 2 * any(random) - 1,
                                   (flyer.pose.at.z_m - under_m) * any(random)};
  Carry(flyer, hold, put_down);
  for (int i = 0; i < 600; ++i) RC_ASSERT(!hold.Command(flyer.pose, 0, kStep));
  Carry(flyer, hold, {put_down.x_m, put_down.y_m, put_down.z_m + any(random)});
  for (int i = 0; i < 600; ++i) RC_ASSERT(!hold.Command(flyer.pose, 0, kStep));
}

// A hand that holds it, or a table at the height of its place: it flew off once it was free.
TEST(FlightHold, EndsForAFlyerThatStandsOffItsPlaceAgainstItsCommands) {
  FlightHold hold;
  hold.Use();
  navigation::Pose pose{{0, 0, 1}, 0};
  ASSERT_TRUE(hold.Command(pose, 0, kStep));
  pose.at.x_m = 0.5;
  int steps = 0;
  while (steps < 600 && hold.Command(pose, 0, kStep)) ++steps;
  EXPECT_LE(steps, 12);
  EXPECT_EQ(hold.ended(), "it stands 0.50 m off its place against its commands");
  hold.Use();
  EXPECT_EQ(hold.ended(), "") << "a skill moves it";
}

TEST(FlightHold, SaysWhyItEndsAndIsSilentWhereItHasNotBegun) {
  const navigation::Pose air{{0, 0, 1}, 0};
  FlightHold hold;
  hold.NoteOther({0.1, 0, 0, 0});
  EXPECT_EQ(hold.ended(), "") << "it holds nothing";
  hold.Use();
  ASSERT_TRUE(hold.Command(air, 0, kStep));
  EXPECT_FALSE(hold.Command(navigation::Pose{{0, 0, 0.7}, 0}, 0, kStep));
  EXPECT_EQ(hold.ended(), "it came 0.30 m lower than its place against its commands");
  EXPECT_FALSE(hold.Command(air, 0, kStep)) << "until it is used again";
  hold.Use();
  hold.NoteOther({0.1, 0, 0, 0});
  EXPECT_FALSE(hold.Command(air, 0, kStep));
  EXPECT_EQ(hold.ended(), "another program commands it");
  hold.Use();
  hold.SetBatteryLow(true);
  hold.NoteOther({0.1, 0, 0, 0});
  EXPECT_TRUE(hold.Command(air, 0, kStep)) << "it lands, whatever commands it";
}

// Commands of another program, for so long; the hold sends nothing beside them.
void FlyByOther(Flyer& flyer, FlightHold& hold, const navigation::Velocity& command,
                double seconds) {
  for (int i = 0; i < 10 * seconds; ++i) {
    hold.NoteOther(command);
    const auto beside = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
    ASSERT_FALSE(beside) << "it is the other program's";
    flyer.Move(command);
  }
}

// In a wind along x, for so long without commands of another program.
void FlyAlone(Flyer& flyer, FlightHold& hold, double seconds, double wind_m_s) {
  for (int i = 0; i < 10 * seconds; ++i) {
    const auto command = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
    flyer.Move(command.value_or(navigation::Velocity{}));
    flyer.pose.at.x_m += 0.1 * wind_m_s;
  }
}

// The wind had it once the commands had ended, until a skill or a drive moved it.
TEST(FlightHold, HoldsAFlyerThatAnotherProgramHasLeftInTheAir) {
  for (const bool used : {true, false}) {
    for (const navigation::Velocity last :
         {navigation::Velocity{0.5, 0, 0, 0}, navigation::Velocity{0, 0, 0.3, 0},
          navigation::Velocity{0, 0, -0.3, 0}}) {
      Flyer flyer;
      flyer.pose.at.z_m = used ? 1.2 : 0;
      FlightHold hold;
      if (used) hold.Use();
      FlyByOther(flyer, hold, {0, 0, 0.5, 0}, 2);
      FlyByOther(flyer, hold, last, 2);
      FlyAlone(flyer, hold, 6, 0.25);
      const navigation::Point place = flyer.pose.at;
      FlyAlone(flyer, hold, 120, 0.25);
      EXPECT_LT(navigation::Distance(flyer.pose.at, place), 0.4)
          << "used " << used << ", last command " << last.x_m_s << ", " << last.z_m_s;
      EXPECT_EQ(hold.ended(), "");
    }
  }
}

// On a table, or caught by a hand.
TEST(FlightHold, LeavesAFlyerAloneThatAnotherProgramHasPutDown) {
  Flyer flyer;
  FlightHold hold;
  hold.Use();
  FlyByOther(flyer, hold, {0, 0, -0.2, 0}, 2);
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(hold.Command(flyer.pose, 0, kStep)) << "it stands";
  EXPECT_FALSE(hold.of_other());
  EXPECT_EQ(hold.ended(), "") << "it has landed";
  Carry(flyer, hold, {4, 2, 1.5});
  EXPECT_FALSE(hold.Command(flyer.pose, 0, kStep)) << "a person takes it";
}

TEST(FlightHold, LeavesAFlyerAloneThatIsLiftedWhereAnotherProgramHasJustPutItDown) {
  Flyer flyer;
  FlightHold hold;
  hold.Use();
  FlyByOther(flyer, hold, {0, 0, -0.2, 0}, 2);
  for (int i = 0; i < 20; ++i) ASSERT_FALSE(hold.Command(flyer.pose, 0, kStep));
  Carry(flyer, hold, {flyer.pose.at.x_m + 0.05, flyer.pose.at.y_m, flyer.pose.at.z_m + 0.4});
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(hold.Command(flyer.pose, 0, kStep));
}

// A teleop program that sends on for one that does not fly.
TEST(FlightHold, LeavesAFlyerAloneThatDoesNotFollowTheCommandsOfAnotherProgram) {
  Flyer flyer;
  FlightHold hold;
  for (int i = 0; i < 100; ++i) {
    hold.NoteOther({-0.3, 0, 0.1, 0});
    flyer.pose = {{0.01 * i, 0, 0.8}, 0};  // it is carried, the other way
    ASSERT_FALSE(hold.Command(flyer.pose, 0, kStep));
  }
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(hold.Command(flyer.pose, 0, kStep));
}

// A skill had landed it; an empty one falls.
TEST(FlightHold, LandsAFlyerWithALowBatteryThatAnotherProgramHasTakenOff) {
  Flyer flyer;
  flyer.pose.at.z_m = 0;
  FlightHold hold;
  hold.Use();
  hold.Land();
  FlyByOther(flyer, hold, {0, 0, 0.5, 0}, 2);
  hold.SetBatteryLow(true);
  hold.NoteOther({0, 0, 0.5, 0});
  const auto down = hold.Command(flyer.pose, 0, kStep);
  ASSERT_TRUE(down);
  EXPECT_LT(down->z_m_s, 0);
}

// Its process was killed, and started again within a few seconds.
TEST(FlightHold, HoldsAFlyerThatTheProcessBeforeHadInTheAir) {
  FlightHold near;
  near.Restore({0, 0, 1});
  EXPECT_FALSE(near.Command(std::nullopt, 0, kStep)) << "where it is is not known yet";
  ASSERT_TRUE(near.Command(navigation::Pose{{0.5, 0, 0.9}, 0}, 0, kStep));
  EXPECT_LT(near.Command(navigation::Pose{{0.6, 0, 0.9}, 0}, 0, kStep)->x_m_s, 0)
      << "at the place where it is found";
  FlightHold far;
  far.Restore({0, 0, 1});
  EXPECT_FALSE(far.Command(navigation::Pose{{4, 0, 1}, 0}, 0, kStep)) << "it was carried there";
  EXPECT_FALSE(far.Command(navigation::Pose{{0, 0, 1}, 0}, 0, kStep)) << "and back";
  FlightHold down;
  down.Restore({0, 0, 0.5});
  EXPECT_FALSE(down.Command(navigation::Pose{{0, 0, 0}, 0}, 0, kStep));
  EXPECT_FALSE(down.Command(navigation::Pose{{0, 0, 0.5}, 0}, 0, kStep)) << "a person lifts it";
}

// The gate stops them before an obstacle.
TEST(FlightHold, GoesOnWhereItsCommandsDoNotReachTheBody) {
  FlightHold hold;
  hold.Use();
  ASSERT_TRUE(hold.Command(navigation::Pose{{0, 0, 1}, 0}, 0, kStep));
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(hold.Command(navigation::Pose{{0.5, 0, 1}, 0}, 0, kStep));
    hold.NoteStopped();
  }
}

TEST(FlightHold, EndsOnTheGroundAlsoWhereItsPlaceIsJustAboveIt) {
  FlightHold hold;
  hold.Use();
  ASSERT_TRUE(hold.Command(navigation::Pose{{0, 0, 0.15}, 0}, 0, kStep));
  EXPECT_FALSE(hold.Command(navigation::Pose{{0, 0, 0.02}, 0}, 0, kStep));
  EXPECT_FALSE(hold.Command(navigation::Pose{{0, 0, 0.1}, 0}, 0, kStep));
}

// That it is taken for one in a hand would leave it to the wind.
RC_GTEST_PROP(FlightHold, HoldsAFlyerInEachWindThatIsWeakerThanItsCommands, ()) {
  Flyer flyer;
  flyer.random.seed(*rc::gen::arbitrary<std::uint64_t>());
  std::uniform_real_distribution<double> any(0, 1);
  const double towards_rad = 2 * M_PI * any(flyer.random), wind_m_s = 0.4 * any(flyer.random);
  flyer.pose.yaw_rad = 2 * M_PI * any(flyer.random);
  flyer.velocity.x_m_s = any(flyer.random);
  flyer.velocity.z_m_s = 0.5 - any(flyer.random);
  FlightHold hold;
  hold.Use();
  for (int i = 0; i < 600; ++i) {
    const auto command = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
    if (!command) RC_FAIL(hold.ended());
    flyer.Move(*command);
    if (i < 100) continue;  // it comes up
    flyer.pose.at.x_m += 0.1 * wind_m_s * std::cos(towards_rad);
    flyer.pose.at.y_m += 0.1 * wind_m_s * std::sin(towards_rad);
  }
}

// As after a restart of its process. It may be in a hand, or on a table.
TEST(FlightHold, MovesNothingAfterARestartInTheAirUntilItsBatteryIsLow) {
  FlightHold hold;
  for (int i = 0; i < 600; ++i) {
    const navigation::Pose pose{{0, 0, 1 + 0.5 * std::sin(0.1 * i)}, 0};
    ASSERT_FALSE(hold.Command(pose, 0.3, kStep));
  }
  hold.SetBatteryLow(true);
  const auto down = hold.Command(navigation::Pose{{0, 0, 1}, 0}, 0, kStep);
  ASSERT_TRUE(down);
  EXPECT_LT(down->z_m_s, 0);
}

// An empty one falls. In a hand it only goes down.
TEST(FlightHold, LandsWithALowBatteryAlsoWhereTheWindCarriesIt) {
  Flyer flyer;
  FlightHold hold;
  hold.Use();
  for (int i = 0; i < 20; ++i) flyer.Move(*hold.Command(flyer.pose, flyer.speed_m_s(), kStep));
  hold.SetBatteryLow(true);
  for (int i = 0; i < 600; ++i) {
    const auto command = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
    if (!command) break;
    ASSERT_LT(command->z_m_s, 0);
    flyer.Move(*command);
    flyer.pose.at.x_m += 0.1 * 2;
    flyer.pose.at.z_m = std::max(flyer.pose.at.z_m, 0.0);
  }
  EXPECT_NEAR(flyer.pose.at.z_m, 0, 0.01);
  EXPECT_FALSE(hold.Command(flyer.pose, 0, kStep)) << "it has landed";
}

// A flyer that is not held falls when the battery is empty.
TEST(FlightHold, DescendsAtItsPlaceWithALowBatteryUntilItStandsAlsoWhenItIsReportedAgainAndAgain) {
  Flyer flyer;
  FlightHold hold;
  hold.Use();
  for (int i = 0; i < 50; ++i) flyer.Move(*hold.Command(flyer.pose, flyer.speed_m_s(), kStep));
  const navigation::Point place = flyer.pose.at;
  int steps = 0;
  for (; steps < 300; ++steps) {
    if (steps % 10 == 0) hold.SetBatteryLow(true);
    const auto command = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
    if (!command) break;
    flyer.Move(*command);
    flyer.pose.at.z_m = std::max(flyer.pose.at.z_m, 0.0);
    const double aside_m = std::hypot(flyer.pose.at.x_m - place.x_m, flyer.pose.at.y_m - place.y_m);
    ASSERT_LT(aside_m, 0.3) << "it descends straight down";
  }
  EXPECT_LT(steps, 100);
  EXPECT_NEAR(flyer.pose.at.z_m, 0, 0.01);
  EXPECT_FALSE(hold.Command(flyer.pose, 0, kStep)) << "it has landed";
  hold.SetBatteryLow(false);
  flyer.pose.at.x_m += 0.5;
  flyer.pose.at.z_m = 0.8;
  EXPECT_FALSE(hold.Command(flyer.pose, 0, kStep)) << "it is charged, and carried";
}

TEST(FlightHold, GoesOnSlowlyWithADescentThatComesNoLowerFarAboveTheGround) {
  FlightHold hold;
  navigation::Pose pose{{0, 0, 1.2}, 0};
  hold.Use();
  hold.SetBatteryLow(true);
  std::optional<navigation::Velocity> command;
  for (int i = 0; i < 100; ++i) {
    command = hold.Command(pose, 0, kStep);
    ASSERT_TRUE(command) << "it may be in an updraught, or its height an estimate that stands";
    ASSERT_LT(command->z_m_s, 0);
  }
  EXPECT_EQ(command->z_m_s, -FlightHold::kLastDescentMps);
  EXPECT_TRUE(hold.StandsHigh());
  pose.at.z_m = 1;
  command = hold.Command(pose, 0, kStep);
  ASSERT_TRUE(command);
  EXPECT_EQ(command->z_m_s, -FlightHold::kDescentMps);
  EXPECT_FALSE(hold.StandsHigh());
}

bool SeesAll(const navigation::Point&) {
  return true;
}

// With a low battery, above something wide that its sensor sees below until it has left it; returns
// the seconds until it stands on the ground.
double LandFromAbove(Flyer& flyer, double wide_m, double limit_s) {
  FlightHold hold;
  hold.SetSight(SeesAll);
  hold.Use();
  for (int i = 0; i < 50; ++i) flyer.Move(*hold.Command(flyer.pose, flyer.speed_m_s(), kStep));
  const navigation::Point above = flyer.pose.at;
  hold.SetBatteryLow(true);
  for (int i = 0; i < 10 * limit_s; ++i) {
    auto command = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
    if (!command) return i / 10.0;
    const double aside_m = std::hypot(flyer.pose.at.x_m - above.x_m, flyer.pose.at.y_m - above.y_m);
    if (command->z_m_s < 0 && aside_m < wide_m && flyer.pose.at.z_m < 2) {
      command->z_m_s = 0;
      hold.NoteStopped();
      hold.NoteHeldDescent();
    }
    flyer.Move(*command);
    flyer.pose.at.z_m = std::max(flyer.pose.at.z_m, 0.0);
  }
  return limit_s;
}

// It was held above a person who stayed, and fell once the battery was empty.
TEST(FlightHold, GoesAsideToLandWithALowBatteryWhereItsPlaceIsTaken) {
  Flyer flyer;
  flyer.pose.at.z_m = 2.2;
  EXPECT_LT(LandFromAbove(flyer, 0.5, 100), 30);
  EXPECT_EQ(flyer.pose.at.z_m, 0);
}

TEST(FlightHold, GoesFartherAsideWhereTheNearPlacesAreTakenToo) {
  Flyer flyer;
  flyer.pose.at.z_m = 2.2;
  EXPECT_LT(LandFromAbove(flyer, 1.2, 200), 120);
  EXPECT_EQ(flyer.pose.at.z_m, 0);
}

TEST(FlightHold, StaysNearItsPlaceWhereNothingAroundIsFree) {
  Flyer flyer;
  flyer.pose.at.z_m = 2.2;
  const navigation::Point begin = flyer.pose.at;
  EXPECT_EQ(LandFromAbove(flyer, 100, 1000), 1000);
  EXPECT_GT(flyer.pose.at.z_m, 1.9);
  EXPECT_LT(navigation::Distance(flyer.pose.at, begin), 3);
}

// Descends where nothing is taken; for so long, or until it has landed. `taken`: whether something
// is below it, by where it is and the seconds since the begin.
void LandAmong(Flyer& flyer, FlightHold& hold, double seconds,
               const std::function<bool(const navigation::Point&, double)>& taken) {
  for (int i = 0; i < 10 * seconds; ++i) {
    auto command = hold.Command(flyer.pose, flyer.speed_m_s(), kStep);
    if (!command) return;
    if (command->z_m_s < 0 && taken(flyer.pose.at, i / 10.0)) {
      command->z_m_s = 0;
      hold.NoteStopped();
      hold.NoteHeldDescent();
    }
    flyer.Move(*command);
    flyer.pose.at.z_m = std::max(flyer.pose.at.z_m, 0.0);
  }
}

// It flew to where nothing saw.
TEST(FlightHold, StaysAboveItsPlaceWithoutAScanAndLandsThereOnceThatIsFree) {
  Flyer flyer;
  flyer.pose.at.z_m = 2;
  FlightHold hold;
  hold.Use();
  const navigation::Point begin = flyer.pose.at;
  double farthest_m = 0;
  hold.SetBatteryLow(true);
  LandAmong(flyer, hold, 120, [&](const navigation::Point& at, double seconds) {
    farthest_m = std::max(farthest_m, std::hypot(at.x_m - begin.x_m, at.y_m - begin.y_m));
    return seconds < 60;
  });
  EXPECT_LT(farthest_m, 0.3);
  EXPECT_EQ(flyer.pose.at.z_m, 0);
}

TEST(FlightHold, GoesNoFartherAsideWhereItsScanIsLost) {
  Flyer flyer;
  flyer.pose.at.z_m = 2;
  FlightHold hold;
  hold.Use();
  const navigation::Point begin = flyer.pose.at;
  const auto aside_m = [&](const navigation::Point& at) {
    return std::hypot(at.x_m - begin.x_m, at.y_m - begin.y_m);
  };
  double farthest_m = 0;
  hold.SetSight([&](const navigation::Point&) {
    farthest_m = std::max(farthest_m, aside_m(flyer.pose.at));
    return farthest_m < 0.3;
  });
  hold.SetBatteryLow(true);
  LandAmong(flyer, hold, 60, [&](const navigation::Point& at, double) {
    farthest_m = std::max(farthest_m, aside_m(at));
    return true;
  });
  EXPECT_GT(farthest_m, 0.3);
  EXPECT_LT(farthest_m, 0.6);
}

// The person who stood below it had gone; it tried the places around again and again.
TEST(FlightHold, TriesItsFirstPlaceAgain) {
  Flyer flyer;
  flyer.pose.at.z_m = 2;
  FlightHold hold;
  hold.SetSight(SeesAll);
  hold.Use();
  const navigation::Point begin = flyer.pose.at;
  const auto aside_m = [&](const navigation::Point& at) {
    return std::hypot(at.x_m - begin.x_m, at.y_m - begin.y_m);
  };
  hold.SetBatteryLow(true);
  LandAmong(flyer, hold, 200, [&](const navigation::Point& at, double seconds) {
    return seconds < 15 || aside_m(at) > 0.4;
  });
  EXPECT_EQ(flyer.pose.at.z_m, 0);
  EXPECT_LT(aside_m(flyer.pose.at), 0.4);
}

TEST(FlightHold, GoesNotAsideByAnOdometryThatStands) {
  FlightHold hold;
  hold.SetSight(SeesAll);
  hold.Use();
  hold.SetBatteryLow(true);
  const navigation::Pose stands{{0, 0, 2}, 0};
  double commanded_m = 0;
  for (int i = 0; i < 500; ++i) {
    const auto command = hold.Command(stands, 0, kStep);
    ASSERT_TRUE(command);
    commanded_m += 0.1 * std::hypot(command->x_m_s, command->y_m_s);
    if (command->z_m_s < 0) hold.NoteHeldDescent();
  }
  EXPECT_LT(commanded_m, 0.7);
}

TEST(FlightHold, IsNotHeldOnARoofWhereItIsCharged) {
  FlightHold hold;
  navigation::Pose roof{{0, 0, 1.2}, 0};
  hold.Use();
  hold.SetBatteryLow(true);
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(hold.Command(roof, 0, kStep));
  hold.NoteCharging();
  hold.SetBatteryLow(false);
  roof.at.x_m += 0.5;
  EXPECT_FALSE(hold.Command(roof, 0, kStep)) << "a person carries it";
}

TEST(FlightHold, HasNotLandedWhereItsCommandsDoNotReachTheBody) {
  FlightHold hold;
  hold.Use();
  hold.SetBatteryLow(true);
  const navigation::Pose low{{0, 0, 0.25}, 0};
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(hold.Command(low, 0, kStep));
    hold.NoteStopped();
  }
}

TEST(FlightHold, LandsAFlyerThatNoSkillHasMovedWhenItsBatteryGetsLow) {
  FlightHold hold;
  const navigation::Pose air{{0, 0, 1}, 0};
  ASSERT_FALSE(hold.Command(air, 0, kStep));
  hold.SetBatteryLow(true);
  const auto down = hold.Command(air, 0, kStep);
  ASSERT_TRUE(down);
  EXPECT_LT(down->z_m_s, 0);
  const auto blind = hold.Command(std::nullopt, 0, kStep);
  ASSERT_TRUE(blind) << "without odometry, too";
  EXPECT_LT(blind->z_m_s, 0);
}

TEST(FlightHold, LeavesAFlyerThatStandsAtTheStartAloneWhenItsBatteryIsLow) {
  FlightHold hold;
  hold.SetBatteryLow(true);
  EXPECT_FALSE(hold.Command(std::nullopt, 0, kStep)) << "it may stand";
  EXPECT_FALSE(hold.Command(navigation::Pose{{0, 0, 0.1}, 0}, 0, kStep)) << "on a box";
  EXPECT_FALSE(hold.Command(std::nullopt, 0, kStep));
  EXPECT_FALSE(hold.Command(navigation::Pose{{0, 0, 1}, 0}, 0, kStep)) << "a person lifts it";
}

TEST(FlightHold, LeavesAFlyerThatStoodAloneWithoutOdometry) {
  FlightHold hold;
  hold.Use();
  hold.SetBatteryLow(true);
  const auto blind = hold.Command(std::nullopt, 0, kStep);
  ASSERT_TRUE(blind) << "a skill has moved it";
  EXPECT_LT(blind->z_m_s, 0);
  EXPECT_FALSE(hold.Command(navigation::Pose{}, 0, kStep));
  EXPECT_FALSE(hold.Command(std::nullopt, 0, kStep));
}

TEST(FlightHold, LeavesALandedFlyerWithALowBatteryAloneUntilItMovesAgain) {
  FlightHold hold;
  hold.Use();
  hold.Land();
  hold.SetBatteryLow(true);
  EXPECT_FALSE(hold.Command(navigation::Pose{{0, 0, 0.7}, 0}, 0, kStep)) << "it stands on a table";
}

}  // namespace musher::skills::flight_hold_test
