// A flyer above what a range sensor sees that looks down: what it may descend to, what a wrong,
// late or missing sample does, and that no velocity of any source leads it onto what the sensor
// sees.

#include "musher/navigation/gate/descent_watch.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <optional>

#include "musher/navigation/gate/motion_gate.hpp"
#include "musher/test/navigation/descent_run.hpp"

namespace musher::navigation::testing::descent_watch_test {

using ::testing::HasSubstr;
using Kind = GateVerdict::Kind;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Velocity kDown{0, 0, -0.5, 0};

class Descent : public ::testing::Test {
 protected:
  Descent() {
    rules_.down.topic = "range_down";
    rules_.down.person_m_s = 0;  // those of AmongPersons walk
    Rebuild();
  }
  void Rebuild() { gate_.emplace(rules_); }
  void At(double height_m) { gate_->OnHeight(height_m, now_); }
  bool Sees(double range_m) {
    now_ += Milliseconds(50);
    return gate_->OnRange({range_m, 0.05, 4, 1.05}, now_.time_since_epoch(), now_);
  }
  void SeesTwice(double range_m) {
    Sees(range_m);
    Sees(range_m + 0.001);
  }
  GateVerdict Check(const Velocity& wanted = kDown) { return gate_->Check(wanted, now_); }

  GateRules rules_;
  Time now_ = Time{} + std::chrono::seconds(100);
  std::optional<MotionGate> gate_;
};

TEST_F(Descent, GoesOnAboveTheGround) {
  At(2);
  SeesTwice(2);
  EXPECT_EQ(Check().command, kDown);
  EXPECT_EQ(Check().kind, Kind::kFree);
}

TEST_F(Descent, IsSlowedAndHeldAboveWhatIsHigherThanTheGround) {
  At(2.4);
  double before_m_s = 0.6;
  for (const double range_m : {1.2, 0.9, 0.7, 0.6, 0.5, 0.4}) {
    Rebuild();
    At(2.4);
    SeesTwice(range_m);
    const double down_m_s = -Check().command.z_m_s;
    EXPECT_LE(down_m_s, before_m_s) << range_m;
    before_m_s = down_m_s;
  }
  EXPECT_EQ(Check().command, Velocity{});
  EXPECT_EQ(Check().kind, Kind::kStopped);
  EXPECT_THAT(Describe(Check()),
              HasSubstr("something 2.0 m high is 0.35 m below it: it does not descend"));
}

TEST_F(Descent, HoldsClimbsAndMotionsAsideNot) {
  At(2);
  SeesTwice(0.3);
  EXPECT_EQ(Check({0, 0, 0.5, 0}).command, (Velocity{0, 0, 0.5, 0}));
  EXPECT_EQ(Check({0.5, 0.2, -0.1, 1}).command, (Velocity{0.5, 0.2, 0, 1}));
  EXPECT_EQ(Check({0.5, 0.2, -0.1, 1}).kind, Kind::kSlowed);
}

// A sensor with a narrow cone does not see what the rim of the body is about to touch.
TEST_F(Descent, KeepsMoreAboveThingsWhereTheConeIsNarrower) {
  rules_.down.cone_rad = 0.4;
  Rebuild();
  At(2.5);
  SeesTwice(0.9);  // the cone is as wide as the body from 0.99 m on
  EXPECT_EQ(Check().kind, Kind::kStopped);
  rules_.down.cone_rad = 1.2;
  Rebuild();
  At(2.5);
  SeesTwice(0.9);
  EXPECT_EQ(Check().kind, Kind::kFree);
}

TEST_F(Descent, CountsWhatItHasSunkSinceTheSample) {
  At(2.4);
  SeesTwice(0.65);
  ASSERT_LT(Check().command.z_m_s, -0.3);
  gate_->OnVelocity({}, now_);  // its odometry says that it stands
  for (int i = 0; i < 8; ++i) {
    now_ += Milliseconds(50);
    At(2.4);
    Check();
  }
  EXPECT_GT(Check().command.z_m_s, -0.25) << "by its commands it has come nearer";
}

// --- A sample that is wrong, late or missing ---

TEST_F(Descent, IsStoppedByOneSampleAndReleasedByTwo) {
  At(2);
  SeesTwice(2);
  Sees(0.3);
  EXPECT_EQ(Check().kind, Kind::kStopped);
  Sees(2);
  EXPECT_EQ(Check().kind, Kind::kStopped) << "the one before may be right";
  Sees(2.001);
  EXPECT_EQ(Check().kind, Kind::kFree);
}

TEST_F(Descent, IsHeldWithoutTwoRecentSamples) {
  At(2);
  EXPECT_EQ(Check().kind, Kind::kStopped);
  EXPECT_EQ(Describe(Check()), "no recent range on range_down: it does not descend blindly");
  Sees(2);
  EXPECT_EQ(Check().kind, Kind::kStopped);
  Sees(2.001);
  EXPECT_EQ(Check().kind, Kind::kFree);
  now_ += Milliseconds(600);
  At(2);
  EXPECT_EQ(Check().kind, Kind::kStopped);
}

TEST_F(Descent, IsNotReleasedByOneSampleThatComesTwiceOrWithAnOldStamp) {
  At(2);
  SeesTwice(2);
  Sees(0.3);
  const Duration stamp = now_.time_since_epoch();
  EXPECT_FALSE(gate_->OnRange({2, 0.05, 4, 1.05}, stamp, now_));
  EXPECT_FALSE(gate_->OnRange({2, 0.05, 4, 1.05}, stamp - Milliseconds(75), now_));
  EXPECT_EQ(Check().kind, Kind::kStopped);
}

TEST_F(Descent, UsesNoSampleThatIsNoRange) {
  At(2);
  for (const double range_m : {std::nan(""), -1.0, -0.01}) EXPECT_FALSE(Sees(range_m)) << range_m;
  EXPECT_EQ(Check().kind, Kind::kStopped);
}

TEST_F(Descent, TakesTooNearToBeMeasuredForNear) {
  At(2);
  SeesTwice(-kInfinity);
  EXPECT_EQ(Check().kind, Kind::kStopped);
  SeesTwice(0.01);
  EXPECT_EQ(Check().kind, Kind::kStopped);
}

// Hair and coats do not reflect sound, and dark carpets no light.
TEST_F(Descent, BelievesInNothingInRangeOnlyWhereTheGroundIsOutOfRange) {
  At(6);
  SeesTwice(kInfinity);
  EXPECT_EQ(Check().kind, Kind::kFree);
  now_ += std::chrono::seconds(1);
  At(2);
  EXPECT_FALSE(Sees(kInfinity));
  EXPECT_FALSE(Sees(4.2));
  EXPECT_EQ(Check().kind, Kind::kStopped);
}

TEST_F(Descent, IsHeldByASensorThatStandsWhileItsHeightChanges) {
  double height_m = 3;
  bool held = false;
  for (int i = 0; i < 40 && !held; ++i, height_m -= 0.025) {
    gate_->OnVelocity(kDown, now_);
    At(height_m);
    Sees(2.5);
    held = Check().kind == Kind::kStopped;
  }
  EXPECT_TRUE(held);
  EXPECT_GT(height_m, 2.3);
}

TEST_F(Descent, TakesTheLimitsOfTheConfigBeforeThoseOfTheMessages) {
  rules_.down.most_m = 1.2;
  Rebuild();
  At(6);
  SeesTwice(3);  // beyond what the sensor can know
  const double down_m_s = -Check({0, 0, -3, 0}).command.z_m_s;
  EXPECT_LT(down_m_s, 1.5) << "something may be 1.2 m below";
}

// --- What it moves to ---

// It saw ground, and sank onto a head that came into its cone too late.
TEST_F(Descent, IsHeldWhileItFliesToWhereItsSensorHasNotSeen) {
  At(2.4);
  SeesTwice(2.4);
  const Velocity slope{0.8, 0, -0.6, 0};
  EXPECT_EQ(Check(slope).command, slope) << "it stands still above what it sees";
  for (int i = 0; i < 10; ++i) {
    gate_->OnVelocity(slope, now_);
    At(2.4);
    Sees(2.4 + 0.001 * i);
    Check(slope);
  }
  EXPECT_EQ(Check(slope).command, (Velocity{0.8, 0, 0, 0}));
  EXPECT_EQ(Check(slope).kind, Kind::kSlowed) << "it flies on";
  EXPECT_EQ(Describe(Check(slope)),
            "its sensor does not see below where it flies to: it stays level");
  for (int i = 0; i < 10; ++i) {
    gate_->OnVelocity({}, now_);
    At(2.4);
    Sees(2.4 + 0.001 * i);
    Check({0, 0, -0.6, 0});
  }
  EXPECT_EQ(Check({0, 0, -0.6, 0}).kind, Kind::kFree);
}

TEST_F(Descent, GoesBackToTheLevelAboveWhichItWasLiftedOnItsWay) {
  At(2);
  SeesTwice(2);
  double lowered_m_s = 0;
  for (const double height_m : {2.0, 2.0, 2.1, 2.2, 2.3, 2.2, 2.1, 2.001}) {
    gate_->OnVelocity({0.8, 0, 0, 0}, now_);
    At(height_m);
    Sees(height_m + 0.001);
    const bool lifted = height_m > 2;
    lowered_m_s = -Check({0.8, 0, lifted ? -0.2 : 0.1, 0}).command.z_m_s;
    EXPECT_TRUE(height_m < 2.05 || lowered_m_s == 0.2) << height_m << ' ' << lowered_m_s;
  }
  EXPECT_LT(lowered_m_s, 0.02);
}

// It leans against the wind, or is carried by it.
TEST_F(Descent, IsNotHeldByTheWind) {
  for (const double drift_m_s : {0.0, -0.4}) {
    Rebuild();
    for (int i = 0; i < 10; ++i) {
      gate_->OnVelocity({drift_m_s, 0, 0, 0}, now_);
      At(2);
      Sees(2 + 0.001 * i);
      Check({0.5, 0, -0.5, 0});
    }
    EXPECT_EQ(Check({0.5, 0, -0.5, 0}).command.z_m_s, -0.5) << drift_m_s;
  }
}

TEST_F(Descent, GoesSlowlyOnItsWayWhereItHasToLand) {
  gate_->MustLand(true);
  for (int i = 0; i < 10; ++i) {
    gate_->OnVelocity({0.5, 0, 0, 0}, now_);
    At(2);
    Sees(2 + 0.001 * i);
    Check({0.5, 0, -0.5, 0});
  }
  EXPECT_EQ(Check({0.5, 0, -0.5, 0}).command.z_m_s, -0.1);
}

// --- What is ground ---

TEST_F(Descent, LandsOnWhatIsAsHighAsTheGroundAndOnNothingHigher) {
  for (const double surface_m : {-0.3, 0.0, 0.2}) {
    Rebuild();
    At(0.6);
    SeesTwice(0.6 - surface_m);
    EXPECT_EQ(Check().kind, Kind::kFree) << surface_m;
  }
  for (const double surface_m : {0.3, 0.5}) {
    Rebuild();
    At(0.6);
    SeesTwice(0.6 - surface_m);
    EXPECT_EQ(Check().kind, Kind::kStopped) << surface_m;
  }
}

TEST_F(Descent, EndsOnTheGroundWhereTheSensorIsTooNearToMeasure) {
  At(0.2);
  SeesTwice(-kInfinity);
  EXPECT_EQ(Check().kind, Kind::kFree);
  Rebuild();
  At(0.2);
  EXPECT_EQ(Check().kind, Kind::kFree) << "nothing higher than its tolerance fits below it";
}

TEST_F(Descent, LandsOnATableWhoseHeightItIsGiven) {
  At(1.5);
  SeesTwice(0.5);
  EXPECT_NE(Check().kind, Kind::kFree);
  gate_->ExpectGround(1.0);
  EXPECT_EQ(Check().kind, Kind::kFree);
  gate_->ExpectGround(std::nullopt);
  EXPECT_NE(Check().kind, Kind::kFree);
}

TEST_F(Descent, TakesNothingForGroundWithoutAHeight) {
  SeesTwice(0.3);
  EXPECT_EQ(Check().kind, Kind::kStopped);
  EXPECT_THAT(Describe(Check()), HasSubstr("something is 0.26 m below it"));
  At(0.5);
  SeesTwice(0.3);
  ASSERT_EQ(Check().kind, Kind::kFree);
  for (int i = 0; i < 12; ++i) SeesTwice(0.3 + 0.002 * i);
  EXPECT_EQ(Check().kind, Kind::kStopped) << "the height is old";
}

// The state estimate of a small flyer takes the range for its height, above a head as well.
TEST_F(Descent, IsHeldAboveAHeadThatItsHeightFollows) {
  At(2);
  SeesTwice(2);
  ASSERT_EQ(Check().kind, Kind::kFree);
  At(0.4);
  SeesTwice(0.4);
  EXPECT_EQ(Check().kind, Kind::kStopped);
  EXPECT_THAT(Describe(Check()), HasSubstr("something 1.6 m high"));
  At(2);
  SeesTwice(2);
  EXPECT_EQ(Check().kind, Kind::kFree) << "it has gone away";
}

// A localisation is corrected for good; and one that jumps up is in doubt higher.
TEST_F(Descent, LandsAgainAMinuteAfterItsHeightWasCorrected) {
  At(2);
  SeesTwice(2);
  At(0.5);
  SeesTwice(0.4);
  EXPECT_NE(Check().kind, Kind::kFree);
  now_ += std::chrono::seconds(61);
  At(0.5);
  SeesTwice(0.4);
  EXPECT_EQ(Check().kind, Kind::kFree);
  At(1.5);
  SeesTwice(0.4);
  EXPECT_THAT(Describe(Check()), HasSubstr("something 1.1 m high"));
  At(1.8);
  SeesTwice(0.4);
  EXPECT_THAT(Describe(Check()), HasSubstr("something 1.4 m high"));
}

// --- It has to land ---

TEST_F(Descent, GoesSlowlyWithoutASensorWhereItHasToLand) {
  At(2);
  gate_->MustLand(true);
  EXPECT_EQ(Check().command, (Velocity{0, 0, -0.1, 0}));
  EXPECT_THAT(Describe(Check()), HasSubstr("descends slowly"));
  SeesTwice(0.3);
  EXPECT_EQ(Check().kind, Kind::kStopped) << "onto a person it does not sink";
  gate_->MustLand(false);
  now_ += std::chrono::seconds(1);
  At(2);
  EXPECT_EQ(Check().kind, Kind::kStopped);
}

TEST_F(Descent, IsNotCheckedWithoutASensor) {
  rules_.down.topic.clear();
  Rebuild();
  EXPECT_EQ(Check().kind, Kind::kFree);
}

// --- A person comes from the side ---

class AmongPersons : public Descent {
 protected:
  AmongPersons() {
    rules_.down.person_m_s = DownRules{}.person_m_s;
    rules_.scanners = {{.topic = "scan"}};
    Rebuild();
  }
  // The planar scan sees a wall all around.
  void SeesWall(double away_m) {
    const Scan scan{-M_PI, M_PI / 180, 0.02, 8,
                    std::vector<float>(360, static_cast<float>(away_m))};
    ASSERT_TRUE(gate_->OnScan(0, scan, now_.time_since_epoch(), now_));
  }
  // For a while, at this height.
  void SeesFor(double seconds, double range_m, double wall_m = 5) {
    for (int i = 0; i < 20 * seconds; ++i) {
      At(height_m_);
      Sees(range_m + 0.001 * (i % 2));
      SeesWall(wall_m);
      Check();
    }
    At(height_m_);
  }

  double height_m_ = 1.5;
};

TEST_F(AmongPersons, DescendsSlowlyWhereOneMayComeBelowIt) {
  SeesFor(0.5, height_m_);
  EXPECT_EQ(Check().command, (Velocity{0, 0, -0.1, 0}));
  EXPECT_EQ(Check().kind, Kind::kSlowed);
  EXPECT_TRUE(Check().careful);
  EXPECT_EQ(Describe(Check()), "a person may come below it: it descends slowly");
  rules_.down.low_m_s = 0.2;
  Rebuild();
  SeesFor(0.5, height_m_);
  EXPECT_EQ(Check().command.z_m_s, -0.2);
  rules_.down.person_m_s = 0;
  Rebuild();
  SeesFor(0.5, height_m_);
  EXPECT_EQ(Check().command, kDown) << "there are none";
}

TEST_F(AmongPersons, BrakesInTimeBeforeItIsAsLowAsThey) {
  double before_m_s = 5;
  for (height_m_ = 3; height_m_ > 1.95; height_m_ -= 0.1) {
    Rebuild();
    SeesFor(0.5, height_m_);
    const double down_m_s = -Check({0, 0, -5, 0}).command.z_m_s;
    EXPECT_LT(down_m_s, before_m_s) << height_m_;
    const double stops_m =
        down_m_s * rules_.reaction_s + (down_m_s * down_m_s) / (2 * rules_.brake_m_s2);
    EXPECT_TRUE(down_m_s < 0.5 || stops_m < height_m_ - 2 + 0.01) << height_m_;
    before_m_s = down_m_s;
  }
}

TEST_F(AmongPersons, DescendsFasterByAWiderConeWhichSeesThemEarlier) {
  rules_.down.cone_rad = 2;
  Rebuild();
  SeesFor(0.5, height_m_);
  EXPECT_LT(Check().command.z_m_s, -0.45);
  rules_.down.most_m = 1;
  Rebuild();
  SeesFor(0.5, height_m_);
  EXPECT_GT(Check().command.z_m_s, -0.4) << "it does not reach so far";
}

// What is 0.9 m away was taken for the top of something 0.8 m high, far below.
TEST_F(AmongPersons, IsHeldByOneWhoComesFromTheSide) {
  SeesFor(1, height_m_);
  for (const double range_m : {1.2, 1.1, 1.0}) {
    At(height_m_);
    Sees(range_m);
    SeesWall(5);
    Check();
  }
  EXPECT_EQ(Check().command, Velocity{});
  EXPECT_EQ(Check().kind, Kind::kStopped);
  EXPECT_FALSE(Check().careful);
  EXPECT_THAT(Describe(Check()), HasSubstr("something 0.5 m high or higher is below it, or 0.30 m "
                                           "beside it: it does not descend"));
}

TEST_F(AmongPersons, GoesOnBesideOneWhoStandsFarEnoughAwayToStopWhereThatStepsOff) {
  SeesFor(1, height_m_);
  SeesFor(1.5, 0.9);
  EXPECT_EQ(Check().command.z_m_s, -0.1);
  SeesFor(1.5, 0.6);
  EXPECT_EQ(Check().kind, Kind::kStopped);
  SeesFor(1.5, 0.6, 0.3);
  EXPECT_EQ(Check().command.z_m_s, -0.1) << "it is a wall, which its scan sees as well";
  SeesFor(1.5, 0.6, 0.8);
  EXPECT_EQ(Check().kind, Kind::kStopped) << "the wall is elsewhere";
}

TEST_F(AmongPersons, TakesNoWallForOneWhoComesWhereItDriftsTowardsIt) {
  SeesFor(2, 0.9);
  for (int i = 0; i < 8; ++i) {  // with 0.2 m/s
    gate_->OnVelocity({0.2, 0, 0, 0}, now_);
    At(height_m_);
    Sees(0.9 - 0.01 / std::sin(0.525) * i);
    Check();
  }
  EXPECT_EQ(Check().command.z_m_s, -0.1);
}

TEST_F(AmongPersons, DescendsSlowlyBesideWhatStandsWhereItHasToLand) {
  gate_->MustLand(true);
  SeesFor(1.5, 0.6);
  EXPECT_EQ(Check().command.z_m_s, -0.1);
  Sees(0.4);
  EXPECT_EQ(Check().kind, Kind::kStopped) << "that comes nearer";
}

TEST_F(AmongPersons, DescendsSlowlyWithoutAHeight) {
  for (int i = 0; i < 40; ++i) {
    Sees(3.5 + 0.001 * (i % 2));
    SeesWall(5);
  }
  EXPECT_EQ(Check().command.z_m_s, -0.1);
}

// --- A flyer never comes down onto what its sensor sees ---

void ExpectNoContactFromAbove(std::uint64_t from, std::uint64_t to) {
  for (std::uint64_t seed = from; seed < to; ++seed) {
    const DescentRun run = RunDescents(seed, true);
    EXPECT_EQ(run.sunk_onto, 0) << "seed " << seed;
    EXPECT_EQ(run.touched, 0) << "seed " << seed;
    EXPECT_TRUE(run.landed) << "seed " << seed;
  }
}

TEST(AnyDescent, LeadsAFlyerOntoPersonsWithoutTheSensor) {
  int sunk_onto = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) sunk_onto += RunDescents(seed, false).sunk_onto;
  EXPECT_GE(sunk_onto, 10);
}

TEST(AnyDescent, LeadsNoFlyerOntoWhatItsSensorSeesAndEndsOnFreeGround) {
  ExpectNoContactFromAbove(1, 60);
}

TEST(AnyDescentNightly, LeadsNoFlyerOntoWhatItsSensorSeesAndEndsOnFreeGround) {
  ExpectNoContactFromAbove(1000, 4000);
}

}  // namespace musher::navigation::testing::descent_watch_test
