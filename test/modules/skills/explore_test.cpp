// explore: to the start and along the path, past obstacles, and what it refuses. The path itself is
// in coverage_test.cpp.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <set>

#include "musher/behavior/skill/snapshot.hpp"
#include "musher/navigation/planner/cell_map.hpp"
#include "musher/navigation/trajectory/trajectory.hpp"
#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::explore_test {

using skill::Status;
using skills::testing::SkillsOnARobot;
using ::testing::HasSubstr;
using ::testing::StartsWith;

using Texts = std::vector<std::pair<std::string, std::string>>;

class Explore : public ::testing::Test, public SkillsOnARobot {
 protected:
  Explore() { robot.drive_speed_m_s = 1.5; }

  // 63 m in 4 lanes.
  void Go(Texts more = {}) {
    more.insert(more.begin(), {"boundary", "[[0, 0], [16, 0], [16, 8], [0, 8]]"});
    const Result<> started = Start("explore", more);
    ASSERT_TRUE(started) << started.error().message;
  }
  // The path of the planner leads around it, and to a place in it through it.
  void PutABoxOnTheFirstLane() {
    robot.blocked = [](const navigation::Point& at) {
      return at.x_m > 6 && at.x_m < 9 && std::abs(at.y_m - 1) < 0.6;
    };
    robot.plan = [this](const auto& from, const auto& to) -> Result<navigation::Path> {
      if (robot.blocked(to.at) || from.at.x_m < 4) return navigation::Path{from, to};
      constexpr double kBesideM = 2.2;
      return navigation::Path{
          from, {{from.at.x_m, kBesideM, 0}, 0}, {{to.at.x_m, kBesideM, 0}, 0}, to};
    };
  }
  // The lanes at y = 1, 3, 5 and 7, in squares of 0.5 m over which the middle of the robot has
  // been.
  void NotePlaces() {
    EachStep([this] {
      if (run().Path() != "EXECUTING") return;
      places_.insert({static_cast<int>(std::lround(2 * robot.at.at.x_m)),
                      static_cast<int>(std::lround(2 * robot.at.at.y_m))});
    });
  }
  bool HasBeenEverywhere() const {
    for (int x = 2; x <= 30; ++x) {
      for (const int y : {2, 6, 10, 14}) {
        const bool near = places_.contains({x, y}) || places_.contains({x - 1, y}) ||
                          places_.contains({x + 1, y});
        if (!near) return false;
      }
    }
    return true;
  }
  std::set<std::pair<int, int>> places_;

  // Of four corners each.
  static std::int64_t Strips(const std::string& boundary) {
    const auto closed = std::ranges::count(boundary, ']');  // 5 a strip, and that of the list
    return (closed - 1) / 5;
  }
  // 20 m by 20 m.
  static std::shared_ptr<navigation::CellMap> MapWith(
      const std::function<bool(double x_m, double y_m)>& is_blocked) {
    auto map = std::make_shared<navigation::CellMap>();
    map->resolution_m = 0.1;
    map->size_x = map->size_y = 200;
    map->blocked.assign(200 * 200, 0);
    for (int x = 0; x < 200; ++x) {
      for (int y = 0; y < 200; ++y) {
        if (is_blocked(0.1 * x + 0.05, 0.1 * y + 0.05)) map->blocked[map->IndexOf({x, y, 0})] = 1;
      }
    }
    return map;
  }

  std::string WhyRefused(const std::string& boundary, Texts more = {}) {
    more.insert(more.begin(), {"boundary", boundary});
    EXPECT_TRUE(Start("explore", more));
    Step();
    EXPECT_EQ(feedback().status, Status::kFailed);
    return feedback().message;
  }
};

TEST_F(Explore, GoesToTheStartAndAlongItsPath) {
  robot.at = {{-3, -3, 0}, 0};
  std::set<int> progress;
  std::set<std::string> texts;
  Go();
  EachStep([&] {
    progress.insert(feedback().progress);
    texts.insert(feedback().message.substr(0, 14));
  });
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(feedback().message, "Exploration completed (66.0 m in 4 lanes)");
  for (const int step : {20, 40, 60, 65, 94, 100}) EXPECT_TRUE(progress.contains(step)) << step;
  EXPECT_TRUE(texts.contains("Exploring... ("));
  ASSERT_EQ(robot.driven_paths.size(), 2U);
  EXPECT_LT(navigation::Distance(robot.driven_paths[0].back().at, {0.5, 1, 0}), 0.1);
  EXPECT_NEAR(robot.travelled_m, 66 + 5.3, 1);
}

// The controller makes a trajectory of the path.
TEST_F(Explore, HasAPathThatCanBeDrivenInTime) {
  for (const char* distance : {"0.05", "0.5", "100"}) {
    robot.at = {};
    robot.driven_paths.clear();
    Go({{"interpolation_distance", distance}});
    EXPECT_TRUE(RunToItsEnd(120));
    ASSERT_EQ(robot.driven_paths.size(), 2U);
    const auto trajectory = navigation::MakeTrajectory(robot.driven_paths[1], {});
    ASSERT_TRUE(trajectory) << trajectory.error().message;
    EXPECT_LT(trajectory.value().duration(), std::chrono::seconds(100));
  }
}

TEST_F(Explore, ReportsItsPath) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(2);
  EXPECT_NEAR(feedback().details.Number("path_length"), 66, 0.1);
  EXPECT_EQ(feedback().details.Get<std::int64_t>("lanes", 0), 4);
  EXPECT_GT(feedback().details.Number("distance_to_goal"), 0);
}

TEST_F(Explore, PassesAnObstacleOnItsPath) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  for (int i = 0; i < 3; ++i) {
    RunFor(5);
    robot.FailDrive(MakeError(navigation::Fault::kObstacle, "a box"));
    Step();
    EXPECT_THAT(feedback().message, StartsWith("Passing an obstacle..."));
  }
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_THAT(feedback().message, HasSubstr("3.0 m blocked"));
}

// Three metres of the first lane.
TEST_F(Explore, PassesAnObstacleThatIsLongerThanOneStep) {
  PutABoxOnTheFirstLane();
  Go();
  EXPECT_TRUE(RunToItsEnd(130));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_NEAR(feedback().details.Number("skipped"), 4, 0.3);
}

TEST_F(Explore, CountsWhatIsBlockedOnceAlsoWhenTheControllerIsLost) {
  PutABoxOnTheFirstLane();
  Go();
  for (int i = 0; i < 200 && feedback().details.Number("skipped") < 1.5; ++i) Step();
  robot.KillController();
  RunFor(3);
  robot.controller_up = true;
  EXPECT_TRUE(RunToItsEnd(130));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_NEAR(feedback().details.Number("skipped"), 4, 0.3);
}

TEST_F(Explore, CompletesWhenOnlyTheEndOfItsPathIsBlocked) {
  const auto plan = robot.plan;
  for (const bool refuses : {false, true}) {
    robot.at = {};
    robot.blocked = [](const navigation::Point& at) { return at.x_m < 0.9 && at.y_m > 6.5; };
    robot.plan = [&, refuses](const auto& from, const auto& to) -> Result<navigation::Path> {
      if (refuses && robot.blocked(to.at)) return Error{kCodeFailed, "walled in"};
      return plan(from, to);
    };
    Go();
    EXPECT_TRUE(RunToItsEnd(120));
    EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
    EXPECT_THAT(feedback().message, HasSubstr("0.9 m blocked"));
  }
}

TEST_F(Explore, FailsWhenMostOfItsPathIsBlocked) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 4; };
  Go();
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(feedback().message, HasSubstr("m of the path of 66.0 m were blocked: an obstacle"));
}

// It had succeeded, at 100 %, and the next step of a plan began.
TEST_F(Explore, IsPartialWhenItHasLeftOutMuchAndTheNextRunCoversTheRest) {
  NotePlaces();
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 9; };
  Go();
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(feedback().message, StartsWith("Partial exploration: 5"));
  EXPECT_LT(feedback().progress, 100);
  EXPECT_LT(feedback().details.Number("covered"), 60);
  EXPECT_FALSE(HasBeenEverywhere());
  const std::string uncovered = feedback().details.Text("uncovered");
  EXPECT_THAT(uncovered, StartsWith("[[["));
  robot.blocked = [](const auto&) { return false; };
  ASSERT_TRUE(Start("explore", {{"boundary", uncovered}}));
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(feedback().details.Text("uncovered"), "");
  EXPECT_EQ(feedback().details.Number("covered"), 100);
  EXPECT_TRUE(HasBeenEverywhere());
  EXPECT_LT(robot.travelled_m, 120) << "only the rest once more";
}

TEST_F(Explore, SaysWhatIsUncoveredAtEachEarlyEnd) {
  for (const std::string end : {"limit", "cancel", "failure"}) {
    robot.at = {};
    places_.clear();
    NotePlaces();
    robot.drive_speed_m_s = end == "limit" ? 0.3 : 1.5;
    Go();
    ASSERT_TRUE(RunToState("EXECUTING"));
    if (end != "limit") RunFor(20);
    if (end == "cancel") {
      ASSERT_TRUE(manager->Cancel("explore", "the test"));
    }
    if (end == "failure") robot.FailDrive(Error{kCodeFailed, "a wheel is lost"});
    EXPECT_TRUE(RunToItsEnd(150));
    EXPECT_NE(feedback().status, Status::kCompleted) << end;
    const std::string uncovered = feedback().details.Text("uncovered");
    EXPECT_GT(feedback().details.Number("covered"), 30) << end;
    EXPECT_LT(feedback().details.Number("covered"), 70) << end;
    robot.drive_speed_m_s = 1.5;
    ASSERT_TRUE(Start("explore", {{"boundary", uncovered}})) << end;
    EXPECT_TRUE(RunToItsEnd(120));
    EXPECT_EQ(feedback().status, Status::kCompleted) << end << ": " << feedback().message;
    EXPECT_TRUE(HasBeenEverywhere()) << end;
  }
}

TEST_F(Explore, IsPartialWhereItCannotReachAPartOfItsArea) {
  const std::string two_rooms =
      "[[0, 0], [6, 0], [6, 2.8], [8, 2.8], [8, 0], [14, 0], [14, 6], [8, 6], [8, 3.2], [6, 3.2], "
      "[6, 6], [0, 6]]";
  std::set<bool> rooms;  // the right one
  EachStep([&] {
    if (run().Path() == "EXECUTING") rooms.insert(robot.at.at.x_m > 7);
  });
  ASSERT_TRUE(Start("explore", {{"boundary", two_rooms}}));
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_EQ(rooms.size(), 1U);
  const bool first = *rooms.begin();
  rooms.clear();
  EXPECT_THAT(feedback().message, StartsWith("Partial exploration: 50 % of the lanes"));
  EXPECT_THAT(feedback().message, HasSubstr("1 parts cannot be reached"));
  const std::string uncovered = feedback().details.Text("uncovered");
  ASSERT_TRUE(Start("explore", {{"boundary", uncovered}}));
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(rooms, std::set<bool>{!first}) << "the other room, once it may be entered";
}

// A wall across the first two lanes, and a pillar that is as wide as a lane.
TEST_F(Explore, LeavesOutWhatItsMapHas) {
  const auto is_blocked = [](double x_m, double y_m) {
    return (x_m > 7.7 && x_m < 8.3 && y_m < 4) || (x_m > 11 && x_m < 13 && y_m > 6);
  };
  robot.ground_map = {true, nullptr};
  robot.blocked = [&](const navigation::Point& at) {
    return is_blocked(at.x_m, at.y_m) || is_blocked(at.x_m + 0.2, at.y_m) ||
           is_blocked(at.x_m - 0.2, at.y_m);
  };
  robot.plan = [&](const auto& from, const auto& to) -> Result<navigation::Path> {
    if (robot.blocked(to.at)) return Error{kCodeFailed, "in a wall"};
    return navigation::Path{from, {{from.at.x_m, 5, 0}, 0}, {{to.at.x_m, 5, 0}, 0}, to};
  };
  NotePlaces();
  Go();
  RunFor(1);
  EXPECT_EQ(feedback().message, "Waiting for the map");
  robot.ground_map = {false, MapWith(is_blocked)};
  EXPECT_TRUE(RunToItsEnd(180));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(feedback().message,
            "Exploration completed (61.3 m in 4 lanes, 4.7 m left out by the map)");
  EXPECT_EQ(feedback().details.Number("skipped"), 0) << "it has met no obstacle";
  EXPECT_EQ(feedback().details.Number("covered"), 100);
  for (const int y : {2, 6, 10, 14}) {
    for (int x = 2; x <= 30; ++x) {
      const bool in_wall = (y < 8 && x > 13 && x < 19) || (y > 12 && x > 19 && x < 29);
      const bool near =
          places_.contains({x, y}) || places_.contains({x - 1, y}) || places_.contains({x + 1, y});
      EXPECT_TRUE(near || in_wall) << x / 2.0 << " " << y / 2.0;
    }
  }
}

// It had reported 66 m in 4 lanes after half a metre.
TEST_F(Explore, SaysHowLittleItsMapHasLeft) {
  robot.ground_map = {false, MapWith([](double x_m, double y_m) { return x_m > 2 || y_m > 2; })};
  bool is_blocked = false;
  robot.blocked = [&](const navigation::Point& at) { return is_blocked && at.x_m > 0.9; };
  for (is_blocked = false;; is_blocked = true) {
    robot.at = {};
    Go();
    EXPECT_TRUE(RunToItsEnd(60));
    EXPECT_NEAR(feedback().details.Number("path_length"), 1.25, 0.06);
    EXPECT_NEAR(feedback().details.Number("left_out_by_map"), 64.75, 0.06);
    EXPECT_EQ(feedback().details.Get<std::int64_t>("lanes", 0), 1);
    if (is_blocked) break;
    EXPECT_THAT(
        feedback().message,
        ::testing::MatchesRegex("Exploration completed .1.[23] m in 1 lanes, 64.[78] m left "
                                "out by the map."));
  }
  EXPECT_THAT(feedback().message, HasSubstr("m of the path of 1."));
}

TEST_F(Explore, SaysThatItHasNoMap) {
  robot.ground_map = {false, nullptr, true};
  Go();
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().message, "Exploration completed (66.0 m in 4 lanes, without a map)");
}

// The first version with maps had saved where it began, and no cuts.
TEST_F(Explore, HasThePathWithWhichItBeganAfterARestart) {
  for (const bool had_map : {false, true}) {
    robot.at = {};
    robot.travelled_m = 0;
    const auto map = MapWith([](double x_m, double) { return x_m > 8; });
    robot.ground_map = {false, had_map ? map : nullptr};
    Go();
    ASSERT_TRUE(RunToState("EXECUTING"));
    RunFor(3);
    const double length_m = feedback().details.Number("path_length");
    auto saved = manager->Save();
    ASSERT_TRUE(saved) << saved.error().message;
    if (!had_map) saved.value().runs.at(0).data.Remove("cuts");
    robot.ground_map = {false, had_map ? nullptr : map};
    manager = std::make_unique<skill::Manager>(registry.All());
    ASSERT_THAT(manager->Restore(saved.value()), ::testing::IsEmpty());
    RunFor(1);
    EXPECT_NEAR(feedback().details.Number("path_length"), length_m, 1e-6);
    EXPECT_TRUE(RunToItsEnd(120));
    EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  }
}

// They held up the loop for many seconds, and more than 500 were refused, also those of
// `uncovered`.
TEST_F(Explore, PlansManyAreasInSeveralSteps) {
  std::string boundary;
  for (int i = 0; i < 600; ++i) {
    const int x = i % 30, y = i / 30;
    boundary += fmt::format("{}[[{}, {}], [{}, {}], [{}, {}]]", i == 0 ? "[" : ", ", 3 * x, 3 * y,
                            3 * x + 2, 3 * y, 3 * x, 3 * y + 2);
  }
  ASSERT_TRUE(Start("explore", {{"boundary", boundary + "]"}, {"robot_radius", "0.2"}}));
  Step();
  EXPECT_EQ(feedback().message, "Planning coverage path...");
  EXPECT_EQ(feedback().details.Number("path_length"), 0);
  ASSERT_TRUE(manager->Cancel("explore", "the test"));
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().status, Status::kCancelled);
  EXPECT_EQ(feedback().details.Text("uncovered"), "");
  ASSERT_TRUE(Start("explore", {{"boundary", boundary + "]"}, {"robot_radius", "0.2"}}));
  EXPECT_TRUE(RunToState("NAVIGATING_TO_START", 10)) << feedback().message;
  EXPECT_GE(feedback().details.Get<std::int64_t>("lanes", 0), 600);
}

// The strip of a lane had it twice where a lane is as wide as the robot.
TEST_F(Explore, DrivesAStripOfANarrowLaneOnce) {
  for (const char* width : {"1", "0.8", "0.5"}) {
    robot.at = {};
    ASSERT_TRUE(Start("explore", {{"boundary", "[[0, 0], [12, 0], [12, 3.9], [0, 3.9]]"},
                                  {"lane_width", width}}));
    ASSERT_TRUE(RunToState("EXECUTING"));
    RunFor(10);
    ASSERT_TRUE(manager->Cancel("explore", "the test"));
    EXPECT_TRUE(RunToItsEnd(3));
    const std::string uncovered = feedback().details.Text("uncovered");
    ASSERT_TRUE(Start("explore", {{"boundary", uncovered}, {"lane_width", width}}));
    RunFor(1);
    EXPECT_EQ(feedback().details.Get<std::int64_t>("lanes", 0), Strips(uncovered)) << uncovered;
    ASSERT_TRUE(manager->Cancel("explore", "the test"));
    EXPECT_TRUE(RunToItsEnd(3));
  }
}

TEST_F(Explore, SaysThatItsMapLeavesNoRoom) {
  robot.ground_map = {false, MapWith([](double, double) { return true; })};
  Go();
  Step();
  EXPECT_EQ(feedback().message, "the map leaves no room for the robot in the boundary");
}

TEST_F(Explore, IsCompletedWithAsMuchAsTheRequestSays) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 9; };
  Go({{"least_covered", "0.5"}});
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_THAT(feedback().details.Text("uncovered"), StartsWith("[[["));
  robot.at = {};
  PutABoxOnTheFirstLane();
  Go({{"least_covered", "1"}});
  EXPECT_TRUE(RunToItsEnd(130));
  EXPECT_THAT(feedback().message, StartsWith("Partial exploration: 93 %"));
}

TEST_F(Explore, GoesOverSeveralAreasOneAfterTheOther) {
  ASSERT_TRUE(Start("explore", {{"boundary",
                                 "[[[20, 0], [26, 0], [26, 2], [20, 2]], "
                                 "[[0, 0], [6, 0], [6, 2], [0, 2]], "
                                 "[[10, 0], [16, 0], [16, 2], [10, 2]]]"}}));
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().message, "Exploration completed (15.0 m in 3 lanes)");
  EXPECT_NEAR(robot.at.at.x_m, 25.5, 0.1);
  EXPECT_LT(robot.travelled_m, 30);
}

TEST_F(Explore, PassesAnAreaThatIsBlocked) {
  robot.blocked = [](const navigation::Point& at) { return at.x_m > 9 && at.x_m < 17; };
  robot.plan = [this](const auto& from, const auto& to) -> Result<navigation::Path> {
    if (robot.blocked(to.at)) return Error{kCodeFailed, "walled in"};
    return navigation::Path{from, {{from.at.x_m, -3, 0}, 0}, {{to.at.x_m, -3, 0}, 0}, to};
  };
  robot.blocked = [](const navigation::Point& at) {
    return at.x_m > 9 && at.x_m < 17 && at.y_m > -1;
  };
  ASSERT_TRUE(Start("explore", {{"boundary",
                                 "[[[0, 0], [6, 0], [6, 2], [0, 2]], "
                                 "[[10, 0], [13, 0], [13, 2], [10, 2]], "
                                 "[[20, 0], [26, 0], [26, 2], [20, 2]]]"}}));
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(feedback().message, StartsWith("Partial exploration: 83 % of the lanes"));
  EXPECT_NEAR(robot.at.at.x_m, 25.5, 0.1);
}

TEST_F(Explore, WaitsAtAnObstacleOnTheWayToItsStart) {
  robot.at = {{-6, 1, 0}, 0};
  bool closed = true;
  robot.blocked = [&](const navigation::Point& at) { return closed && at.x_m > -2; };
  Go();
  RunFor(20);
  closed = false;
  EXPECT_TRUE(RunToItsEnd(130));
  EXPECT_EQ(feedback().message, "Exploration completed (66.0 m in 4 lanes)");
}

// The pose of a humanoid is that of its pelvis.
TEST_F(Explore, DoesNotCountHeightsOnTheGround) {
  robot.robot_kind = "h1";
  robot.pelvis_m = 0.7;
  Go();
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(robot.plans, 1);
}

TEST_F(Explore, FailsWhenNothingCanBeReached) {
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return Error{kCodeFailed, "walled in"};
  };
  Go();
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(feedback().message, HasSubstr("walled in"));
}

TEST_F(Explore, LimitsTheWayToTheStartAndTheExploration) {
  robot.at = {{-3, -3, 0}, 0};
  robot.drive_speed_m_s = 0.01;
  Go();
  RunFor(59);
  EXPECT_EQ(feedback().state, "NAVIGATING_TO_START");
  EXPECT_TRUE(RunToItsEnd(3));
  EXPECT_EQ(feedback().message, "Navigate timeout: the start was not reached");
  robot.at = {{0.5, 1, 0}, 0};
  robot.drive_speed_m_s = 0.25;
  Go();
  EXPECT_TRUE(RunToItsEnd(150));
  EXPECT_THAT(feedback().message, HasSubstr("Timeout: 4"));
}

TEST_F(Explore, ContinuesAfterAPauseAndALostController) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(10);
  Pause();
  RunFor(500);
  EXPECT_TRUE(robot.Rests());
  Resume();
  RunFor(5);
  robot.KillController();
  RunFor(3);
  robot.controller_up = true;
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_LE(robot.travelled_m, 66 + 6);
}

// Its path began with what the planner could not plan, which was left out.
TEST_F(Explore, WaitsForALateMapAndLeavesNothingOut) {
  const auto plans = robot.plan;
  bool has_map = false;
  robot.plan = [&](const auto& start, const auto& goal) -> Result<navigation::Path> {
    if (!has_map) return Error{kCodeStateInvalid, "there is no map yet, on map"};
    return plans(start, goal);
  };
  Go();
  RunFor(15);
  EXPECT_THAT(feedback().message, HasSubstr("there is no map yet, on map"));
  EXPECT_TRUE(robot.Rests());
  has_map = true;
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(feedback().details.Number("skipped"), 0);
  has_map = false;
  Go();
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_THAT(feedback().message, HasSubstr("there is no map yet, on map, waited for 2"));
}

TEST_F(Explore, ReturnsToItsPathWhenItWasMovedInAPause) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(10);
  Pause();
  RunFor(5);
  robot.at.at = {3, 20, 0};
  Resume();
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(feedback().details.Number("skipped"), 0);
}

TEST_F(Explore, StandsBeforeItIsCancelled) {
  for (const char* state : {"INITIALIZING", "NAVIGATING_TO_START", "EXECUTING"}) {
    robot.at = {{-3, -3, 0}, 0};
    Go();
    ASSERT_TRUE(RunToState(state));
    if (std::string(state) != "INITIALIZING") RunFor(2);
    ASSERT_TRUE(manager->Cancel("explore", "the test"));
    EXPECT_TRUE(RunToItsEnd(3));
    EXPECT_EQ(feedback().status, Status::kCancelled) << state;
    EXPECT_TRUE(robot.Rests()) << state;
  }
}

TEST_F(Explore, KeepsTheHeightOfAFlyer) {
  robot.robot_kind = "cf2x";
  robot.at = {{1, 1, 1.5}, 0};
  Go();
  EXPECT_TRUE(RunToItsEnd(120));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(robot.at.at.z_m, 1.5);
  robot.at.at.z_m = 0;
  Go();
  Step();
  EXPECT_EQ(feedback().message, "Invalid altitude: robot_0 is at 0.00 m; it has to take off first");
}

TEST_F(Explore, DoesNotGoOnWithAFlyerThatWasPutDown) {
  robot.robot_kind = "cf2x";
  for (const bool restarts : {false, true}) {
    robot.at = {{1, 1, 1.5}, 0};
    Go();
    ASSERT_TRUE(RunToState("EXECUTING"));
    Pause();
    RunFor(3);
    const auto saved = manager->Save();
    ASSERT_TRUE(saved) << saved.error().message;
    robot.at.at.z_m = 0;
    if (restarts) {
      manager = std::make_unique<skill::Manager>(registry.All());
      ASSERT_THAT(manager->Restore(saved.value()), ::testing::IsEmpty());
    }
    const int drives = robot.drives;
    Resume();
    EXPECT_TRUE(RunToItsEnd(30));
    EXPECT_EQ(feedback().message,
              "Invalid altitude: robot_0 is at 0.00 m; it has to take off first");
    EXPECT_EQ(robot.drives, drives);
  }
}

TEST_F(Explore, RefusesWhatIsNoArea) {
  const std::string room = "[[0, 0], [16, 0], [16, 8], [0, 8]]";
  EXPECT_EQ(WhyRefused("[[0, 0], [1, 1]]"), "the boundary has 2 corners; expected at least 3");
  EXPECT_EQ(WhyRefused("[0, 0, 1, 1]"), "boundary, character 2: expected '['");
  EXPECT_EQ(WhyRefused(room, {{"holes", "[[[1, 1], [2]]]"}}),
            "holes, character 10: expected 2 or 3 numbers of a place");
  EXPECT_EQ(WhyRefused(room, {{"holes", "[[[20, 1], [22, 1], [22, 2]]]"}}),
            "hole 1 is outside of the boundary");
  EXPECT_EQ(WhyRefused(room, {{"lane_width", "0"}}), "lane_width is 0 m; expected more than 0 m");
  EXPECT_EQ(WhyRefused(room, {{"robot_radius", "5"}}),
            "a robot with a radius of 5 m does not fit into the boundary");
  EXPECT_EQ(WhyRefused(room, {{"interpolation_distance", "0"}}),
            "interpolation_distance is 0 m; expected at least 0.01 m");
  EXPECT_EQ(WhyRefused(room, {{"least_covered", "1.5"}}), "least_covered is 1.5; expected 0 to 1");
  EXPECT_EQ(WhyRefused("[" + room + ", " + room + "]", {{"holes", "[[[1, 1], [2, 1], [2, 2]]]"}}),
            "holes belong to one area, and boundary has 2");
  EXPECT_EQ(WhyRefused("[" + room + ", [[0, 0], [1, 1]]]"),
            "the boundary has 2 corners; expected at least 3");
  EXPECT_EQ(WhyRefused(room, {{"interpolation_method", "cubic"}}),
            "interpolation_method is 'cubic'; expected linear");
  EXPECT_FALSE(Start("explore"));
}

}  // namespace musher::explore_test
