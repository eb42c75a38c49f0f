// A visual servo: it brings a body before a target, and never moves it without a sighting that
// counts.

#include "musher/modules/skills/skills/visual_servo.hpp"

#include <gmock/gmock.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

namespace musher::skills::visual_servo_test {

using navigation::Point;
using navigation::Pose;
using navigation::Velocity;
using Kind = ServoStep::Kind;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr Duration kStep = Milliseconds(100);
constexpr const char* kNoPicture = "no detections";

// A body that executes what is commanded at once, in simulated time.
class Servo {
 public:
  explicit Servo(const ServoRules& rules = Rules()) : rules_(rules), servo_(rules) {}

  static ServoRules Rules() { return {.target = "dock"}; }

  Point InBody(const Point& place) const {
    const double x = place.x_m - body.at.x_m, y = place.y_m - body.at.y_m;
    const double c = std::cos(body.yaw_rad), s = std::sin(body.yaw_rad);
    return {c * x + s * y, c * y - s * x, place.z_m};
  }
  Look See() const { return {now, {InBody(target)}}; }
  const ServoStep& Step(const std::optional<Look>& look) {
    const bool stands = command == Velocity{};
    last = servo_.Update(look, kNoPicture, stands, now);
    command = last.command;
    const double seconds = ToSeconds(kStep);
    body.at.x_m += command.x_m_s * std::cos(body.yaw_rad) * seconds;
    body.at.y_m += command.x_m_s * std::sin(body.yaw_rad) * seconds;
    body.yaw_rad = navigation::Wrapped(body.yaw_rad + command.yaw_rad_s * seconds);
    now += kStep;
    return last;
  }
  const ServoStep& Step() { return Step(See()); }
  bool Reaches(double seconds) {
    for (int i = 0; i < static_cast<int>(10 * seconds) && last.kind != Kind::kReached; ++i) Step();
    return last.kind == Kind::kReached;
  }
  bool Moves() const { return !(command == Velocity{}); }

  Pose body;
  Point target{3, 1, 0};
  Time now{std::chrono::seconds(100)};
  Velocity command;
  ServoStep last;

 private:
  const ServoRules rules_;
  VisualServo servo_;
};

TEST(VisualServo, StandsBeforeTheTargetAtTheDistanceAndBearing) {
  ServoRules rules = Servo::Rules();
  rules.bearing_rad = 0.6;
  Servo servo(rules);
  ASSERT_TRUE(servo.Reaches(60)) << servo.last.why;
  const Point seen = servo.InBody(servo.target);
  EXPECT_NEAR(LevelDistanceTo(seen), 1, 0.05);
  EXPECT_NEAR(BearingOf(seen), 0.6, 0.1);
  EXPECT_FALSE(servo.Moves());
}

TEST(VisualServo, BacksAwayFromATargetThatIsTooNear) {
  Servo servo;
  servo.target = {0.5, 0, 0};
  ASSERT_TRUE(servo.Reaches(30)) << servo.last.why;
  EXPECT_NEAR(servo.body.at.x_m, -0.5, 0.06);
}

TEST(VisualServo, FollowsATargetThatMovesAndStandsOnceItStands) {
  Servo servo;
  for (int i = 0; i < 200; ++i) {
    servo.target.y_m += 0.01;
    servo.Step();
    EXPECT_NE(servo.last.kind, Kind::kReached);
  }
  ASSERT_TRUE(servo.Reaches(60)) << servo.last.why;
}

TEST(VisualServo, BeginsToMoveWithTheSecondSighting) {
  Servo servo;
  EXPECT_EQ(servo.Step().kind, Kind::kStands);
  EXPECT_EQ(servo.last.why, "dock was seen only once");
  EXPECT_EQ(servo.Step().kind, Kind::kMoves);
}

TEST(VisualServo, StandsWithin300MsOfTheLastSighting) {
  Servo servo;
  servo.Step();
  servo.Step();
  const Look last = servo.See();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(servo.Step(last).kind, Kind::kMoves) << i;
  EXPECT_EQ(servo.Step(last).kind, Kind::kStands);
  EXPECT_THAT(servo.last.why, StartsWith("dock is not seen for 0.4 s; it was 3."));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(servo.Step(Look{servo.now, {}}).kind, Kind::kStands);
  EXPECT_EQ(servo.Step().kind, Kind::kStands) << "seen again, once";
  EXPECT_EQ(servo.Step().kind, Kind::kMoves);
}

TEST(VisualServo, StandsAtOnceWithoutDetectorsAndSaysWhy) {
  Servo servo;
  servo.Step();
  servo.Step();
  EXPECT_EQ(servo.Step(std::nullopt).kind, Kind::kStands);
  EXPECT_EQ(servo.last.why, kNoPicture);
}

TEST(VisualServo, StandsBeforeTwoThingsOfOneName) {
  Servo servo;
  servo.Step();
  servo.Step();
  EXPECT_EQ(servo.Step(Look{servo.now, {{3, 0, 0}, {2, 1, 0}}}).kind, Kind::kStands);
  EXPECT_EQ(servo.last.why, "2 things are dock, 3.00 m and 2.24 m away");
  EXPECT_EQ(servo.Step(Look{servo.now, {}}).kind, Kind::kStands) << "none of them";
  servo.Step();
  EXPECT_EQ(servo.Step().kind, Kind::kMoves);
}

TEST(VisualServo, DoesNotFollowATargetThatJumpsAndGoesOnWhereItReturns) {
  Servo servo;
  servo.Step();
  servo.Step();
  const Point right = servo.target;
  servo.target = {3, -2.5, 0};
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(servo.Step().kind, Kind::kStands);
    EXPECT_THAT(servo.last.why, HasSubstr("dock has jumped by 3.64 m within 0.10 s"));
  }
  servo.target = right;
  servo.Step();
  EXPECT_EQ(servo.Step().kind, Kind::kMoves);
}

TEST(VisualServo, TakesNoPlaceThatIsNotANumber) {
  Servo servo;
  servo.Step();
  servo.Step();
  EXPECT_EQ(servo.Step(Look{servo.now, {{std::nan(""), 1, 0}}}).kind, Kind::kStands);
  EXPECT_EQ(servo.last.why, "the place of dock is none");
}

TEST(VisualServo, StandsWhileItsClockIsBeforeTheLastSighting) {
  Servo servo;
  servo.Step();
  servo.Step();
  servo.now -= std::chrono::seconds(50);
  EXPECT_EQ(servo.Step().kind, Kind::kStands);
  EXPECT_EQ(servo.last.why, "the sightings of dock are of another time");
}

// Whatever its detectors say, it moves only on a sighting that is young, single, a number, and at a
// place that can be that of the last two.
RC_GTEST_PROP(AVisualServo, NeverMovesWithoutAFreshSightingOfTheOnlyTarget, ()) {
  Servo servo;
  servo.target = {*rc::gen::inRange(-30, 30) / 10.0, *rc::gen::inRange(-30, 30) / 10.0, 0};
  std::optional<Look> shown;   // what the detectors show
  std::optional<Look> newest;  // that has the latest time
  const auto events = *rc::gen::container<std::vector<int>>(300, rc::gen::inRange(0, 24));
  for (const int event : events) {
    const bool has_picture = event != 0;
    switch (event) {
      case 0:
      case 1:  // the picture stands
        break;
      case 2:
        shown = Look{servo.now, {}};
        break;
      case 3:
        shown = Look{servo.now, {servo.InBody(servo.target), {1, 1, 0}}};
        break;
      case 4:
        shown = Look{servo.now, {{std::nan(""), 0, 0}}};
        break;
      case 5:  // from the future, or old
        shown = Look{servo.now + Milliseconds(*rc::gen::inRange(-2000, 2000)),
                     {servo.InBody(servo.target)}};
        break;
      case 6:  // it jumps
        servo.target.x_m += *rc::gen::inRange(-50, 50) / 10.0;
        shown = servo.See();
        break;
      case 7:
        servo.now += Milliseconds(*rc::gen::inRange(-3000, 3000));
        break;
      default:
        shown = servo.See();
    }
    if (shown && shown->at <= servo.now && (!newest || shown->at > newest->at)) newest = shown;
    const Time now = servo.now;
    servo.Step(has_picture ? shown : std::nullopt);
    if (!servo.Moves()) continue;
    RC_ASSERT(has_picture && newest.has_value());
    RC_ASSERT(servo.last.kind == Kind::kMoves);
    RC_ASSERT(newest->seen.size() <= 1U);
    if (!newest->seen.empty()) RC_ASSERT(navigation::IsFinite(newest->seen[0]));
    RC_ASSERT(servo.last.target.has_value());
    RC_ASSERT(now - newest->at <= kSightingCounts);
    RC_ASSERT(std::abs(servo.command.x_m_s) <= 0.2);
    RC_ASSERT(std::abs(servo.command.yaw_rad_s) <= 0.6);
  }
}

// From wherever a target is seen, with the noise of a detector that misses some pictures.
RC_GTEST_PROP(AVisualServo, ReachesEachTargetThatItSees, ()) {
  ServoRules rules = Servo::Rules();
  rules.distance_m = *rc::gen::inRange(4, 20) / 10.0;
  rules.bearing_rad = *rc::gen::inRange(-10, 11) / 10.0;
  Servo servo(rules);
  const double away_m = *rc::gen::inRange(3, 50) / 10.0;
  const double bearing_rad = *rc::gen::inRange(-15, 16) / 10.0;
  servo.target = {away_m * std::cos(bearing_rad), away_m * std::sin(bearing_rad), 0};
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, 0.01);
  for (int i = 0; i < 1000 && servo.last.kind != Kind::kReached; ++i) {
    Look look = servo.See();
    look.seen[0].x_m += noise(random);
    look.seen[0].y_m += noise(random);
    if (random() % 10 == 0) look.seen.clear();
    servo.Step(look);
  }
  RC_ASSERT(servo.last.kind == Kind::kReached);
  const Point seen = servo.InBody(servo.target);
  RC_ASSERT(std::abs(LevelDistanceTo(seen) - rules.distance_m) < 0.08);
  RC_ASSERT(std::abs(navigation::Wrapped(BearingOf(seen) - rules.bearing_rad)) < 0.15);
}

}  // namespace musher::skills::visual_servo_test
