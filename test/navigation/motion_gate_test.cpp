// The gate before a body: what it lets through, slows down and stops, and that no command of any
// source leads a body into what it sees.

#include "musher/navigation/gate/motion_gate.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "musher/test/navigation/gate_run.hpp"

namespace musher::navigation::testing::motion_gate_test {

using ::testing::HasSubstr;
using Kind = GateVerdict::Kind;

constexpr Velocity kAhead{1, 0, 0, 0};

GateRules Rules() {
  GateRules rules;
  rules.scanners = {{.topic = "scan"}};
  return rules;
}

// A scan around the body with 360 rays, which hits something at these angles and ranges.
Scan ScanOf(const std::vector<std::pair<int, double>>& hits = {}) {
  Scan scan{0, M_PI / 180, 0.05, 8, std::vector<float>(360, 9.0F)};
  for (const auto& [degrees, range_m] : hits) {
    scan.ranges_m[static_cast<std::size_t>((degrees + 360) % 360)] = static_cast<float>(range_m);
  }
  return scan;
}

class Gate : public ::testing::Test {
 protected:
  void See(const std::vector<std::pair<int, double>>& hits = {}) {
    ASSERT_TRUE(gate_->OnScan(0, ScanOf(hits), Duration{}, now_));
  }
  GateVerdict Check(const Velocity& wanted) { return gate_->Check(wanted, now_); }
  void Rebuild(const GateRules& rules) { gate_.emplace(rules); }

  Time now_ = Time{} + std::chrono::seconds(100);
  std::optional<MotionGate> gate_{std::in_place, Rules()};
};

TEST_F(Gate, LetsAFreeBodyPassUnchanged) {
  See({{180, 0.5}, {90, 0.4}});
  const Velocity wanted{1, 0, 0.2, 0.05};
  EXPECT_EQ(Check(wanted).command, wanted);
  EXPECT_EQ(Check(wanted).kind, Kind::kFree);
  EXPECT_EQ(Describe(Check(wanted)), "");
}

TEST_F(Gate, SlowsABodyDownInProportionAndStopsItBeforeWhatItSees) {
  double before_m_s = 2;
  for (const double range_m : {1.2, 0.8, 0.6, 0.45, 0.3, 0.24}) {
    Rebuild(Rules());
    See({{0, range_m}});
    const double speed_m_s = Check({1.5, 0, 0, 0}).command.x_m_s;
    EXPECT_LE(speed_m_s, before_m_s) << range_m;
    EXPECT_LE(speed_m_s * 0.2 + speed_m_s * speed_m_s / 4, std::max(0.0, range_m - 0.25) + 1e-9)
        << "it can stop before it";
    before_m_s = speed_m_s;
  }
  const GateVerdict verdict = Check({1.5, 0, 0, 0});
  EXPECT_EQ(verdict.kind, Kind::kStopped);
  EXPECT_EQ(verdict.command, Velocity{});
  EXPECT_EQ(Describe(verdict), "an obstacle 0.24 m away, straight ahead, stops it");
}

class GateBesideMovers : public Gate {
 protected:
  // The body goes ahead with 1 m/s for half a second and sees something 11 degrees wide in this
  // direction, whose range changes by so much a second and ends as given; behind it is a wall.
  GateVerdict AfterHalfASecond(int degrees, double last_m, double change_m_s) {
    for (int tenth = 5; tenth >= 0; --tenth) {
      std::vector<std::pair<int, double>> hits;
      for (int i = -30; i <= 30; ++i) hits.emplace_back(degrees + i, 7);
      for (int i = -5; i <= 5; ++i) {
        hits.emplace_back(degrees + i, last_m - change_m_s * 0.1 * tenth);
      }
      gate_->OnVelocity(kAhead, now_);
      See(hits);
      verdict_ = Check(kAhead);
      if (tenth > 0) now_ += Milliseconds(100);
    }
    return verdict_;
  }

  GateVerdict verdict_;
};

// Two robots met head-on in a corridor: each could stop before where the other was.
TEST_F(GateBesideMovers, BrakesEarlierBeforeWhatComesTowardsIt) {
  EXPECT_EQ(AfterHalfASecond(0, 1.1, -1).kind, Kind::kFree) << "it stands, the body moves";
  Rebuild(Rules());
  const GateVerdict meets = AfterHalfASecond(0, 1.1, -2);
  EXPECT_LT(meets.command.x_m_s, 0.7);
  EXPECT_THAT(Describe(meets), HasSubstr("straight ahead, slows it down"));
}

TEST_F(GateBesideMovers, GoesOnBeforeWhatComesFromBehindOrGoesAway) {
  EXPECT_EQ(AfterHalfASecond(180, 0.5, -1).kind, Kind::kFree) << "a person walks behind it";
  Rebuild(Rules());
  EXPECT_EQ(AfterHalfASecond(0, 1.1, 0.5).kind, Kind::kFree);
}

TEST_F(GateBesideMovers, TakesWhatOnlyComesIntoViewForStill) {
  const auto pillar_at = [this](int degrees) {
    std::vector<std::pair<int, double>> hits;
    for (int i = -40; i <= 40; ++i) hits.emplace_back(i, 1.4);
    for (int i = -10; i <= 10; ++i) hits.emplace_back(degrees + i, 0.8);
    gate_->OnVelocity({}, now_);
    See(hits);
    now_ += Milliseconds(100);
  };
  for (int tenth = 0; tenth < 5; ++tenth) pillar_at(30 + 10 * tenth);  // it goes off to the left
  EXPECT_EQ(Check({0.9, 0, 0, 0}).kind, Kind::kFree);
}

TEST_F(Gate, ChecksTheArcOnWhichACommandMovesTheBody) {
  See({{40, 0.7}});
  EXPECT_EQ(Check({1.2, 0, 0, 0}).kind, Kind::kFree) << "straight ahead it passes";
  const GateVerdict left = Check({1.2, 0, 0, 2});
  EXPECT_EQ(left.kind, Kind::kSlowed);
  EXPECT_THAT(Describe(left), HasSubstr("an obstacle 0.70 m away, 40 degrees to the left, slows"));
  EXPECT_NEAR(left.command.yaw_rad_s / left.command.x_m_s, 2 / 1.2, 1e-9) << "on the same arc";
}

TEST_F(Gate, LetsABodyThatIsTooNearTurnAndGoAlongAndAway) {
  See({{0, 0.22}});
  EXPECT_EQ(Check(kAhead).command, Velocity{});
  EXPECT_EQ(Check({0, 0, 0, 1}).kind, Kind::kFree);
  EXPECT_EQ(Check({-0.5, 0, 0, 0}).kind, Kind::kFree);
  EXPECT_EQ(Check({0, 0.5, 0, 0}).kind, Kind::kFree);
  now_ += Milliseconds(400);
  See({{0, 0.22}});
  EXPECT_EQ(Check({0.5, 0, 0, 1}).command, (Velocity{0, 0, 0, 1})) << "it turns where it stands";
}

TEST_F(Gate, StopsABodyWithoutARecentScanAndNamesTheTopic) {
  EXPECT_EQ(Check(kAhead).kind, Kind::kBlind) << "there was none yet";
  See();
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
  now_ += Milliseconds(600);
  const GateVerdict verdict = Check(kAhead);
  EXPECT_EQ(verdict.command, Velocity{});
  EXPECT_EQ(Describe(verdict), "no recent scan on scan: it does not move blindly");
  now_ += Milliseconds(700);
  EXPECT_EQ(Check(kAhead).held, Milliseconds(700));
  See();
  EXPECT_EQ(Check(kAhead).held, Duration{});
}

TEST_F(Gate, NeedsARecentScanOfEachScanner) {
  GateRules rules = Rules();
  rules.scanners.push_back({.topic = "rear"});
  Rebuild(rules);
  See();
  EXPECT_EQ(Check(kAhead).scanner, "rear");
  ASSERT_TRUE(gate_->OnScan(1, ScanOf({{180, 0.3}}), Duration{}, now_));
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
  EXPECT_EQ(Check({-1, 0, 0, 0}).kind, Kind::kSlowed) << "what the rear one sees";
}

TEST_F(Gate, TakesTheMountingOfAScannerIntoAccount) {
  GateRules rules = Rules();
  rules.scanners[0].on_body = {{0.3, 0.1, 0.4}, M_PI / 2};  // it looks to the left
  rules.scanners[0].least_m = 0.2;
  Rebuild(rules);
  See({{-90, 0.5}, {0, 0.1}});  // ahead of the body, and a part of itself
  const GateVerdict verdict = Check({1.5, 0, 0, 0});
  ASSERT_TRUE(verdict.at);
  EXPECT_NEAR(verdict.at->x_m, 0.8, 1e-6);
  EXPECT_NEAR(verdict.at->y_m, 0.1, 1e-6);
  EXPECT_NEAR(verdict.at->z_m, 0.4, 1e-6);
  EXPECT_EQ(Check({0, 1, 0, 0}).kind, Kind::kFree);
}

TEST_F(Gate, DoesNotTakeAScanThatSaysNothingForAFreeWay) {
  Scan scan = ScanOf();
  scan.ranges_m.clear();
  EXPECT_FALSE(gate_->OnScan(0, scan, Duration{}, now_)) << "no rays";
  scan.ranges_m.assign(360, std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(gate_->OnScan(0, scan, Duration{}, now_));
  scan.ranges_m.assign(360, 0.0F);
  EXPECT_FALSE(gate_->OnScan(0, scan, Duration{}, now_));
  scan = ScanOf();
  scan.step_rad = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(gate_->OnScan(0, scan, Duration{}, now_));
  EXPECT_FALSE(gate_->OnScan(7, ScanOf(), Duration{}, now_)) << "no such scanner";
  EXPECT_EQ(Check(kAhead).kind, Kind::kBlind);
  scan.step_rad = 0.01;
  scan.ranges_m.assign(360, std::numeric_limits<float>::infinity());
  EXPECT_TRUE(gate_->OnScan(0, scan, Duration{}, now_)) << "rays that hit nothing are a sight";
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
}

TEST_F(Gate, DoesNotTakeStampsThatStandOrCameLateForASightOfNow) {
  const auto stamped = [&](std::int64_t stamp_ms) {
    return gate_->OnScan(0, ScanOf(), Milliseconds(stamp_ms), now_);
  };
  EXPECT_TRUE(stamped(5000));
  for (int i = 0; i < 6; ++i) {
    now_ += Milliseconds(100);
    EXPECT_FALSE(stamped(5000)) << "the same scan again";
  }
  EXPECT_EQ(Check(kAhead).kind, Kind::kBlind);
  EXPECT_TRUE(stamped(5050)) << "taken 0.55 s ago";
  EXPECT_EQ(Check(kAhead).kind, Kind::kBlind);
  EXPECT_TRUE(stamped(5600));
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
  now_ += Milliseconds(100);
  EXPECT_FALSE(stamped(5550)) << "overtaken";
  EXPECT_FALSE(stamped(90'000)) << "from the future";
  now_ += Milliseconds(100);
  EXPECT_TRUE(stamped(90'100)) << "its clock was set";
  now_ += Milliseconds(100);
  EXPECT_FALSE(stamped(5800));
  now_ += Milliseconds(100);
  EXPECT_TRUE(stamped(5900)) << "and set back";
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
}

// Each of them counted as a sight of now, however old it was.
TEST_F(Gate, DoesNotTakeScansFromTheFutureAndThePastInTurnForSightsOfNow) {
  const std::int64_t stamps_ms[] = {90'000, 5000, 170'000, 20'000, 3000, 90'050, 40'000, 1000};
  EXPECT_TRUE(gate_->OnScan(0, ScanOf(), Milliseconds(60'000), now_));
  for (const std::int64_t stamp_ms : stamps_ms) {
    now_ += Milliseconds(100);
    EXPECT_FALSE(gate_->OnScan(0, ScanOf(), Milliseconds(stamp_ms), now_)) << stamp_ms;
  }
  EXPECT_EQ(Describe(Check(kAhead)),
            "no recent scan on scan (its stamp does not follow that of the one before): it does "
            "not move blindly");
}

// One stamp 0.9 s ahead made every later scan 0.9 s old, for more than half an hour.
TEST_F(Gate, SeesOnAfterOneScanFromTheFuture) {
  const auto stamped = [&](std::int64_t stamp_ms) {
    now_ += Milliseconds(100);
    return gate_->OnScan(0, ScanOf(), Milliseconds(stamp_ms), now_);
  };
  EXPECT_TRUE(stamped(5000));
  EXPECT_TRUE(stamped(5100));
  EXPECT_FALSE(stamped(6100));
  EXPECT_TRUE(stamped(5300));
  EXPECT_TRUE(stamped(5400));
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
}

// All its rays lie on one line then: it hid what stands aside, and covered the way ahead.
TEST_F(Gate, DoesNotTakeAScanWhoseAngleStepIs0ForASight) {
  Scan scan = ScanOf();
  scan.ranges_m.assign(180, 7.9F);
  scan.step_rad = 0;
  EXPECT_FALSE(gate_->OnScan(0, scan, Duration{}, now_));
  EXPECT_EQ(Check(kAhead).command, Velocity{});
  EXPECT_EQ(Describe(Check(kAhead)),
            "no recent scan on scan (its angle step is 0): it does not move blindly");
  scan.ranges_m.resize(1);
  EXPECT_TRUE(gate_->OnScan(0, scan, Duration{}, now_)) << "of a single ray it says nothing";
}

TEST_F(Gate, DoesNotTakeAScanOfBeforeTheClockWasSetBackForASightOfNow) {
  See();
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
  now_ -= std::chrono::seconds(50);
  EXPECT_EQ(Check(kAhead).kind, Kind::kBlind);
  See();
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
}

TEST_F(Gate, MovesWhatItSawWithTheBody) {
  See({{0, 1.5}});
  for (int i = 0; i < 30; ++i) {
    gate_->OnVelocity({1.5, 0, 0, 0}, now_);
    Check({1.5, 0, 0, 0});
    now_ += Milliseconds(10);
  }
  const GateVerdict verdict = Check({1.5, 0, 0, 0});
  ASSERT_TRUE(verdict.at);
  EXPECT_NEAR(verdict.at->x_m, 1.5 - 0.45, 0.03);
}

TEST_F(Gate, DoesNotBelieveAMeasurementThatStands) {
  See({{0, 1.2}});
  for (int i = 0; i < 40; ++i) {
    gate_->OnVelocity({}, now_);
    Check({1.2, 0, 0, 0});
    now_ += Milliseconds(10);
  }
  EXPECT_LT(Check({1.2, 0, 0, 0}).command.x_m_s, 1.1) << "it has been commanded 0.48 m nearer";
}

// --- Where no scanner looks, it is unknown what is there ---

// Ahead of the scanner, as far as this to each side; nothing is near.
Scan ScanWithin(int degrees) {
  return {-degrees * M_PI / 180, M_PI / 180, 0.05, 8,
          std::vector<float>(static_cast<std::size_t>(2 * degrees + 1), 9.0F)};
}

TEST_F(Gate, DoesNotTakeWhatIsBehindItsScannerForAFreeWay) {
  ASSERT_TRUE(gate_->OnScan(0, ScanWithin(135), Duration{}, now_));
  const GateVerdict behind = Check({-1, 0, 0, 0.1});
  EXPECT_EQ(behind.kind, Kind::kSlowed);
  EXPECT_NEAR(behind.command.x_m_s, -0.3, 1e-9);
  EXPECT_NEAR(behind.command.yaw_rad_s, 0.03, 1e-9) << "on the same arc";
  EXPECT_EQ(Describe(Check({-1, 0, 0, 0})),
            "no scanner covers the way straight behind: it goes slowly");
  EXPECT_EQ(Check({-0.5, 0.5, 0, 0}).kind, Kind::kFree) << "135 degrees to the left";
  EXPECT_EQ(Check({-0.5, 0.4, 0, 0}).kind, Kind::kSlowed);
}

TEST_F(Gate, DoesNotTakeRaysWithoutAMeasurementForAFreeWay) {
  const float infinite = std::numeric_limits<float>::infinity();
  for (const float nothing : {std::nanf(""), 0.0F, -infinite, 0.01F}) {
    Scan scan = ScanOf();
    for (int degrees = -5; degrees <= 5; ++degrees) {
      scan.ranges_m[static_cast<std::size_t>((degrees + 360) % 360)] = nothing;
    }
    ASSERT_TRUE(gate_->OnScan(0, scan, Duration{}, now_));
    EXPECT_NEAR(Check({1.5, 0, 0, 0}).command.x_m_s, 0.3, 1e-9) << nothing;
    EXPECT_EQ(Check({0, 1.5, 0, 0}).kind, Kind::kFree) << nothing;
  }
  Scan scan = ScanOf();
  scan.ranges_m[0] = scan.ranges_m[1] = std::nanf("");
  scan.ranges_m[180] = infinite;
  ASSERT_TRUE(gate_->OnScan(0, scan, Duration{}, now_));
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree) << "two rays are no gap";
  EXPECT_EQ(Check({-1, 0, 0, 0}).kind, Kind::kFree) << "a ray that hit nothing is a sight";
}

TEST_F(Gate, LetsABodyBackUpSlowlyAndTurnWhereNoScannerLooks) {
  ASSERT_TRUE(gate_->OnScan(0, ScanWithin(135), Duration{}, now_));
  for (const Velocity& wanted : {Velocity{-0.15, 0, 0, 0}, {-0.3, 0, 0, 0.2}, {0, 0, 0, 1}}) {
    EXPECT_EQ(Check(wanted).command, wanted);
    EXPECT_EQ(Check(wanted).kind, Kind::kFree);
  }
}

TEST_F(Gate, GoesWhereAnotherScannerLooks) {
  GateRules rules = Rules();
  rules.scanners[0].on_body.at.x_m = 0.3;  // before the edge of the body
  rules.scanners.push_back({.topic = "rear", .on_body = {{-0.15, 0, 0}, M_PI}});
  Rebuild(rules);
  ASSERT_TRUE(gate_->OnScan(0, ScanWithin(90), Duration{}, now_));
  ASSERT_TRUE(gate_->OnScan(1, ScanWithin(60), Duration{}, now_));
  EXPECT_EQ(Check({1.5, 0, 0, 0}).kind, Kind::kFree);
  EXPECT_EQ(Check({-1.5, 0, 0, 0}).kind, Kind::kFree);
  EXPECT_TRUE(Check({0, 1, 0, 0}).unknown);
}

TEST_F(Gate, BrakesBeforeItsArcLeavesWhatItsScannerCovers) {
  ASSERT_TRUE(gate_->OnScan(0, ScanWithin(30), Duration{}, now_));
  const GateVerdict verdict = Check({1.5, 0, 0, 2.5});
  EXPECT_TRUE(verdict.unknown);
  EXPECT_GT(verdict.command.x_m_s, 0.8) << "it may still brake";
  EXPECT_LT(verdict.command.x_m_s, 1.4);
  EXPECT_EQ(Check({1.5, 0, 0, 0.5}).kind, Kind::kFree);
}

TEST_F(Gate, KeepsTheDirectionsOfAScanWhileTheBodyTurns) {
  ASSERT_TRUE(gate_->OnScan(0, ScanWithin(135), Duration{}, now_));
  const Velocity aside{-0.5, 0.7, 0, 0};  // 126 degrees to the left
  EXPECT_EQ(Check(aside).kind, Kind::kFree);
  for (int i = 0; i < 40; ++i) {
    gate_->OnVelocity({0, 0, 0, 1.5}, now_);
    Check({0, 0, 0, 1.5});
    now_ += Milliseconds(10);
  }
  EXPECT_TRUE(Check(aside).unknown) << "34 degrees farther to the left, in that scan";
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
}

TEST_F(Gate, GoesNowhereWithoutASightWhereItIsConfiguredSo) {
  GateRules rules = Rules();
  rules.unknown_m_s = 0;
  Rebuild(rules);
  ASSERT_TRUE(gate_->OnScan(0, ScanWithin(135), Duration{}, now_));
  const GateVerdict verdict = Check({-0.1, 0, 0, 0});
  EXPECT_EQ(verdict.kind, Kind::kStopped);
  EXPECT_EQ(Describe(verdict), "no scanner covers the way straight behind: it stops");
  EXPECT_EQ(Check(kAhead).kind, Kind::kFree);
}

TEST_F(Gate, StopsACommandThatIsNotFinite) {
  See();
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Check({infinite, 0, 0, 0}).command, Velocity{});
  EXPECT_EQ(Check({1, std::nan(""), 0, 0}).command, Velocity{});
  gate_->OnVelocity({1e308, infinite, std::nan(""), 0}, now_);
  EXPECT_EQ(Check(kAhead).command, kAhead);
}

TEST_F(Gate, KeepsATimeToTheCollisionIfItIsConfigured) {
  GateRules rules = Rules();
  rules.approach_s = 2;
  Rebuild(rules);
  See({{0, 1.25}});
  EXPECT_NEAR(Check({1, 0, 0, 0}).command.x_m_s, 0.5, 0.02);
}

TEST_F(Gate, SlowsDownAndStopsForPointsInItsZones) {
  GateRules rules = Rules();
  const std::vector<Point> ahead = {{0, 0.5, 0}, {0, -0.5, 0}, {2, -0.5, 0}, {2, 0.5, 0}};
  rules.zones = {{"wide", ahead, false, 0.3, 3}};
  Rebuild(rules);
  See({{20, 1.4}, {21, 1.4}});
  EXPECT_EQ(Check({0.4, 0, 0, 0}).kind, Kind::kFree) << "two points are noise";
  See({{17, 1.4}, {18, 1.4}, {19, 1.4}});
  EXPECT_NEAR(Check({0.4, 0, 0, 0.2}).command.x_m_s, 0.12, 1e-9);
  EXPECT_NEAR(Check({0.4, 0, 0, 0.2}).command.yaw_rad_s, 0.06, 1e-9);
  rules.zones[0].stops = true;
  Rebuild(rules);
  See({{17, 1.4}, {18, 1.4}, {19, 1.4}});
  EXPECT_EQ(Describe(Check({0.4, 0, 0, 0})),
            "an obstacle 1.40 m away, 19 degrees to the left, in the zone wide, stops it");
  EXPECT_EQ(Check({-0.4, 0, 0, 0}).kind, Kind::kFree) << "away from it";
}

TEST_F(Gate, LetsAFlyerHoldItsPlaceWithoutAScan) {
  GateRules rules = Rules();
  rules.blind_m_s = 0.5;
  Rebuild(rules);
  EXPECT_EQ(Check({0.3, 0.2, -0.1, 0.5}).command, (Velocity{0.3, 0.2, -0.1, 0.5}));
  const GateVerdict fast = Check({2, 0, 0.4, 0});
  EXPECT_EQ(fast.kind, Kind::kBlind);
  EXPECT_NEAR(fast.command.x_m_s, 0.5, 1e-9);
  EXPECT_EQ(fast.command.z_m_s, 0.4);
}

TEST_F(Gate, DoesNotCheckABodyWithoutAScanner) {
  Rebuild({});
  EXPECT_EQ(Check({3, 1, 0, 1}).command, (Velocity{3, 1, 0, 1}));
}

// --- A body never touches what its scan sees ---

void ExpectNoContact(std::uint64_t from, std::uint64_t to) {
  for (std::uint64_t seed = from; seed < to; ++seed) {
    EXPECT_GT(RunThroughGate(seed, true).least_room_m, 0) << "seed " << seed;
  }
}

TEST(AnyCommand, LeadsABodyIntoWallsWithoutTheGate) {
  int touched = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    touched += RunThroughGate(seed, false).least_room_m <= 0;
  EXPECT_GE(touched, 8);
}

TEST(AnyCommand, LeadsNoBodyIntoWhatItsScanSees) {
  ExpectNoContact(1, 14);
}

// Its momentum has led it there, while the new command was free.
TEST(AnyCommand, LeadsNoBodyIntoAWallWhileItChangesItsDirection) {
  for (const std::uint64_t seed : {1016, 1132, 1157}) ExpectNoContact(seed, seed + 1);
}

TEST(AnyCommandNightly, LeadsNoBodyIntoWhatItsScanSees) {
  ExpectNoContact(1000, 6000);
}

}  // namespace musher::navigation::testing::motion_gate_test
