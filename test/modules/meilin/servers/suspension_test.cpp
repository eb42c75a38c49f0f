// The sequences of the suspension, pure, with a body before a step in virtual time.

#include "musher/modules/meilin/servers/suspension.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <limits>
#include <set>
#include <vector>

#include "musher/test/modules/meilin/servers/step_world.hpp"

namespace musher::meilin::servers::suspension_test {

using ::testing::Each;
using ::testing::ElementsAre;
using testing::StepWorld;
using State = SuspensionState;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Duration kTick = Milliseconds(10);

const std::vector<ClimbDirection> kDirections = {ClimbDirection::kForward, ClimbDirection::kLeft,
                                                 ClimbDirection::kRight, ClimbDirection::kBackward};

struct ClimbRun {
  std::optional<Suspension::End> end;
  std::vector<int> states;  // in their order
  double seconds = 0;
};

// Climbs in a world until the end, or until `state` is entered.
ClimbRun Climb(Suspension& core, StepWorld& world, Time& now, State until = State::kIdle) {
  ClimbRun run;
  const Time begin = now;
  for (int i = 0; i < 6000 && !run.end; ++i) {
    const int state = static_cast<int>(core.state());
    if (run.states.empty() || run.states.back() != state) run.states.push_back(state);
    if (until != State::kIdle && core.state() == until) break;
    now += kTick;
    world.Step(core.targets());
    world.Report(core, now);
    run.end = core.Update(now);
  }
  run.seconds = ToSeconds(now - begin);
  return run;
}

class SuspensionTest : public ::testing::Test {
 protected:
  // A body at rest, far from any step; heights and distances as given.
  void Report(double height_mm, double distance_mm = 2000, bool on = true) {
    WheelHeights heights{};
    heights.fill(height_mm);
    Report(heights, distance_mm, {on, on, on, on});
  }
  void Report(const WheelHeights& heights, double distance_mm,
              const std::array<bool, kWheels>& switches) {
    std::array<double, kDistances> mm{};
    mm.fill(distance_mm);
    core_.OnChassis(switches, heights, now_);
    core_.OnDistances(mm, now_);
  }
  std::optional<Suspension::End> Tick() {
    now_ += kTick;
    return core_.Update(now_);
  }
  // Begins a climb in a world of its own and goes on until that state.
  StepWorld ClimbUntil(State state, double step_mm) {
    StepWorld world(step_mm, ClimbDirection::kForward);
    world.Report(core_, now_);
    EXPECT_EQ(core_.Begin({SuspensionMode::kAuto, ClimbDirection::kForward, step_mm, 30}, now_),
              "");
    Climb(core_, world, now_, state);
    EXPECT_EQ(core_.state(), state);
    return world;
  }

  SuspensionSettings settings_;
  Suspension core_{settings_};
  Time now_{Milliseconds(1000)};
};

TEST_F(SuspensionTest, ClimbsUpInEachDirectionByItsStates) {
  for (const double step_mm : {200.0, 400.0}) {
    for (const ClimbDirection direction : kDirections) {
      StepWorld world(step_mm, direction);
      world.Report(core_, now_);
      ASSERT_EQ(core_.Begin({SuspensionMode::kClimbUp, direction, step_mm, 30}, now_), "");
      const ClimbRun run = Climb(core_, world, now_);
      ASSERT_TRUE(run.end) << step_mm << " " << static_cast<int>(direction);
      EXPECT_TRUE(run.end->success);
      EXPECT_EQ(run.end->message, "Sequence complete");
      EXPECT_THAT(run.states, ElementsAre(10, 12, 13, 14, 15, 16, 17));
      EXPECT_GT(world.x_m(), 0.2) << "the body is over the step";
      EXPECT_LT(run.seconds, 10);
      EXPECT_EQ(core_.state(), State::kIdle);
    }
  }
}

TEST_F(SuspensionTest, ClimbsDownInEachDirectionByItsStates) {
  for (const double step_mm : {200.0, 400.0}) {
    for (const ClimbDirection direction : kDirections) {
      StepWorld world(-step_mm, direction);
      world.Report(core_, now_);
      ASSERT_EQ(core_.Begin({SuspensionMode::kClimbDown, direction, step_mm, 30}, now_), "");
      const ClimbRun run = Climb(core_, world, now_);
      ASSERT_TRUE(run.end) << step_mm << " " << static_cast<int>(direction);
      EXPECT_EQ(run.end->message, "Sequence complete");
      EXPECT_THAT(run.states, ElementsAre(20, 21, 22, 23));
      EXPECT_GT(world.x_m(), 0.28);
      EXPECT_FALSE(world.fallen());
      EXPECT_LT(run.seconds, 15);
    }
  }
}

TEST_F(SuspensionTest, MeasuresAStepOfUnknownHeight) {
  for (const double step_mm : {200.0, 400.0, -200.0, -400.0}) {
    StepWorld world(step_mm, ClimbDirection::kForward);
    world.Report(core_, now_);
    const bool up = step_mm > 0;
    const SuspensionMode mode = up ? SuspensionMode::kClimbUp : SuspensionMode::kClimbDown;
    ASSERT_EQ(core_.Begin({mode, ClimbDirection::kForward, 0, 30}, now_), "");
    // The step is seen from nearby.
    for (int i = 0; i < 150; ++i) world.Step(std::nullopt);
    double highest = 0;
    ClimbRun run;
    while (!run.end && core_.ElapsedSeconds(now_) < 30) {
      now_ += kTick;
      world.Step(core_.targets());
      world.Report(core_, now_);
      run.end = core_.Update(now_);
      if (core_.targets()) {
        highest =
            std::max(highest, *std::max_element(core_.targets()->begin(), core_.targets()->end()));
      }
    }
    ASSERT_TRUE(run.end) << step_mm;
    EXPECT_EQ(run.end->message, "Sequence complete") << step_mm;
    EXPECT_EQ(highest > 300, std::abs(step_mm) > 300) << step_mm;
  }
}

TEST_F(SuspensionTest, TakesTheSignOfTheHeightInAuto) {
  Report(20);
  ASSERT_EQ(core_.Begin({SuspensionMode::kAuto, ClimbDirection::kForward, 200, 1}, now_), "");
  EXPECT_EQ(core_.state(), State::kUpPrepare);
  EXPECT_THAT(*core_.targets(), Each(205));
  core_.Stop();
  ASSERT_EQ(core_.Begin({SuspensionMode::kAuto, ClimbDirection::kForward, -400, 1}, now_), "");
  EXPECT_EQ(core_.state(), State::kDownPrepare);
}

TEST_F(SuspensionTest, LiftsHighAboveThreeHundredMillimetres) {
  Report(20);
  core_.Begin({SuspensionMode::kClimbUp, ClimbDirection::kForward, 300, 1}, now_);
  EXPECT_THAT(*core_.targets(), Each(205));
  core_.Begin({SuspensionMode::kClimbUp, ClimbDirection::kForward, 301, 1}, now_);
  EXPECT_THAT(*core_.targets(), Each(410));
}

TEST_F(SuspensionTest, SaysWhyAGoalIsImpossible) {
  const auto why = [&](SuspensionMode mode, double mm) {
    return core_.Begin({mode, ClimbDirection::kForward, mm, 1}, now_);
  };
  EXPECT_EQ(why(SuspensionMode::kAuto, 0),
            "AUTO needs a height: above 0 it climbs up, below 0 down");
  EXPECT_EQ(why(SuspensionMode::kDirect, -170), "a height of -170 mm is negative");
  EXPECT_EQ(why(SuspensionMode::kClimbUp, -200), "a height of -200 mm is negative");
  EXPECT_EQ(why(SuspensionMode::kDirect, 441), "no wheel reaches 441 mm, at most 420 mm");
  EXPECT_EQ(why(SuspensionMode::kClimbUp, 600), "a step of 600 mm is too high, at most 400 mm");
  EXPECT_EQ(why(SuspensionMode::kAuto, -600), "a step of 600 mm is too high, at most 400 mm");
  EXPECT_EQ(why(SuspensionMode::kDirect, 30), "the wheels do not report: no reading yet");
  core_.OnChassis({}, {}, now_);
  EXPECT_EQ(why(SuspensionMode::kClimbUp, 200),
            "the distance sensors do not report: no reading yet");
  EXPECT_FALSE(core_.running());
  EXPECT_FALSE(core_.targets());
}

TEST_F(SuspensionTest, SetsAllWheelsDirectly) {
  Report(20);
  ASSERT_EQ(core_.Begin({SuspensionMode::kDirect, ClimbDirection::kForward, 230, 0}, now_), "");
  EXPECT_THAT(*core_.targets(), Each(230));
  EXPECT_FALSE(Tick());
  Report(211);
  EXPECT_FALSE(Tick()) << "two ticks";
  const auto end = Tick();
  ASSERT_TRUE(end);
  EXPECT_TRUE(end->success);
  EXPECT_EQ(end->message, "Direct height set");
}

TEST_F(SuspensionTest, GoesToTheHighestForAHeightWithinTheTolerance) {
  Report(20);
  ASSERT_EQ(core_.Begin({SuspensionMode::kDirect, ClimbDirection::kForward, 430, 0}, now_), "");
  EXPECT_THAT(*core_.targets(), Each(420));
}

TEST_F(SuspensionTest, EndsAtItsTimeLimitWithTheWheelsWhereTheyAre) {
  Report(20);
  core_.Begin({SuspensionMode::kClimbUp, ClimbDirection::kForward, 200, 1.5}, now_);
  std::optional<Suspension::End> end;
  while (!end) {
    Report(100);
    end = Tick();
  }
  EXPECT_FALSE(end->success);
  EXPECT_EQ(end->message, "Timeout");
  EXPECT_NEAR(core_.ElapsedSeconds(now_), 1.5, 0.011);
  EXPECT_EQ(core_.state(), State::kUpPrepare);
  EXPECT_THAT(*core_.targets(), Each(100));
}

TEST_F(SuspensionTest, HasALimitOfItsOwn) {
  Report(20);
  core_.Begin({SuspensionMode::kClimbUp, ClimbDirection::kForward, 200, 0}, now_);
  std::optional<Suspension::End> end;
  while (!end) {
    Report(20);
    end = Tick();
  }
  EXPECT_NEAR(core_.ElapsedSeconds(now_), 10, 0.011);
}

TEST_F(SuspensionTest, StopsInEachState) {
  for (const State state :
       {State::kUpPrepare, State::kUpFrontDock, State::kUpRetractFront, State::kUpFrontLand,
        State::kUpRearDock, State::kUpRearLand, State::kUpRecover}) {
    const StepWorld world = ClimbUntil(state, 200);
    core_.Stop();
    EXPECT_EQ(*core_.targets(), world.heights());
    EXPECT_FALSE(Tick());
  }
  for (const State state :
       {State::kDownPrepare, State::kDownRearLand, State::kDownClear, State::kDownRecover}) {
    const StepWorld world = ClimbUntil(state, -200);
    core_.Stop();
    EXPECT_EQ(*core_.targets(), world.heights());
    EXPECT_FALSE(core_.running());
  }
}

TEST_F(SuspensionTest, WaitsInEachStateForItsSensorUntilTheLimit) {
  // The base stands: no sensor changes.
  for (const double step_mm : {200.0, -200.0}) {
    StepWorld world(step_mm, ClimbDirection::kForward);
    world.Report(core_, now_);
    core_.Begin({SuspensionMode::kAuto, ClimbDirection::kForward, step_mm, 5}, now_);
    std::optional<Suspension::End> end;
    while (!end) {
      now_ += kTick;
      world.Step(core_.targets(), 0);
      world.Report(core_, now_);
      end = core_.Update(now_);
    }
    EXPECT_EQ(end->message, "Timeout");
    EXPECT_EQ(core_.state(), step_mm > 0 ? State::kUpFrontDock : State::kDownPrepare);
  }
}

TEST_F(SuspensionTest, EndsWithoutFeedback) {
  Report(20);
  core_.Begin({SuspensionMode::kClimbUp, ClimbDirection::kForward, 200, 10}, now_);
  std::optional<Suspension::End> end;
  while (!end) {
    std::array<double, kDistances> mm{};
    core_.OnDistances(mm, now_);
    end = Tick();
  }
  EXPECT_EQ(end->message, "Wheel feedback lost: no reading for 0.5 s");
  Report(20);
  core_.Begin({SuspensionMode::kClimbUp, ClimbDirection::kForward, 200, 10}, now_);
  end.reset();
  while (!end) {
    core_.OnChassis({}, {20, 20, 20, 20}, now_);
    end = Tick();
  }
  EXPECT_EQ(end->message, "Distance feedback lost: no reading for 0.5 s");
}

TEST_F(SuspensionTest, LowersALiftedBodyBeforeItLooksForAnEdge) {
  // Lifted wheels: the switches are off although the body is on the platform.
  Report(230, 230, false);
  core_.Begin({SuspensionMode::kClimbDown, ClimbDirection::kForward, 200, 10}, now_);
  for (int i = 0; i < 50; ++i) {
    Report(230, 230, false);
    EXPECT_FALSE(Tick());
  }
  EXPECT_EQ(core_.state(), State::kDownPrepare);
  EXPECT_THAT(*core_.targets(), Each(20));
}

TEST_F(SuspensionTest, DocksAfterFiveTicksOfAShortDistance) {
  Report(205, 200);
  core_.Begin({SuspensionMode::kClimbUp, ClimbDirection::kForward, 200, 10}, now_);
  for (int i = 0; i < 10; ++i) {
    Report(205, 200);
    Tick();
  }
  ASSERT_EQ(core_.state(), State::kUpFrontDock);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 5; ++j) Report(205, 79);
    Tick();
    ASSERT_EQ(core_.state(), State::kUpFrontDock);
  }
  Report(205, kNan);  // forgets the readings before
  Tick();
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 5; ++j) Report(205, 79);
    Tick();
    ASSERT_EQ(core_.state(), State::kUpFrontDock);
  }
  Tick();
  EXPECT_EQ(core_.state(), State::kUpRetractFront);
  EXPECT_THAT(*core_.targets(), ElementsAre(5, 5, 205, 205));
}

const std::set<int> kStates = {0, 10, 11, 12, 13, 14, 15, 16, 17, 20, 21, 22, 23};

RC_GTEST_PROP(SuspensionProperty, EndsInANamedStateWithinItsLimitWhateverTheSensorsSay, ()) {
  const SuspensionSettings settings;
  Suspension core(settings);
  Time now{Milliseconds(1000)};
  core.OnChassis({}, {20, 20, 20, 20}, now);
  core.OnDistances({}, now);
  SuspensionGoal goal;
  goal.mode = static_cast<SuspensionMode>(*rc::gen::inRange(0, 4));
  goal.direction = static_cast<ClimbDirection>(*rc::gen::inRange(0, 4));
  goal.height_mm = *rc::gen::inRange(-450, 451);
  goal.limit_s = 3;
  if (!core.Begin(goal, now).empty()) {
    RC_ASSERT(!core.running());
    return;
  }
  // Now and then the readings change, to values that the sequences wait for or to nonsense.
  std::array<bool, kWheels> switches{};
  WheelHeights heights{20, 20, 20, 20};
  std::array<double, kDistances> distances{};
  const auto changes = *rc::gen::container<std::vector<int>>(30, rc::gen::inRange(0, 1 << 16));
  std::optional<Suspension::End> end;
  for (int tick = 0; !end; ++tick) {
    RC_ASSERT(tick <= 301);
    if (tick % 10 == 0) {
      const int change = changes.at(std::min<std::size_t>(tick / 10, changes.size() - 1));
      for (std::size_t i = 0; i < kWheels; ++i) switches[i] = ((change >> i) & 1) != 0;
      if ((change & 16) != 0) heights = core.targets().value_or(heights);
      if ((change & 32) != 0) heights[change % 4] = change % 500;
      if ((change & 64) != 0) heights[0] = kNan;
      distances.fill((change & 128) != 0 ? kNan : (change >> 8) * 8);
    }
    now += kTick;
    core.OnChassis(switches, heights, now);
    core.OnDistances(distances, now);
    end = core.Update(now);
    RC_ASSERT(kStates.contains(static_cast<int>(core.state())));
    for (const double mm : *core.targets()) RC_ASSERT(mm >= 0 && mm <= 420);
  }
  RC_ASSERT(!core.running());
  RC_ASSERT(end->success || end->message == "Timeout" ||
            end->message.starts_with("Wheel feedback lost"));
}

}  // namespace musher::meilin::servers::suspension_test
