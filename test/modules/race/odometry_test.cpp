// Walks by odometry: feet that slip, odometry that is wrong or missing, and what is kept of it.

#include <gmock/gmock.h>

#include <cmath>

#include "musher/test/modules/race/race_replay.hpp"

namespace musher::race::odometry_test {

using ::testing::HasSubstr;

constexpr int kFramesOfAStep = 4;  // 200 ms at 20 Hz
constexpr double kStepM = 0.08 * kWalkShare;
const Twist kForward{0.4, 0, 0};

// Its first walk is 23 steps ahead.
class Ahead : public Rig {
 public:
  Ahead() { script.odometry = Truth; }
  void WalkOnce() {
    Command("START:QRA_TO_A1");
    ASSERT_TRUE(RunUntil([this] { return field.ends == 1; }));
  }
  int frames() const { return field.frames_of_stream.front(); }
  std::size_t reserved() const { return race->memory().reserved(); }
};

TEST(WalkByOdometry, OfFeetThatSlipAsUsualIsThatByTime) {
  Ahead rig;
  rig.WalkOnce();
  EXPECT_NEAR(rig.frames(), 23 * kFramesOfAStep, 1);
  EXPECT_EQ(rig.reserved(), 0U);
}

TEST(WalkByOdometry, OfFeetThatSlipLeadsAsFar) {
  for (const double slip : {0.1, 0.15, -0.1}) {
    Ahead rig;
    rig.script.slip = slip;
    rig.WalkOnce();
    // While it takes up its speed the time counts.
    EXPECT_NEAR(rig.pose.at.x_m, 23 * kStepM, 0.02 + 0.32 * std::abs(slip)) << slip;
    EXPECT_EQ(rig.reserved(), 0U) << slip;
  }
}

TEST(WalkByOdometry, OfATurnLeadsAsFar) {
  Ahead rig;
  rig.script.slip = 0.15;
  rig.Command("START:B1_TO_L1");  // turns to the right by 19 steps
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  EXPECT_NEAR(-navigation::Wrapped(rig.pose.yaw_rad), 19 * 0.18 * kTurnShare, 0.12);
}

TEST(WalkByOdometry, AsideIsMeasuredAside) {
  Ahead rig;
  rig.script.slip = 0.15;
  rig.pose.yaw_rad = 2;
  rig.Command("START:QRB_TO_B1");  // 23 steps to the left
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  EXPECT_NEAR(std::hypot(rig.pose.at.x_m, rig.pose.at.y_m), 23 * 0.06 * kWalkShare, 0.06);
}

// Its corrections are shorter than the time that the body needs to take up its speed: they went by
// their time, and slipped as ever.
TEST(WalkByOdometry, OfFewStepsLeadsAsFarOnceTheSlipIsKnown) {
  Ahead rig;
  rig.script.slip = 0.15;
  rig.WalkOnce();
  rig.script.lines = [&rig](const std::string& detector) {
    const bool right = detector == "right_lane" && !rig.field.Logged("correction 1");
    return Lines{2, right ? LineWord::kRight : LineWord::kCenter, LineWord::kCenter};
  };
  const double before_m = rig.pose.at.x_m;
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 2; }));
  ASSERT_TRUE(rig.field.Logged("correction 1: forward 2"));
  EXPECT_NEAR(rig.pose.at.x_m - before_m, 2 * kStepM, 0.017) << "a tick";
  EXPECT_EQ(rig.field.frames_of_stream.back(), 10) << "8 without slip";
}

TEST(WalkByOdometry, ThatIsLostGoesOnWithTheSlipThatItHasShown) {
  Ahead rig;
  rig.script.slip = 0.15;
  rig.WalkOnce();
  rig.script.odometry = nullptr;
  rig.Command("START:L1_TO_QRB");
  rig.script.odometry = nullptr;
  const double before_m = rig.pose.at.x_m;
  const double way_m = 85 * kStepM;
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 2; }));
  EXPECT_NEAR(rig.pose.at.x_m - before_m, way_m, 0.05);
}

TEST(WalkByOdometry, ShowsTheSlipAtTheEndOfARun) {
  Ahead rig;
  rig.script.slip = 0.1;
  rig.Command("START:A1_TO_START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_TRUE(
      rig.field.Logged("END: of the way of the steps odometry has shown 0.90 ahead, 0.90 "
                       "aside"));
}

// By pictures that stood still it was turned by 0.2 rad/s for 17 s.
// On the way into bay A1 the check after the walk aside sees the line of another lane, `times`
// times.
struct AnotherLine : Ahead {
  explicit AnotherLine(int times) {
    script.lines = [this, left = times](const std::string& detector) mutable {
      if (detector != "left_lane") return Lines{2, LineWord::kCenter, LineWord::kCenter};
      const auto walks = static_cast<int>(field.ends);
      if (walks != seen_after && seen_after >= 0) --left;
      seen_after = walks;
      return Lines{2, left > 0 ? LineWord::kLeft : LineWord::kCenter, LineWord::kCenter};
    };
  }
  int seen_after = -1;
};

TEST(CorrectionAgainstOdometry, IsTakenBackAndNamed) {
  AnotherLine rig(100);
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.Logged("check left_ycy: left, correction 1"); }));
  const double before_m = rig.pose.at.x_m;
  ASSERT_TRUE(rig.RunUntil([&] { return rig.reserved() > 0; })) << "it believes each correction";
  EXPECT_NEAR(rig.pose.at.x_m, before_m, 0.03) << "it is not where the other line has led it";
  EXPECT_TRUE(rig.field.Logged("check left_ycy: left, correction 2"));
  EXPECT_FALSE(rig.field.Logged("check left_ycy: left, correction 3"));
  EXPECT_TRUE(rig.field.Logged("are more than odometry can be off after"));
  EXPECT_TRUE(rig.field.Logged("it may be another line"));
}

TEST(CorrectionAgainstOdometry, IsBelievedAsFarAsOdometryMayBeOff) {
  AnotherLine rig(2);
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_TRUE(rig.field.Logged("check left_ycy: left, correction 2"));
  EXPECT_EQ(rig.reserved(), 0U);
}

// Nothing says how far it may be off: the place is only known by the check.
TEST(CorrectionAgainstOdometry, IsBelievedWithoutOdometry) {
  AnotherLine rig(100);
  rig.script.odometry = nullptr;
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.Logged("left after 3 corrections"); }));
}

TEST(WalkByOdometry, OfAStraightWalkThatTurnsIsAFault) {
  Ahead rig;
  rig.script.odometry = [](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.pose.yaw_rad = 0.3 * truth.pose.at.x_m;
    return truth;
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
  EXPECT_THAT(rig.race->InfoText(),
              HasSubstr("Reason:QRA_TO_A1: forward has turned by 17 degrees by odometry"));
  EXPECT_NEAR(rig.pose.at.x_m, 1.05, 0.1);
}

TEST(WalkByOdometry, OfABodyThatIsBlockedIsAFault) {
  Ahead rig;
  int samples = 0;
  rig.script.odometry = [&samples](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.pose = {};
    truth.pose.at.x_m = ++samples % 2 * 0.001;  // its feet move
    return truth;
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("something is in the way"));
  EXPECT_LE(rig.frames(), 50) << "it pushes on";
}

// The place in the bay is not sure then.
TEST(WalkByOdometry, ThatIsNotConfirmedIsSpokenInTheBay) {
  Ahead rig;
  rig.script.slip = 0.35;
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return !rig.field.spoken.empty(); }));
  EXPECT_EQ(rig.field.spoken.front(), "不确定是否已到达库位");
}

// Coarse odometry, or one that takes a small speed for none: it pushed on, by its time.
TEST(WalkByOdometry, WhosePoseStandsStillIsAFault) {
  Ahead rig;
  rig.script.odometry = [](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.pose = {};
    return truth;
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
  EXPECT_THAT(rig.race->InfoText(),
              HasSubstr("forward: the pose of the odometry stands still: something is in the way"));
  EXPECT_LE(rig.frames(), 50) << "it pushes on";
}

TEST(WalkByOdometry, IsNotComparedWithItsTimeWhereTheCourseDoesNotWantIt) {
  Course course = TheCourse();
  course.odometry.blocked_share = 0;
  Rig rig(course);
  rig.script.odometry = [](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.pose = {};
    return truth;
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_EQ(rig.field.frames_of_stream.front(), 23 * kFramesOfAStep * 1.25);
  EXPECT_TRUE(rig.field.Logged("by odometry: the feet slip, or something is in the way"));
}

// Each pose comes in eight samples.
TEST(WalkByOdometry, ThatIsCoarseLeadsAsFar) {
  Ahead rig;
  rig.script.slip = 0.15;
  OdometrySample held;
  int samples = 0;
  rig.script.odometry = [&](OdometrySample truth) -> std::optional<OdometrySample> {
    if (samples++ % 8 == 0) held = truth;
    truth.pose = held.pose;
    return truth;
  };
  rig.WalkOnce();
  EXPECT_NEAR(rig.pose.at.x_m, 23 * kStepM, 0.02 + 0.32 * 0.15 + 0.16);
  EXPECT_EQ(rig.reserved(), 0U);
}

// The place in the bay is not sure then.
TEST(WalkByOdometry, ThatIsMissingIsSpokenInTheBay) {
  Ahead rig;
  rig.script.odometry = nullptr;
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return !rig.field.spoken.empty(); }));
  EXPECT_EQ(rig.field.spoken.front(), "不确定是否已到达库位");
}

TEST(WalkByOdometry, ThatShowsTwiceTheDistanceIsBelievedForAFifthOfTheTime) {
  Ahead rig;
  rig.script.odometry = [](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.pose.at.x_m *= 2;
    return truth;
  };
  rig.WalkOnce();
  EXPECT_NEAR(rig.frames(), 23 * kFramesOfAStep * 0.8, 1);
  EXPECT_TRUE(rig.field.Logged("by odometry: it shows more than the feet can walk"));
  EXPECT_EQ(rig.reserved(), 1U);
}

TEST(WalkByOdometry, GoesByTimeWithoutItAndSaysSoOnce) {
  Ahead rig;
  rig.script.odometry = nullptr;
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_EQ(rig.frames(), 23 * kFramesOfAStep);
  ASSERT_EQ(rig.reserved(), 1U);
  EXPECT_EQ(rig.race->memory().reservations().front().reason,
            "walks without odometry, by their time: no odometry on odom_out for 300 ms");
}

TEST(WalkByOdometry, DoesNotBelieveAJump) {
  Ahead rig;
  rig.script.odometry = [&rig](OdometrySample truth) -> std::optional<OdometrySample> {
    if (!rig.field.frames_of_stream.empty() && rig.frames() > 40) truth.pose.at.x_m += 0.45;
    return truth;
  };
  rig.WalkOnce();
  EXPECT_NEAR(rig.frames(), 23 * kFramesOfAStep, 1);
  EXPECT_TRUE(rig.field.Logged("by their time: the odometry jumps by 0.4"));
}

TEST(WalkByOdometry, DoesNotBelieveATimeThatGoesBack) {
  Ahead rig;
  rig.script.odometry = [&rig](OdometrySample truth) -> std::optional<OdometrySample> {
    if (!rig.field.frames_of_stream.empty() && rig.frames() > 40) {
      truth.stamp -= std::chrono::milliseconds(500);
      truth.pose.at.x_m = 0;
    }
    return truth;
  };
  rig.WalkOnce();
  EXPECT_NEAR(rig.frames(), 23 * kFramesOfAStep, 1);
  EXPECT_TRUE(rig.field.Logged("the stamps of the odometry go back by 0.4"));
}

TEST(WalkByOdometry, DoesNotBelieveStampsThatStandStill) {
  Ahead rig;
  rig.script.odometry = [](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.stamp = Time(Milliseconds(5));
    truth.pose = {};
    return truth;
  };
  rig.WalkOnce();
  EXPECT_NEAR(rig.frames(), 23 * kFramesOfAStep, 1);
  EXPECT_TRUE(rig.field.Logged("by their time: the stamps of the odometry stand still"));
}

TEST(WalkByOdometry, DoesNotBelieveWhatIsOld) {
  Ahead rig;
  rig.script.odometry = [](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.age = Milliseconds(3200);
    truth.pose = {};
    return truth;
  };
  rig.WalkOnce();
  EXPECT_NEAR(rig.frames(), 23 * kFramesOfAStep, 1);
  EXPECT_TRUE(rig.field.Logged("by their time: the odometry is 3.2 s old"));
}

TEST(WalkByOdometry, RefusesAPoseThatIsNone) {
  Ahead rig;
  rig.script.odometry = [](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.pose.at.x_m = kUnknown;
    return truth;
  };
  rig.WalkOnce();
  EXPECT_NEAR(rig.frames(), 23 * kFramesOfAStep, 1);
  EXPECT_TRUE(rig.field.Logged("a sample of the odometry on odom_out is refused"));
}

// What the body walks in a gap is counted by time, and not once more by the sample after it.
TEST(WalkByOdometry, CountsAGapOnce) {
  for (const int gap_frames : {3, 10, 20}) {
    Ahead rig;
    rig.script.odometry = [&rig, gap_frames](OdometrySample truth) {
      const int frame = rig.field.frames_of_stream.empty() ? 0 : rig.frames();
      const bool gap = frame > 40 && frame <= 40 + gap_frames;
      return gap ? std::nullopt : std::optional(truth);
    };
    rig.WalkOnce();
    EXPECT_NEAR(rig.frames(), 23 * kFramesOfAStep, 2) << gap_frames;
  }
}

TEST(WalkByOdometry, OfACourseWithoutATopicIgnoresIt) {
  Course course = TheCourse();
  course.odometry.topic.clear();
  Rig rig(course);
  rig.script.odometry = [](OdometrySample truth) -> std::optional<OdometrySample> {
    truth.pose = {};
    return truth;
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_EQ(rig.field.frames_of_stream.front(), 23 * kFramesOfAStep);
  EXPECT_EQ(rig.race->memory().reserved(), 0U);
  EXPECT_EQ(rig.recording.find("odometry"), std::string::npos);
}

// After 46 steps of the course, for which feet that slip by a tenth need 51.
TEST(WalkByOdometry, UntilASightStoresTheStepsThatTheWayIsLong) {
  Ahead rig;
  rig.script.slip = 0.1;
  rig.script.sight = [&](const std::string& detector) -> Sighting {
    const bool top = rig.state() == "S2_TO_L1" && rig.pose.at.x_m > 46 * kStepM;
    return {true, 1, detector == "barrier" && top ? "top" : "seen", ""};
  };
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("IN_L1"));
  ASSERT_EQ(rig.course_.counters[0], "x1");
  EXPECT_NEAR(rig.race->memory().Count(0), 46, 1);
  EXPECT_TRUE(rig.field.Logged(" by time)"));
  ASSERT_TRUE(rig.RunTo("IN_QRB"));
  EXPECT_NEAR(rig.pose.at.x_m, 100 * kStepM, 0.2) << "by time it lacks 0.78 m";
}

TEST(WalkByOdometry, UntilASightThatIsNotFoundIsNoLongerThanItsMetres) {
  Ahead rig;
  rig.script.slip = -0.1;
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("IN_L1"));
  EXPECT_NEAR(rig.pose.at.x_m, 85 * kStepM, 0.1);
  EXPECT_TRUE(rig.field.Logged("no barrier within 85 steps (7"));
  Ahead slow;
  slow.script.slip = 0.1;
  slow.Command("START:S2_TO_L1");
  ASSERT_TRUE(slow.RunTo("IN_L1"));
  EXPECT_EQ(slow.FramesOf(kForward), 85 * kFramesOfAStep);
  ASSERT_TRUE(slow.RunTo("IN_QRB"));
  EXPECT_NEAR(slow.pose.at.x_m, 100 * kStepM, 0.15) << "the rest of the way is walked after it";
}

TEST(WalkByOdometry, IsReplayedFromItsRecording) {
  Ahead rig;
  rig.script.slip = 0.12;
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("IN_QRB"));
  EXPECT_THAT(rig.recording, HasSubstr("input odometry "));
  ExpectReplays(rig);
}

// A pause between two halves of a walk: neither is counted twice.
TEST(WalkByOdometry, ContinuesAfterAPauseWithTheRest) {
  Ahead rig;
  rig.script.slip = 0.1;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(std::chrono::seconds(20));
  rig.race->Resume(rig.now);
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 2; }));
  EXPECT_NEAR(rig.pose.at.x_m, 23 * kStepM, 0.12);
}

}  // namespace musher::race::odometry_test
