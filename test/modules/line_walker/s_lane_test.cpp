// The walker in a closed loop: a lane like an S, with a lag, slip, noise and late pictures.

#include <gmock/gmock.h>

#include <array>
#include <iostream>
#include <limits>
#include <string>

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

TEST(SLaneWalk, EndsAtItsTimeLimit) {
  WalkRules rules;
  rules.time_limit = Milliseconds(3000);
  SLaneRun run(1, 0, 0, rules);
  run.RunToEnd();
  EXPECT_EQ(run.walker.end(), End::kTimeLimit);
  EXPECT_EQ(EndFrames(run), 1);
}

}  // namespace musher::line_walker::s_lane_test
