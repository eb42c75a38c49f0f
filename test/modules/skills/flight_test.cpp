// take_off, hover and land, with a body that has inertia and is moved by wind.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::flight_test {

using skill::Status;
using skill::Values;
using testing::Bench;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::vector<std::string> kFlights{"take_off", "hover", "land"};

class Flight : public ::testing::Test {
 protected:
  Bench bench_{"cf2x_0", "cf2x"};

  void ExpectZeroCommand() { EXPECT_EQ(bench_.robot.command, navigation::Velocity{}); }
  void InTheAir(double height_m) { bench_.robot.body.at.z_m = height_m; }
};

TEST_F(Flight, TakeOffReachesItsAltitudeAndHovers) {
  const skill::Feedback& end = bench_.Execute("take_off", {{"altitude", 2.0}});
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(end.message, "Reached altitude");
  EXPECT_EQ(end.progress, 100);
  EXPECT_NEAR(bench_.robot.body.at.z_m, 1.9, 0.1);
  ExpectZeroCommand();
  bench_.StepFor(3);
  EXPECT_NEAR(bench_.robot.body.at.z_m, 2.0, 0.1);
}

TEST_F(Flight, TakeOffReportsTheHeight) {
  bench_.Execute("take_off");
  EXPECT_EQ(bench_.messages.front(), "10 Taking off");
  EXPECT_THAT(bench_.messages, Contains(::testing::MatchesRegex("[0-9]+ 0.5m")));
  EXPECT_EQ(bench_.messages.back(), "100 Reached altitude");
  EXPECT_NEAR(bench_.feedback().details.Number("height_m"), 1, 0.1);
}

TEST_F(Flight, TakeOffClimbsAtHalfAMetreInASecond) {
  bench_.Start("take_off", {{"altitude", 8.0}});
  bench_.StepFor(3);
  const double before_m = bench_.robot.body.at.z_m;
  bench_.StepFor(4);
  EXPECT_NEAR(bench_.robot.body.at.z_m - before_m, 2, 0.05);
}

// The altitude is in the map, not above the start.
TEST_F(Flight, TakeOffFromARoofClimbsToTheAbsoluteAltitude) {
  bench_.robot.ground_m = 1.5;
  InTheAir(1.5);
  EXPECT_EQ(bench_.Execute("take_off", {{"altitude", 2.0}}).status, Status::kCompleted);
  EXPECT_NEAR(bench_.robot.body.at.z_m, 1.95, 0.1);
}

TEST_F(Flight, TakeOffStaysAboveItsStartInWind) {
  bench_.robot.body = {{3, 4, 0}, 2};
  bench_.robot.wind = {0.2, -0.15, -0.1, 0};
  EXPECT_EQ(bench_.Execute("take_off", {{"altitude", 4.0}}).status, Status::kCompleted);
  EXPECT_NEAR(bench_.robot.body.at.x_m, 3, 0.1);
  EXPECT_NEAR(bench_.robot.body.at.y_m, 4, 0.1);
  EXPECT_NEAR(bench_.robot.body.yaw_rad, 2, 0.05);
}

struct Refused {
  std::string skill;
  Values parameters;
  double height_m;
  std::string message;
};

TEST_F(Flight, RefusesImpossibleRequests) {
  const std::vector<Refused> requests{
      {"take_off", {{"altitude", 0.0}}, 0, "Invalid altitude: 0.0m is not above the ground"},
      {"take_off", {{"altitude", -1.0}}, 0, "Invalid altitude: -1.0m is not above the ground"},
      {"take_off",
       {{"altitude", 12.0}},
       0,
       "Invalid altitude: 12.0m is above the ceiling of 10.0m"},
      {"take_off",
       {{"altitude", 1.0}},
       3,
       "Invalid altitude: the robot is higher already, at 3.0m; use hover to descend to 1.0m"},
      {"hover",
       {{"altitude", -1.0}},
       1,
       "Invalid altitude: -1.0m is not between the ground and the ceiling of 10.0m"},
      {"hover",
       {{"altitude", 11.0}},
       1,
       "Invalid altitude: 11.0m is not between the ground and the ceiling of 10.0m"},
      {"hover",
       {{"altitude", 1e308}},
       1,
       "Invalid altitude: 1.0e+308m is not between the ground and the ceiling of 10.0m"},
      {"hover", {{"duration", -1.0}}, 1, "Invalid duration: it is negative"},
      {"hover", {}, 0, "The robot stands on the ground; take off first"}};
  for (const Refused& request : requests) {
    InTheAir(request.height_m);
    const skill::Feedback& end = bench_.Execute(request.skill, request.parameters);
    EXPECT_EQ(end.status, Status::kFailed) << request.message;
    EXPECT_EQ(end.message, request.message);
    EXPECT_EQ(bench_.run().now(), Duration{});  // in the first step
    ExpectZeroCommand();
  }
}

TEST_F(Flight, AGoalLowersTheCeilingOfTheRobotAndCannotRaiseIt) {
  bench_.robot.ceiling = 2.2;
  const auto message = [&](double height_m, const std::string& skill, const Values& parameters) {
    InTheAir(height_m);
    return bench_.Execute(skill, parameters).message;
  };
  EXPECT_EQ(message(0, "take_off", {{"altitude", 5.0}}),
            "Invalid altitude: 5.0m is above the ceiling of 2.2m");
  EXPECT_EQ(message(0, "take_off", {{"altitude", 5.0}, {"ceiling", 9.0}}),
            "Invalid altitude: 5.0m is above the ceiling of 2.2m");
  EXPECT_EQ(message(0, "take_off", {{"altitude", 2.0}, {"ceiling", 1.5}}),
            "Invalid altitude: 2.0m is above the ceiling of 1.5m");
  EXPECT_EQ(message(1, "hover", {{"altitude", 3.0}, {"ceiling", 9.0}}),
            "Invalid altitude: 3.0m is not between the ground and the ceiling of 2.2m");
  EXPECT_EQ(message(0, "take_off", {{"altitude", 2.0}}), "Reached altitude");
}

TEST_F(Flight, TakeOffAtItsAltitudeHasNothingToDo) {
  InTheAir(0.95);
  EXPECT_EQ(bench_.Execute("take_off").message, "Reached altitude");
  EXPECT_NEAR(bench_.robot.body.at.z_m, 0.95, 1e-9);
}

TEST_F(Flight, TakeOffToALowAltitudeIsNoSuccessOnTheGround) {
  for (const double altitude_m : {0.1, 0.15, 0.3}) {
    InTheAir(0);
    EXPECT_EQ(bench_.Execute("take_off", {{"altitude", altitude_m}}).message, "Reached altitude");
    EXPECT_GE(bench_.robot.body.at.z_m, 0.8 * altitude_m);
  }
}

// The zero of an odometry is rarely just below the feet.
TEST_F(Flight, TakeOffRisesAlsoWhereItsOdometryIsNotZeroOnTheGround) {
  for (const auto& [ground_m, altitude_m] :
       {std::pair(0.06, 0.17), std::pair(0.06, 0.3), std::pair(0.2, 0.34)}) {
    bench_.robot.ground_m = ground_m;
    InTheAir(ground_m);
    EXPECT_EQ(bench_.Execute("take_off", {{"altitude", altitude_m}}).message, "Reached altitude");
    EXPECT_GE(bench_.robot.body.at.z_m, ground_m + 0.05) << altitude_m;
  }
}

TEST_F(Flight, TakeOffRefusesAnAltitudeAtWhichItMayStand) {
  bench_.robot.ground_m = 0.06;
  InTheAir(0.06);
  for (const auto& [altitude_m, text] :
       {std::pair(0.05, "0.05"), std::pair(0.07, "0.07"), std::pair(0.15, "0.15")}) {
    const skill::Feedback& end = bench_.Execute("take_off", {{"altitude", altitude_m}});
    EXPECT_EQ(end.status, Status::kFailed);
    EXPECT_EQ(end.message, "Invalid altitude: " + std::string(text) +
                               " m is not 0.1 m above the robot, which is at 0.06 m and may stand "
                               "on the ground");
    EXPECT_EQ(bench_.robot.body.at.z_m, 0.06);
  }
}

// A localisation that jumps says nothing of where the flyer is: it flew to where its place had
// seemed to be, metres away, and had "Hovered" there.
TEST_F(Flight, EveryFlightEndsWhereItIsWhenItsPoseJumps) {
  const std::vector<navigation::Point> jumps{{5, 0, 0}, {0, -3, 0}, {0, 0, 4}};
  for (const std::string& flight : kFlights) {
    for (const navigation::Point& jump : jumps) {
      bench_.robot.body = {{0, 0, 3}, 0};
      bench_.Start(flight, flight == "land"    ? Values{}
                           : flight == "hover" ? Values{{"altitude", 4.0}, {"duration", 20.0}}
                                               : Values{{"altitude", 9.0}});
      bench_.StepFor(1);
      bench_.robot.body.at.x_m += jump.x_m;
      bench_.robot.body.at.y_m += jump.y_m;
      bench_.robot.body.at.z_m += jump.z_m;
      const navigation::Point at = bench_.robot.body.at;
      bench_.StepFor(3);  // it would fly 1.5 m
      EXPECT_EQ(bench_.feedback().status, Status::kFailed) << flight;
      EXPECT_THAT(bench_.feedback().message, HasSubstr("the pose has jumped by ")) << flight;
      ExpectZeroCommand();
      EXPECT_LT(navigation::Distance(bench_.robot.body.at, at), 0.3) << flight;
    }
  }
}

TEST_F(Flight, AFlightEndsWhereItIsWhenItsPoseHasJumpedWhileNoneCame) {
  for (const std::string flight : {"take_off", "hover"}) {
    bench_.robot.body = {{0, 0, 3}, 0};
    bench_.Start(flight, {{"altitude", 4.0}});
    bench_.StepFor(1);
    bench_.robot.has_odometry = false;
    bench_.StepFor(1.5);
    bench_.robot.has_odometry = true;
    bench_.robot.body.at.x_m += 3;
    bench_.StepFor(0.2);
    EXPECT_EQ(bench_.feedback().status, Status::kFailed) << flight;
    EXPECT_THAT(bench_.feedback().message, StartsWith("it is 3.0 m off its place: ")) << flight;
    ExpectZeroCommand();
  }
}

// It flew the jump back: metres down or up, to the height that had seemed to be its place.
TEST_F(Flight, AFlightEndsWhereItIsWhenItsHeightHasJumpedWhileNoneCame) {
  for (const std::string& flight : kFlights) {
    for (const double jump_m : {3.0, -2.0}) {
      bench_.robot.body = {{0, 0, 5}, 0};
      bench_.Start(flight, flight == "land"    ? Values{}
                           : flight == "hover" ? Values{{"altitude", 5.0}, {"duration", 20.0}}
                                               : Values{{"altitude", 9.0}});
      bench_.StepFor(1);
      bench_.robot.has_odometry = false;
      bench_.StepFor(1.9);
      bench_.robot.has_odometry = true;
      bench_.robot.body.at.z_m += jump_m;
      const navigation::Point at = bench_.robot.body.at;
      bench_.StepFor(3);
      EXPECT_EQ(bench_.feedback().status, Status::kFailed) << flight;
      EXPECT_THAT(bench_.feedback().message,
                  ::testing::MatchesRegex("its height has jumped by [123]\\.[0-9] m while no "
                                          "odometry came"))
          << flight;
      ExpectZeroCommand();
      EXPECT_LT(navigation::Distance(bench_.robot.body.at, at), 0.3) << flight;
    }
  }
}

// The hold has at most 0.5 m/s: it had failed in the air after 7 s.
TEST_F(Flight, LandLandsWhereAStrongWindCarriesIt) {
  InTheAir(10);
  bench_.robot.wind = {0.7, 0, 0, 0};
  EXPECT_EQ(bench_.Execute("land").message, "Landed");
  EXPECT_EQ(bench_.robot.body.at.z_m, 0);
  EXPECT_GT(bench_.robot.body.at.x_m, 3);
}

TEST_F(Flight, LandLandsWhereItIsAfterItWasMovedInAPause) {
  InTheAir(4);
  bench_.Start("land");
  bench_.StepFor(2);
  bench_.manager().Pause();
  for (int i = 0; i < 30; ++i) bench_.robot.Advance(Milliseconds(100));
  bench_.robot.body.at.y_m += 2;
  EXPECT_EQ(bench_.RunOut().message, "Landed");
  EXPECT_EQ(bench_.robot.body.at.z_m, 0);
  EXPECT_NEAR(bench_.robot.body.at.y_m, 2, 0.2);
}

TEST_F(Flight, LandAndHoverBeginAlsoInAFastFlight) {
  for (const std::string flight : {"land", "hover"}) {
    bench_.robot.body = {{0, 0, 3}, 0};
    bench_.robot.motion = {3, 0, 0, 0};
    bench_.robot.lag_s = 0.7;  // it brakes over 2 m
    const skill::Feedback& end =
        bench_.Execute(flight, flight == "hover" ? Values{{"altitude", 0.0}} : Values{});
    EXPECT_EQ(end.message, flight == "land" ? "Landed" : "Hovered");
  }
  EXPECT_GT(bench_.robot.body.at.x_m, 1.6) << "it stays where it has braked";
}

TEST_F(Flight, ASmallCorrectionOfItsPoseIsNoJump) {
  InTheAir(2);
  bench_.Start("hover", {{"duration", 5.0}});
  bench_.StepFor(2);
  bench_.robot.body.at.x_m += 0.9;
  EXPECT_EQ(bench_.RunOut().message, "Hovered");
}

TEST(GroundRobots, RefuseToFlyWithASentence) {
  for (const std::string kind : {"jetbot", "g1", "h1"}) {
    Bench bench(kind + "_0", kind);
    for (const std::string& flight : kFlights) {
      EXPECT_EQ(bench.Execute(flight).message, kind + "_0 is a " + kind + ", which cannot fly");
      EXPECT_EQ(bench.feedback().status, Status::kFailed);
    }
  }
}

TEST_F(Flight, TakeOffThatDoesNotClimbFailsAfterThirtySeconds) {
  bench_.robot.wind.z_m_s = -2;
  const skill::Feedback& end = bench_.Execute("take_off");
  EXPECT_EQ(end.message, "Timeout: not at 1.0m after 30 s");
  EXPECT_NEAR(bench_.seconds(), 30, 0.5);
  ExpectZeroCommand();
}

TEST_F(Flight, TakeOffAndLandTryAgainAsOftenAsARequestSays) {
  bench_.robot.wind.z_m_s = -2;
  EXPECT_EQ(bench_.Execute("take_off", {{"retries", std::int64_t{2}}}).message,
            "Timeout: not at 1.0m after 30 s");
  EXPECT_NEAR(bench_.seconds(), 90, 1);
  EXPECT_EQ(bench_.run().retries(), 2);
  ExpectZeroCommand();
}

TEST_F(Flight, HoverGoesToItsAltitudeAndStaysForItsDuration) {
  InTheAir(1);
  bench_.Start("hover", {{"altitude", 2.0}, {"duration", 4.0}});
  double hovered_s = 0;
  while (bench_.run().running()) {
    bench_.Step();
    if (bench_.feedback().state != "HOVERING") continue;
    hovered_s += 0.1;
    EXPECT_NEAR(bench_.robot.body.at.z_m, 2, 0.11);
  }
  EXPECT_EQ(bench_.feedback().status, Status::kCompleted);
  EXPECT_EQ(bench_.feedback().message, "Hovered");
  EXPECT_NEAR(hovered_s, 4, 0.2);
  EXPECT_NEAR(bench_.feedback().details.Number("held_s"), 4, 0.05);
  EXPECT_EQ(bench_.messages.front(), "0 Going to 2.0m");
  EXPECT_THAT(bench_.messages, Contains(StartsWith("50 Hovering (2.0s)")));
  ExpectZeroCommand();
}

TEST_F(Flight, HoverWithoutAnAltitudeStaysWhereItIs) {
  InTheAir(3.3);
  EXPECT_EQ(bench_.Execute("hover", {{"altitude", 0.0}}).status, Status::kCompleted);
  EXPECT_NEAR(bench_.robot.body.at.z_m, 3.3, 0.02);
}

TEST_F(Flight, HoverHoldsItsPlaceAgainstASteadyWindAndGusts) {
  InTheAir(2);
  bench_.robot.wind = {0.25, -0.2, 0.1, 0};
  bench_.Start("hover", {{"duration", 60.0}});
  bench_.StepFor(10);  // it learns the wind
  double farthest_m = 0;
  for (int i = 0; i < 400; ++i) {
    const double gust = 0.08 * std::sin(0.15 * i);
    bench_.robot.wind = {0.25 + gust, -0.2 - gust, 0.1 + gust / 2, 0};
    bench_.Step();
    farthest_m = std::max(farthest_m, bench_.feedback().details.Number("off_place_m"));
  }
  EXPECT_LT(farthest_m, 0.1);
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
}

// Time of a gust that carries it off does not count.
TEST_F(Flight, HoverCountsOnlyTheTimeAtItsHeight) {
  InTheAir(2);
  bench_.Start("hover", {{"duration", 5.0}});
  bench_.StepFor(2);
  bench_.robot.wind.z_m_s = 2;
  bench_.StepFor(2);
  bench_.robot.wind.z_m_s = 0;
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
  EXPECT_GT(bench_.seconds(), 10);
}

TEST_F(Flight, HoverFailsWhenItCannotHoldItsHeight) {
  InTheAir(2);
  bench_.Start("hover", {{"duration", 5.0}});
  bench_.StepFor(2);
  bench_.robot.wind.z_m_s = 2;
  EXPECT_THAT(bench_.RunOut().message,
              ::testing::MatchesRegex("Timeout: held the height for [12]...? of 5.0 s"));
  EXPECT_NEAR(bench_.seconds(), 35, 1);
}

TEST_F(Flight, HoverThatDoesNotReachItsAltitudeFailsAfterThirtySeconds) {
  InTheAir(1);
  bench_.robot.wind.z_m_s = -0.9;
  bench_.robot.ground_m = 0.5;
  EXPECT_EQ(bench_.Execute("hover").message, "Timeout: not at 2.0m after 30 s");
}

TEST_F(Flight, AHoverOfTwentyMinutesIsNotEndedByTheLimitOfARun) {
  InTheAir(2);
  bench_.Start("hover", {{"duration", 1200.0}});
  bench_.StepFor(1195);
  EXPECT_TRUE(bench_.run().running());
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
}

TEST_F(Flight, LandDescendsSlowerNearTheGround) {
  InTheAir(3);
  bench_.Start("land");
  double fastest_low_mps = 0;
  double fastest_mps = 0;
  while (bench_.run().running()) {
    bench_.Step();
    const double down_mps = -bench_.robot.motion.z_m_s;
    fastest_mps = std::max(fastest_mps, down_mps);
    if (bench_.robot.body.at.z_m < 0.25) fastest_low_mps = std::max(fastest_low_mps, down_mps);
  }
  EXPECT_EQ(bench_.feedback().status, Status::kCompleted);
  EXPECT_EQ(bench_.feedback().message, "Landed");
  EXPECT_EQ(bench_.robot.body.at.z_m, 0);
  EXPECT_NEAR(fastest_mps, 0.5, 0.01);
  EXPECT_LT(fastest_low_mps, 0.25);
  EXPECT_EQ(bench_.messages.front(), "0 Landing");
  ExpectZeroCommand();
}

TEST_F(Flight, LandOnTheGroundEndsAfterASecond) {
  EXPECT_EQ(bench_.Execute("land").message, "Landed");
  EXPECT_NEAR(bench_.seconds(), 1.3, 0.3);
}

TEST_F(Flight, LandsOnARoofOfWhichItKnows) {
  InTheAir(3);
  bench_.robot.ground_m = 1.2;
  EXPECT_EQ(bench_.Execute("land", {{"ground_height", 1.2}}).message, "Landed");
  EXPECT_NEAR(bench_.robot.body.at.z_m, 1.2, 1e-9);
}

// Something holds it up: that is no ground.
TEST_F(Flight, LandNeverReportsALandingInTheAir) {
  InTheAir(3);
  bench_.robot.stopped_above_m = 1.4;
  const skill::Feedback& end = bench_.Execute("land");
  EXPECT_EQ(end.message, "Timeout: it stays at 1.4m, the ground is at 0.0m");
  EXPECT_NEAR(bench_.seconds(), 30, 0.5);
  ExpectZeroCommand();
}

TEST_F(Flight, ALandingFromHighUpMayTakeLongerWhileItDescends) {
  InTheAir(40);
  EXPECT_EQ(bench_.Execute("land").message, "Landed");
  EXPECT_NEAR(bench_.seconds(), 83, 3);
}

constexpr const char* kPersonBelow = "something 1.6 m high is 0.31 m below it: it does not descend";

TEST_F(Flight, LandWaitsForAPersonBelowAndThenLands) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  bench_.Start("land");
  bench_.StepFor(6);
  EXPECT_TRUE(bench_.run().running());
  EXPECT_EQ(bench_.feedback().message, kPersonBelow);
  EXPECT_NEAR(bench_.robot.body.at.z_m, 2, 0.05);
  bench_.robot.below.clear();
  EXPECT_EQ(bench_.RunOut().message, "Landed");
}

TEST_F(Flight, LandEndsWithItsReasonAfterTenSecondsAboveAPerson) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  const skill::Feedback& end = bench_.Execute("land");
  EXPECT_EQ(end.status, Status::kFailed);
  EXPECT_EQ(end.message, kPersonBelow);
  EXPECT_NEAR(bench_.seconds(), 10, 0.5);
  ExpectZeroCommand();
}

TEST_F(Flight, LandWaitsTenSecondsInEachAttempt) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  EXPECT_EQ(bench_.Execute("land", {{"retries", std::int64_t{1}}}).message, kPersonBelow);
  EXPECT_NEAR(bench_.seconds(), 20, 1);
}

// It hovered above a person who stayed, and failed.
TEST_F(Flight, LandGoesAsideWhereItsPlaceIsTakenAsFarAsARequestSays) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  bench_.robot.is_below = [](const navigation::Point& at) {
    return std::hypot(at.x_m, at.y_m) < 0.5;
  };
  const skill::Feedback& end = bench_.Execute("land", {{"aside", 1.0}});
  EXPECT_EQ(end.message, "Landed 0.7 m aside: its place was taken");
  EXPECT_EQ(bench_.robot.body.at.z_m, 0);
  EXPECT_NEAR(std::hypot(bench_.robot.body.at.x_m, bench_.robot.body.at.y_m), 0.7, 0.2);
  EXPECT_LT(bench_.seconds(), 30);
  EXPECT_THAT(bench_.messages,
              Contains(HasSubstr("Goes 0.7 m aside to land: something 1.6 m high")));
}

// The person had gone from there meanwhile.
TEST_F(Flight, LandTriesItsFirstPlaceAgainAfterThoseAround) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  bench_.robot.is_below = [&](const navigation::Point& at) {
    return bench_.seconds() < 15 || std::hypot(at.x_m, at.y_m) > 0.4;
  };
  EXPECT_EQ(bench_.Execute("land", {{"aside", 0.8}}).message, "Landed");
  EXPECT_LT(std::hypot(bench_.robot.body.at.x_m, bench_.robot.body.at.y_m), 0.4);
  EXPECT_THAT(bench_.messages, Contains(HasSubstr("Goes back to its place to land")));
}

TEST_F(Flight, LandTriesAllPlacesWithinItsReachAndThenFailsWithWhatIsBelow) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  double farthest_m = 0;
  bench_.robot.is_below = [&](const navigation::Point& at) {
    farthest_m = std::max(farthest_m, std::hypot(at.x_m, at.y_m));
    return true;
  };
  const skill::Feedback& end = bench_.Execute("land", {{"aside", 1.5}});
  EXPECT_EQ(end.status, Status::kFailed);
  EXPECT_EQ(end.message, std::string(kPersonBelow) + "; none of 16 places within 1.5 m is free");
  EXPECT_NEAR(farthest_m, 1.4, 0.2);
  EXPECT_LT(bench_.seconds(), 120);
  ExpectZeroCommand();
}

TEST_F(Flight, LandGoesNotAsideIntoWhatItsScanSees) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  // All around, but for the last direction.
  for (int i = 0; i < 60; ++i) {
    const double angle_rad = i * 2 * M_PI / 60;
    if (std::abs(navigation::Wrapped(angle_rad + M_PI / 4)) < 0.9) continue;
    bench_.robot.scan.push_back({0.8 * std::cos(angle_rad), 0.8 * std::sin(angle_rad), 2});
  }
  bench_.robot.is_below = [](const navigation::Point& at) {
    return std::hypot(at.x_m, at.y_m) < 0.5;
  };
  EXPECT_THAT(bench_.Execute("land", {{"aside", 1.0}}).message, StartsWith("Landed"));
  EXPECT_NEAR(std::atan2(bench_.robot.body.at.y_m, bench_.robot.body.at.x_m), -M_PI / 4, 0.2);
  EXPECT_LT(bench_.seconds(), 25) << "it tries none of the others";
}

// What no scan sees has no points: all of it looked free.
TEST_F(Flight, LandGoesNotAsideWithoutAScan) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  bench_.robot.is_below = [](const navigation::Point& at) {
    EXPECT_LT(std::hypot(at.x_m, at.y_m), 0.2);
    return true;
  };
  bench_.robot.has_scan = false;
  EXPECT_EQ(bench_.Execute("land", {{"aside", 1.0}}).message,
            std::string(kPersonBelow) + "; none of 8 places within 1 m is free");
}

TEST_F(Flight, LandStopsGoingAsideWhereItsScanIsLost) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  bench_.Start("land", {{"aside", 1.0}});
  bench_.StepFor(10.4);
  bench_.robot.has_scan = false;
  const double was_m = bench_.robot.body.at.x_m;
  bench_.RunOut();
  EXPECT_LT(std::abs(bench_.robot.body.at.x_m - was_m), 0.3);
}

TEST_F(Flight, LandTriesAnotherPlaceWhereItsGateHoldsItOnItsWayAside) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  bench_.robot.is_below = [](const navigation::Point&) { return true; };
  bench_.Start("land", {{"aside", 1.0}});
  bench_.StepFor(10.5);
  bench_.robot.held_by = "an obstacle";
  bench_.StepFor(15);
  EXPECT_TRUE(bench_.run().running());
  bench_.robot.held_by.clear();
  bench_.robot.below.clear();
  EXPECT_THAT(bench_.RunOut().message, StartsWith("Landed"));
}

// Its height says nothing then either, so that all places look taken: it flew on to the next ones
// blindly.
TEST_F(Flight, LandGoesNotAsideByAnOdometryThatStands) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  bench_.Start("land", {{"aside", 5.0}});
  const navigation::Pose stands = bench_.robot.body;
  double commanded_m = 0;
  while (bench_.run().running() && bench_.seconds() < 60) {
    bench_.Step();
    bench_.robot.body = stands;
    commanded_m += 0.1 * std::hypot(bench_.robot.command.x_m_s, bench_.robot.command.y_m_s);
  }
  EXPECT_EQ(bench_.feedback().message,
            std::string(kPersonBelow) + "; commanded aside, but its odometry does not change");
  EXPECT_LT(commanded_m, 0.7);
}

TEST_F(Flight, LandGoesOnAsideInAnotherProcess) {
  InTheAir(2);
  bench_.robot.below = kPersonBelow;
  bench_.robot.is_below = [](const navigation::Point& at) {
    return std::hypot(at.x_m, at.y_m) < 0.5;
  };
  bench_.Start("land", {{"aside", 1.0}});
  bench_.StepFor(11);
  bench_.Restore();
  EXPECT_EQ(bench_.RunOut().message, "Landed 0.7 m aside: its place was taken");
}

TEST_F(Flight, LandRefusesAReachThatIsNone) {
  InTheAir(2);
  const auto message = [&](double reach_m) {
    return bench_.Execute("land", {{"aside", reach_m}}).message;
  };
  EXPECT_EQ(message(-1), "Invalid aside: -1.0m is not between 0 and 5 m");
  EXPECT_EQ(message(5.1), "Invalid aside: 5.1m is not between 0 and 5 m");
  EXPECT_EQ(message(1e308), "Invalid aside: 1.0e+308m is not between 0 and 5 m");
}

// Close to a wall, which a wide cone sees as well.
TEST_F(Flight, LandGoesOnWhereItDescendsSlowly) {
  InTheAir(3);
  bench_.robot.below = kPersonBelow;
  bench_.robot.below_m_s = 0.1;
  bench_.Start("land");
  bench_.StepFor(25);
  EXPECT_TRUE(bench_.run().running());
  EXPECT_LT(bench_.robot.body.at.z_m, 0.7);
  bench_.robot.below.clear();
  EXPECT_EQ(bench_.RunOut().message, "Landed");
}

// Its height stands there, near the ground, above a thing that the gate does not let it sink onto.
TEST_F(Flight, LandReportsNoLandingWhereItsDescentIsHeld) {
  InTheAir(0.29);
  bench_.robot.below = "something 0.3 m high is 0.00 m below it: it does not descend";
  EXPECT_EQ(bench_.Execute("land").message, bench_.robot.below);
}

TEST_F(Flight, HoverEndsWithItsReasonWhereItCannotDescend) {
  InTheAir(3);
  bench_.robot.below = kPersonBelow;
  EXPECT_EQ(bench_.Execute("hover", {{"altitude", 1.0}}).message, kPersonBelow);
  EXPECT_NEAR(bench_.seconds(), 10, 1);
}

// Neither a pause nor a time without odometry is a landing.
TEST_F(Flight, LandCountsOnlyTimeInWhichItDescends) {
  InTheAir(0.25);
  bench_.robot.stopped_above_m = 0.25;
  bench_.Start("land");
  bench_.StepFor(0.8);
  bench_.robot.has_odometry = false;
  bench_.StepFor(1.5);
  bench_.robot.has_odometry = true;
  bench_.manager().Pause();
  for (int i = 0; i < 30; ++i) bench_.robot.Advance(Milliseconds(100));
  bench_.robot.stopped_above_m = -1;
  bench_.Step();
  EXPECT_TRUE(bench_.run().running());
  EXPECT_EQ(bench_.RunOut().message, "Landed");
  EXPECT_EQ(bench_.robot.body.at.z_m, 0);
}

TEST_F(Flight, EveryFlightFailsWithoutOdometryForTwoSecondsAndHoversUntilThen) {
  for (const std::string& flight : kFlights) {
    InTheAir(0.5);
    bench_.robot.has_odometry = true;
    bench_.Start(flight, flight == "land" ? Values{} : Values{{"altitude", 5.0}});
    bench_.StepFor(0.5);
    EXPECT_NE(bench_.robot.command, navigation::Velocity{});
    bench_.robot.has_odometry = false;
    bench_.Step();
    ExpectZeroCommand();
    EXPECT_EQ(bench_.feedback().message, "Waiting for odometry");
    const double lost_s = bench_.seconds();
    EXPECT_EQ(bench_.RunOut().message, "No odometry of cf2x_0 for 2 s");
    EXPECT_NEAR(bench_.seconds() - lost_s, 2, 0.15);
  }
}

TEST_F(Flight, EveryFlightTreatsAPoseThatIsNotANumberAsMissing) {
  for (const std::string& flight : kFlights) {
    bench_.robot.body.at.x_m = std::nan("");
    EXPECT_THAT(bench_.Execute(flight).message, HasSubstr("No odometry"));
    ExpectZeroCommand();
  }
}

TEST_F(Flight, EveryFlightGoesOnWhenOdometryIsBackInTime) {
  InTheAir(0.5);
  for (const std::string& flight : kFlights) {
    bench_.Start(flight);
    bench_.StepFor(0.5);
    bench_.robot.has_odometry = false;
    bench_.StepFor(1.5);
    bench_.robot.has_odometry = true;
    EXPECT_EQ(bench_.RunOut().status, Status::kCompleted) << flight;
  }
}

TEST_F(Flight, ACancellationInEachStateLeavesItHovering) {
  for (const std::string& flight : kFlights) {
    for (const double after_s : {0.0, 0.1, 0.2, 1.0, 3.0}) {
      InTheAir(4);
      bench_.Start(flight, flight == "land"    ? Values{}
                           : flight == "hover" ? Values{{"altitude", 4.5}}
                                               : Values{{"altitude", 9.0}});
      bench_.StepFor(after_s);
      ASSERT_TRUE(bench_.run().running());
      ASSERT_TRUE(bench_.manager().Cancel(flight, "by the operator").ok());
      bench_.Step();
      EXPECT_EQ(bench_.feedback().status, Status::kCancelled);
      EXPECT_EQ(bench_.feedback().message, "by the operator");
      ExpectZeroCommand();
      const double height_m = bench_.robot.body.at.z_m;
      bench_.StepFor(5);
      EXPECT_NEAR(bench_.robot.body.at.z_m, height_m, 0.12);
    }
  }
}

TEST_F(Flight, APauseInEachStateHoversAndThenGoesOn) {
  for (const std::string& flight : kFlights) {
    for (const double after_s : {0.1, 0.2, 1.0, 3.0}) {
      InTheAir(3);
      bench_.Start(flight, flight == "land"    ? Values{}
                           : flight == "hover" ? Values{{"altitude", 3.5}}
                                               : Values{{"altitude", 5.0}});
      bench_.StepFor(after_s);
      ASSERT_TRUE(bench_.run().running()) << flight << after_s;
      bench_.manager().Pause();
      ExpectZeroCommand();
      for (int i = 0; i < 600; ++i) bench_.robot.Advance(Milliseconds(100));
      EXPECT_EQ(bench_.RunOut().status, Status::kCompleted) << flight << after_s;
    }
  }
}

// The pause of a state, after which no person has asked it to go on.
TEST_F(Flight, DoesNotGoOnAfterAPauseInWhichItWasPutDownOrTaken) {
  for (const std::string flight : {"take_off", "hover"}) {
    for (const bool put_down : {false, true}) {
      InTheAir(3);
      bench_.robot.not_held.clear();
      bench_.Start(flight, {{"altitude", 5.0}});
      bench_.StepFor(1);
      ASSERT_TRUE(bench_.run().running());
      bench_.manager().Pause();
      bench_.robot.motion = {};
      if (put_down) {
        InTheAir(0);
      } else {
        bench_.robot.not_held = "it came 0.50 m lower than its place against its commands";
      }
      const double height_m = bench_.robot.body.at.z_m;
      EXPECT_EQ(bench_.RunOut().status, Status::kFailed) << flight << put_down;
      EXPECT_THAT(bench_.feedback().message,
                  HasSubstr(put_down ? "stands on the ground now" : "it came 0.50 m lower"));
      ExpectZeroCommand();
      EXPECT_LE(bench_.robot.body.at.z_m, height_m + 0.05);
    }
  }
}

TEST_F(Flight, DoesNotGoOnInAnotherProcessFromTheGround) {
  InTheAir(3);
  bench_.Start("hover", {{"altitude", 3.0}, {"duration", 60.0}});
  bench_.StepFor(3);
  bench_.Restore();
  bench_.robot.command = {};
  bench_.robot.motion = {};
  InTheAir(0);
  EXPECT_EQ(bench_.RunOut().status, Status::kFailed);
  EXPECT_EQ(bench_.robot.body.at.z_m, 0);
}

}  // namespace musher::skills::flight_test
