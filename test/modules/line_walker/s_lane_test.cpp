// The walker in a closed loop: a lane like an S, with a lag, slip, noise and late pictures.

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <string>

#include "musher/messages/stamp.hpp"
#include "musher/test/modules/line_walker/s_lane.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::line_walker::s_lane_test {

const unsigned kSeeds = musher::testing::Nightly() ? 20 : 4;

int EndFrames(const SLaneRun& run) {
  int ends = 0;
  for (const auto& frame : run.frames) ends += frame.end ? 1 : 0;
  return ends;
}

// Ends before a line across the lane.
WalkRules BeforeTheLine() {
  WalkRules rules;
  rules.end_gap_m = 0.45;
  return rules;
}

struct Start {
  double left_m;
  double heading_rad;
};
constexpr std::array<Start, 4> kStarts{
    {{0.1, 8 * kDegree}, {-0.1, -8 * kDegree}, {0.1, -8 * kDegree}, {-0.1, 8 * kDegree}}};

// The worst of several runs.
struct Worst {
  double rms_m = 0;
  double max_m = 0;
  double later_m = 0;
  double least_gap_m = 9;
  double most_gap_m = -9;

  void Add(SLaneRun& run) {
    ASSERT_EQ(run.walker.end(), End::kCourseEnd) << run.walker.reason();
    EXPECT_EQ(EndFrames(run), 1);
    EXPECT_TRUE(run.frames.back().end);
    run.RunFor(Milliseconds(1000));  // it stands
    const double gap_m = run.lane.length_m() - run.place().along_m;
    rms_m = std::max(rms_m, run.rms_m());
    max_m = std::max(max_m, run.max_m());
    later_m = std::max(later_m, run.max_later_m());
    least_gap_m = std::min(least_gap_m, gap_m);
    most_gap_m = std::max(most_gap_m, gap_m);
  }
  // For the figures in modules/line_walker/README.md.
  void Print(const std::string& what) const {
    std::cout << what << ": rms " << rms_m << " m, max " << max_m << " m, after 0.8 m " << later_m
              << " m; gap to the end " << least_gap_m << " to " << most_gap_m << " m\n";
  }
};

TEST(SLaneWalk, StaysInTheMiddleAndEndsBeforeTheEndLine) {
  Worst worst;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    SLaneRun run(seed, 0, 0, BeforeTheLine());
    run.RunToEnd();
    worst.Add(run);
  }
  worst.Print("from the middle");
  EXPECT_LT(worst.rms_m, 0.02);
  EXPECT_LT(worst.max_m, 0.05);
  EXPECT_GT(worst.least_gap_m, 0.3);
  EXPECT_LT(worst.most_gap_m, 0.56);
}

TEST(SLaneWalk, ReturnsToTheMiddleFromTenCentimetresAndEightDegreesBeside) {
  Worst worst;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const Start& start = kStarts[seed % kStarts.size()];
    SLaneRun run(seed, start.left_m, start.heading_rad, BeforeTheLine());
    run.RunToEnd();
    worst.Add(run);
  }
  worst.Print("from beside");
  EXPECT_LT(worst.rms_m, 0.06);
  EXPECT_LT(worst.max_m, 0.13);
  EXPECT_LT(worst.later_m, 0.05);
  EXPECT_GT(worst.least_gap_m, 0.3);
  EXPECT_LT(worst.most_gap_m, 0.56);
}

// Beyond the lane's end no line is seen: a walk that was stopped there, by a light or a fault that
// has healed, ended as lost.
TEST(SLaneWalk, ThatWasStoppedBehindTheEndOfTheLinesIsWalkedOnToItsEnd) {
  SLaneRun run(1, 0, 0);
  while (run.walker.active() && run.walker.to_end_m().value_or(1) > -0.2)
    run.RunFor(Milliseconds(100));
  ASSERT_TRUE(run.walker.active());
  run.walker.Stop(run.now());
  run.RunFor(Milliseconds(5000));
  ASSERT_TRUE(run.walker.Start(run.now()));
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kCourseEnd) << run.walker.reason();
  run.RunFor(Milliseconds(1000));
  const double gap_m = run.lane.length_m() - run.place().along_m;
  EXPECT_NEAR(gap_m, WalkRules{}.end_gap_m, 0.15);
}

// What is not usual: a line is missing, pictures are missing, STOP.
TEST(SLaneWalk, ContinuesByOneLineWhileTheOtherIsMissingForASecond) {
  for (const View missing : {View::kLeft, View::kRight}) {
    Worst worst;
    for (unsigned seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(seed);
      SLaneRun run(seed, 0, 0, BeforeTheLine());
      run.RunFor(Milliseconds(3000));
      run.spoil = [&](View view, msg::YellowLines& lines) {
        if (view == missing) lines = {};
      };
      run.RunFor(Milliseconds(1000));
      run.spoil = {};
      run.RunToEnd();
      worst.Add(run);
    }
    worst.Print(missing == View::kLeft ? "without the left for 1 s" : "without the right for 1 s");
    EXPECT_LT(worst.max_m, 0.06);
  }
}

TEST(SLaneWalk, WalksByOneLineAlone) {
  for (const View missing : {View::kLeft, View::kRight}) {
    Worst worst;
    for (unsigned seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(seed);
      SLaneRun run(seed, 0, 0, BeforeTheLine());
      run.spoil = [&](View view, msg::YellowLines& lines) {
        if (view == missing) lines = {};
      };
      run.RunToEnd();
      worst.Add(run);
    }
    worst.Print(missing == View::kLeft ? "by the right line alone" : "by the left line alone");
    EXPECT_LT(worst.max_m, 0.1);
  }
}

TEST(SLaneWalk, ContinuesByOdometryForASecondWithoutLinesAndSlowly) {
  SLaneRun run(3, 0, 0, BeforeTheLine());
  run.RunFor(Milliseconds(3000));
  run.spoil = [](View, msg::YellowLines& lines) { lines.edge_x.clear(); };
  run.RunFor(Milliseconds(1200));
  EXPECT_EQ(run.walker.state(), LineWalker::State::kAdjusting);
  EXPECT_NEAR(run.frames.back().velocity.forward_m_s, 0.15, 0.01);
  run.spoil = {};
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kCourseEnd);
  EXPECT_LT(run.max_m(), 0.08);
}

TEST(SLaneWalk, EndsLostWithoutBothLines) {
  SLaneRun run(4, 0, 0, BeforeTheLine());
  run.RunFor(Milliseconds(3000));
  const Time lost = run.now();
  run.spoil = [](View, msg::YellowLines& lines) { lines.edge_x.clear(); };
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kLost);
  EXPECT_NEAR(ToSeconds(run.now() - lost), 2.7, 0.3);
  EXPECT_EQ(EndFrames(run), 1);
  EXPECT_LT(run.max_m(), 0.3) << "still in the lane";
}

TEST(SLaneWalk, IsNotDisturbedByNaNAndStrayPoints) {
  Worst worst;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    SLaneRun run(seed, 0, 0, BeforeTheLine());
    run.spoil = [](View view, msg::YellowLines& lines) {
      const float nan = std::numeric_limits<float>::quiet_NaN();
      for (std::size_t i = 0; i < lines.edge_x.size(); i += 4) lines.edge_x[i] = nan;
      for (std::size_t i = 1; view != View::kFront && i < lines.edge_y.size(); i += 5) {
        lines.edge_y[i] = 0.95F;
      }
      lines.edge_x.push_back(std::numeric_limits<float>::infinity());
    };
    run.RunToEnd();
    worst.Add(run);
  }
  worst.Print("with NaN and stray points");
  EXPECT_LT(worst.max_m, 0.06);
}

TEST(SLaneWalk, StopsInTheMiddleByOneEndFrame) {
  SLaneRun run(5, 0, 0, BeforeTheLine());
  run.RunFor(Milliseconds(4000));
  run.walker.Stop(run.now());
  const SLane::Place at = run.place();
  run.RunFor(Milliseconds(2000));
  EXPECT_EQ(run.walker.end(), End::kStopped);
  EXPECT_EQ(EndFrames(run), 1);
  EXPECT_TRUE(run.frames.back().end);
  EXPECT_LT(run.place().along_m - at.along_m, 0.12);
}

TEST(SLaneWalk, EndsBeyondALaneThatIsOpenAtItsEnd) {
  Worst worst;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    SLaneRun run(seed, 0.05, 0, WalkRules());
    run.has_end_line = false;
    run.has_lines_beside = true;
    run.RunToEnd();
    worst.Add(run);
    EXPECT_NEAR(run.body().yaw_rad, run.lane.At(9).yaw_rad, 0.12);
  }
  worst.Print("an open lane");
  EXPECT_LT(worst.max_m, 0.1);
  EXPECT_GT(worst.least_gap_m, -0.65);
  EXPECT_LT(worst.most_gap_m, -0.33);
}

// Of config/scenes/course.toml, in both directions; the body starts before the lines.
TEST(SLaneWalk, WalksThroughTheLaneOfTheCourseBothWays) {
  for (const bool out : {true, false}) {
    SLane::Shape shape{1.2, 50 * kDegree, 1.6, 0.28, 0.1};
    if (!out) shape = {1.3, 50 * kDegree, 1.6, 1.16, 1.0};
    const SLane lane(shape);
    WalkRules rules;
    rules.approach_m = 1.2;
    Worst worst;
    for (unsigned seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(seed);
      SLaneRun run(seed, 0.03, -2 * kDegree, rules, lane);
      run.has_end_line = false;
      run.has_lines_beside = true;
      run.RunToEnd(std::chrono::seconds(60));
      worst.Add(run);
    }
    worst.Print(out ? "the course, out" : "the course, back");
    EXPECT_LT(worst.max_m, 0.12);
    EXPECT_GT(worst.least_gap_m, -0.65);
    EXPECT_LT(worst.most_gap_m, -0.33);
  }
}

TEST(SLaneWalk, EndsLostWhereAnApproachFindsNoLine) {
  WalkRules rules;
  rules.approach_m = 0.5;
  SLane::Shape shape;
  shape.lines_from_m = 4;
  SLaneRun run(1, 0, 0, rules, SLane(shape));
  run.has_end_line = false;
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kLost);
  EXPECT_NEAR(run.place().along_m, 0.5, 0.1);
  EXPECT_EQ(EndFrames(run), 1);
}

// The velocity ahead of the fastest frame.
double Fastest(const SLaneRun& run) {
  double fastest_m_s = 0;
  for (const auto& frame : run.frames) {
    fastest_m_s = std::max(fastest_m_s, frame.velocity.forward_m_s);
  }
  return fastest_m_s;
}

void SeeNoLine(View, msg::YellowLines& lines) {
  lines.edge_x.clear();
}

// Before lines that are too far away to find them.
SLane FarLane() {
  SLane::Shape shape;
  shape.lines_from_m = 4;
  return SLane(shape);
}

void RunBeyondTheLines(SLaneRun& run) {
  while (run.walker.active() && run.walker.to_end_m().value_or(1) > -0.2) {
    run.RunFor(Milliseconds(100));
  }
  ASSERT_TRUE(run.walker.active());
}

// The next START came 2.3 s later, and it walked 1.2 m ahead, along whatever heading it had.
TEST(SLaneWalk, ThatWasLostInTheLaneDoesNotApproachAtTheNextStart) {
  WalkRules rules;
  rules.approach_m = 1.2;
  SLaneRun run(4, 0, 0, rules);
  run.RunFor(Milliseconds(3000));
  run.spoil = SeeNoLine;
  run.RunToEnd();
  ASSERT_EQ(run.walker.end(), End::kLost);
  for (int start = 2; start <= 3; ++start) {
    run.RunFor(Milliseconds(2300));
    run.frames.clear();
    ASSERT_TRUE(run.walker.Start(run.now()));
    run.RunToEnd();
    EXPECT_EQ(Fastest(run), 0) << start;
    EXPECT_EQ(run.walker.end(), End::kLost);
  }
}

// Each START walked on by the whole approach.
TEST(SLaneWalk, ApproachesOnceAndNotOnceMoreAtEachStart) {
  WalkRules rules;
  rules.approach_m = 0.5;
  SLaneRun run(1, 0, 0, rules, FarLane());
  run.has_end_line = false;
  run.RunFor(Milliseconds(2500));
  EXPECT_GT(Fastest(run), 0);
  run.walker.Stop(run.now());
  for (int start = 2; start <= 3; ++start) {
    run.RunFor(Milliseconds(2300));
    ASSERT_TRUE(run.walker.Start(run.now()));
    run.RunToEnd();
    EXPECT_EQ(run.walker.end(), End::kLost);
    EXPECT_NEAR(run.place().along_m, 0.5, 0.1) << start;
  }
}

// After a second without lines it approached, slowly and by its heading.
TEST(SLaneWalk, ThatContinuesToAKnownEndDoesNotApproach) {
  WalkRules rules;
  rules.approach_m = 1.2;
  rules.end_gap_m = -2;
  SLaneRun run(1, 0, 0, rules);
  RunBeyondTheLines(run);
  run.walker.Stop(run.now());
  run.RunFor(Milliseconds(1000));
  ASSERT_TRUE(run.walker.Start(run.now()));
  run.RunFor(Milliseconds(2000));
  run.frames.clear();
  run.RunFor(Milliseconds(1000));
  EXPECT_GT(Fastest(run), 0.2);
}

// A robot that was carried back to the begin walked to the end that it had seen an hour before.
TEST(SLaneWalk, ThatWasStoppedLongAgoDoesNotContinue) {
  WalkRules rules;
  rules.time_limit = std::chrono::seconds(20);
  SLaneRun run(1, 0, 0, rules);
  RunBeyondTheLines(run);
  run.walker.Stop(run.now());
  run.RunFor(std::chrono::seconds(21));
  run.spoil = SeeNoLine;
  run.frames.clear();
  ASSERT_TRUE(run.walker.Start(run.now()));
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kLost);
  EXPECT_EQ(Fastest(run), 0);
}

// The same after the computer was suspended, which no clock and no odometry show.
TEST(SLaneWalk, WhoseLaneIsForgottenDoesNotContinue) {
  SLaneRun run(1, 0, 0);
  RunBeyondTheLines(run);
  run.walker.Stop(run.now());
  run.walker.ForgetLane();
  run.RunFor(Milliseconds(1000));
  run.spoil = SeeNoLine;
  run.frames.clear();
  ASSERT_TRUE(run.walker.Start(run.now()));
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kLost);
  EXPECT_EQ(Fastest(run), 0);
}

// A pause or a light may have come between the end and who waits for it; then START follows.
TEST(SLaneWalk, ThatIsStartedAgainAtItsEndEndsThereAtOnce) {
  WalkRules rules;
  rules.approach_m = 1.2;
  SLaneRun run(1, 0, 0, rules);
  run.RunToEnd();
  ASSERT_EQ(run.walker.end(), End::kCourseEnd);
  run.RunFor(Milliseconds(6000));
  run.frames.clear();
  ASSERT_TRUE(run.walker.Start(run.now()));
  run.RunFor(Milliseconds(100));
  EXPECT_EQ(run.walker.end(), End::kCourseEnd) << run.walker.reason();
  EXPECT_TRUE(run.frames.empty());
}

// One picture without a doubt was enough for all those with one that followed.
TEST(SLaneWalk, DoesNotApproachByPicturesInDoubtThatFollowAClearOne) {
  WalkRules rules;
  rules.approach_m = 1.2;
  SLaneRun run(1, 0, 0, rules);
  int pictures = 0;
  run.spoil = [&pictures](View view, msg::YellowLines& lines) {
    SeeNoLine(view, lines);
    if (++pictures > 3) lines.doubt = "the floor has their colour";
  };
  run.RunToEnd();
  EXPECT_EQ(Fastest(run), 0);
  EXPECT_EQ(run.walker.end(), End::kLost);
}

TEST(SLaneWalk, StandsInItsApproachWhileThePicturesAreInDoubt) {
  WalkRules rules;
  rules.approach_m = 1.2;
  SLaneRun run(1, 0, 0, rules, FarLane());
  run.RunFor(Milliseconds(2500));
  EXPECT_GT(Fastest(run), 0);
  run.spoil = [](View, msg::YellowLines& lines) { lines.doubt = "the floor has their colour"; };
  run.RunFor(Milliseconds(1300));
  EXPECT_TRUE(run.walker.active());
  EXPECT_EQ(run.frames.back().velocity, Velocity());
  run.spoil = {};
  run.RunFor(Milliseconds(1500));
  EXPECT_GT(run.frames.back().velocity.forward_m_s, 0.1);
}

// It turned by the jump, and walked on along that.
TEST(SLaneWalk, EndsLostByAJumpOfTheOdometryInItsApproach) {
  WalkRules rules;
  rules.approach_m = 1.2;
  SLaneRun run(1, 0, 0, rules, FarLane());
  run.RunFor(Milliseconds(2500));
  EXPECT_GT(Fastest(run), 0);
  msg::Odometry jumped;
  jumped.header.stamp = msg::ToStamp((run.now() + Milliseconds(10)).time_since_epoch());
  run.walker.OnOdometry(jumped, run.now());
  run.RunFor(Milliseconds(500));
  EXPECT_EQ(run.walker.end(), End::kLost);
  EXPECT_THAT(run.walker.reason(), ::testing::HasSubstr("jumped"));
  for (const auto& frame : run.frames) EXPECT_LT(std::abs(frame.velocity.yaw_rad_s), 0.3);
  run.frames.clear();
  ASSERT_TRUE(run.walker.Start(run.now()));
  run.RunToEnd();
  EXPECT_EQ(Fastest(run), 0) << "it does not know how far it has come";
}

void RunUntilTheEndIsKnown(SLaneRun& run) {
  while (run.walker.active() && !run.walker.to_end_m()) run.RunFor(Milliseconds(50));
  ASSERT_TRUE(run.walker.active());
}

// It walked on by it, 6 m beyond the lane in 30 s.
TEST(SLaneWalk, EndsSilentWhereTheOdometryRepeatsItsLastMessage) {
  for (const bool end_known : {false, true}) {
    SLaneRun run(1, 0, 0, BeforeTheLine());
    run.RunFor(Milliseconds(2000));
    if (end_known) RunUntilTheEndIsKnown(run);
    run.repeats_odometry = true;
    const double along_m = run.place().along_m;
    run.RunFor(Milliseconds(1500));
    EXPECT_EQ(run.walker.end(), End::kSilent) << end_known;
    EXPECT_THAT(run.walker.reason(), ::testing::HasSubstr("odometry"));
    EXPECT_LT(run.place().along_m - along_m, 0.45) << end_known;
  }
}

TEST(SLaneWalk, EndsSilentWithoutPicturesAlsoWhereItsEndIsKnown) {
  WalkRules rules;
  rules.end_gap_m = -2;  // the end is reached later
  SLaneRun run(1, 0, 0, rules);
  run.RunFor(Milliseconds(2000));
  RunUntilTheEndIsKnown(run);
  run.has_cameras = false;
  run.RunFor(Milliseconds(1500));
  EXPECT_EQ(run.walker.end(), End::kSilent);
  EXPECT_THAT(run.walker.reason(), ::testing::HasSubstr("no pictures"));
}

// A walk that continues to a known end began before it had a picture.
TEST(SLaneWalk, ContinuesToItsEndOnlyWithPictures) {
  SLaneRun run(1, 0, 0);
  while (run.walker.active() && run.walker.to_end_m().value_or(1) > -0.1) {
    run.RunFor(Milliseconds(100));
  }
  ASSERT_TRUE(run.walker.active());
  run.walker.Stop(run.now());
  run.RunFor(Milliseconds(1000));
  run.has_cameras = false;
  run.RunFor(Milliseconds(1000));
  ASSERT_TRUE(run.walker.Start(run.now()));
  run.frames.clear();
  run.RunFor(Milliseconds(2000));
  EXPECT_TRUE(run.frames.empty());
  run.has_cameras = true;
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kCourseEnd) << run.walker.reason();
}

// Pictures that were 5 s late counted as those of now: full speed, and an end that was 1.5 m off.
TEST(SLaneWalk, DoesNotWalkByLatePictures) {
  for (const int late_ms : {5000, 2000}) {
    WalkRules rules;
    rules.start_wait = Milliseconds(8000);
    SLaneRun run(1, 0, 0, rules);
    run.simulation.picture_delay = Milliseconds(late_ms);
    run.RunToEnd();
    EXPECT_EQ(Fastest(run), 0) << late_ms;
    EXPECT_EQ(run.walker.end(), End::kSilent) << late_ms;
    EXPECT_THAT(run.walker.reason(), ::testing::HasSubstr(" s old")) << run.walker.reason();
  }
}

TEST(SLaneWalk, IsSlowWhereTheNewestLineIsOld) {
  SLaneRun run(1, 0, 0);
  run.simulation.picture_delay = Milliseconds(800);
  run.RunFor(Milliseconds(3000));
  EXPECT_GT(Fastest(run), 0);
  EXPECT_LE(Fastest(run), 0.15);
}

// The stamps of such pictures say nothing.
TEST(SLaneWalk, WalksByPicturesOfAnotherClock) {
  for (const bool has_clock : {false, true}) {
    SLaneRun run(1, 0, 0, BeforeTheLine());
    run.spoil = [&](View, msg::YellowLines& lines) {
      lines.header.stamp.sec = has_clock ? lines.header.stamp.sec - 3600 : 0;
      if (!has_clock) lines.header.stamp.nanosec = 0;
    };
    run.RunToEnd();
    EXPECT_EQ(run.walker.end(), End::kCourseEnd) << run.walker.reason();
  }
}

// Of another clock, too: their age shows nothing there.
TEST(SLaneWalk, EndsSilentWhereThePicturesRepeat) {
  SLaneRun run(1, 0, 0);
  run.spoil = [](View, msg::YellowLines& lines) { lines.header.stamp = {1, 0}; };
  run.RunFor(Milliseconds(6000));
  EXPECT_EQ(run.walker.end(), End::kSilent);
  EXPECT_LT(run.place().along_m, 0.45);
}

// The words of a picture in doubt mean nothing; it walked the whole lane by them.
TEST(SLaneWalk, DoesNotWalkByPicturesInDoubt) {
  for (const double approach_m : {0.0, 1.2}) {
    WalkRules rules;
    rules.approach_m = approach_m;
    SLaneRun run(1, 0, 0, rules);
    run.spoil = [](View, msg::YellowLines& lines) { lines.doubt = "the floor has their colour"; };
    run.RunToEnd();
    EXPECT_EQ(Fastest(run), 0) << approach_m;
    EXPECT_EQ(run.walker.end(), End::kLost);
  }
}

TEST(SLaneWalk, EndsLostWhereAllPicturesAreInDoubt) {
  SLaneRun run(4, 0, 0, BeforeTheLine());
  run.RunFor(Milliseconds(3000));
  const Time doubt = run.now();
  run.spoil = [](View, msg::YellowLines& lines) { lines.doubt = "the floor has their colour"; };
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kLost);
  EXPECT_NEAR(ToSeconds(run.now() - doubt), 2.7, 0.3);
}

TEST(SLaneWalk, DoesNotBelieveAnEndLineInDoubt) {
  WalkRules rules = BeforeTheLine();
  rules.side_pictures = 100;
  SLaneRun run(1, 0, 0, rules);
  run.spoil = [](View view, msg::YellowLines& lines) {
    if (view == View::kFront) lines.doubt = "the floor has their colour";
  };
  bool known = false;
  for (int i = 0; i < 200 && run.walker.active(); ++i) {
    run.RunFor(Milliseconds(100));
    known = known || run.walker.to_end_m();
  }
  EXPECT_FALSE(known);
  EXPECT_EQ(run.walker.end(), End::kLost);
}

TEST(SLaneWalk, EndsAtItsTimeLimit) {
  WalkRules rules;
  rules.time_limit = Milliseconds(3000);
  SLaneRun run(1, 0, 0, rules);
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kTimeLimit);
  EXPECT_EQ(EndFrames(run), 1);
}

}  // namespace musher::line_walker::s_lane_test
