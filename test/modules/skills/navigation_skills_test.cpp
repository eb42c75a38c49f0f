// All moving skills: their tables, and random schedules of faults, pauses, cancellations and clock
// jumps.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "musher/behavior/skill/check.hpp"
#include "musher/behavior/skill/snapshot.hpp"
#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::navigation_skills_test {

using skill::Status;
using skills::Robot;
using skills::testing::MovingRobot;
using skills::testing::SkillsOnARobot;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

using Texts = std::vector<std::pair<std::string, std::string>>;

TEST(NavigationSkills, AreTheOnesThatMove) {
  const SkillsOnARobot skills;
  EXPECT_THAT(skills.registry.Names(),
              ElementsAre("navigate_to", "nav_2d", "nav_3d", "move", "explore", "track",
                          "follow_line", "avoid_obstacle", "visual_servoing", "leave_tight_start",
                          "clear", "wait", "back_up", "spin"));
}

TEST(NavigationSkills, HaveTablesWithoutAFault) {
  const SkillsOnARobot skills;
  for (const skill::Entry& entry : skills.registry.All()) {
    const skill::Run run(entry.name, entry.make());
    EXPECT_TRUE(run.built()) << run.built().error().message;
    EXPECT_THAT(skill::Check(run.table()), IsEmpty()) << entry.name;
    for (const skill::Table::Parameter& parameter : run.table().parameters()) {
      EXPECT_FALSE(parameter.meaning.empty()) << entry.name << " " << parameter.name;
    }
  }
}

TEST(NavigationSkills, HaveTheBaseForThemselves) {
  const SkillsOnARobot skills;
  for (const skill::Entry& entry : skills.registry.All()) {
    if (entry.name == "clear" || entry.name == "wait") continue;  // they move nothing
    EXPECT_THAT(skill::Run(entry.name, entry.make()).table().parts(), ElementsAre("base"))
        << entry.name;
  }
}

TEST(NavigationSkills, CannotBeRegisteredTwice) {
  SkillsOnARobot skills;
  EXPECT_FALSE(skills::RegisterNavigationSkills(skills.registry, skills.robot));
}

TEST(NavigationSkills, AreUnknownByAWrongParameter) {
  SkillsOnARobot skills;
  const auto started = skills.Start("navigate_to", {{"goal_po", "[1, 2, 3]"}});
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message, ::testing::HasSubstr("goal_po"));
}

TEST(NavigationSkills, SayWhatReplacesAParameterOfOlderClients) {
  SkillsOnARobot skills;
  EXPECT_EQ(skills.Start("track", {{"cancel", "true"}}).error().message,
            "track: there is no parameter cancel: to cancel the skill, cancel its goal");
  EXPECT_EQ(
      skills.Start("move", {{"path", "[[1, 0], [0, 0]]"}, {"cancel", "true"}}).error().message,
      "move: there is no parameter cancel: to cancel the skill, cancel its goal");
  EXPECT_EQ(skills.Start("explore", {{"target_prim", "car"}}).error().message,
            "explore: there is no parameter target_prim: it goes over an area, not to an object; "
            "detect finds an object");
}

// A robot in a hall with two pillars, a line along the x axis and a target that walks in a circle.
class Hall : public SkillsOnARobot {
 public:
  Hall() {
    robot.see_line = [](const navigation::Pose& pose) {
      const double heading = navigation::Wrapped(-pose.yaw_rad);
      const bool seen = std::abs(pose.at.y_m) < 0.6 && std::abs(heading) < 1;
      return seen ? std::optional(Robot::Line{-pose.at.y_m, heading}) : std::nullopt;
    };
    robot.targets["/target_0/odom"] = [this](Time time) -> std::optional<navigation::Pose> {
      if (!target_seen) return std::nullopt;
      const double angle = ToSeconds(time.time_since_epoch()) / 6;
      return navigation::Pose{{4 * std::cos(angle), 4 * std::sin(angle), 0}, angle};
    };
    robot.look = [this](const std::string&, Time time) -> std::optional<skills::Look> {
      const double x = 3 - robot.at.at.x_m, y = -1 - robot.at.at.y_m;
      const double c = std::cos(robot.at.yaw_rad), s = std::sin(robot.at.yaw_rad);
      skills::Look look{time, {}};
      if (target_seen) look.seen.push_back({c * x + s * y, c * y - s * x, 0});
      return look;
    };
    robot.points = {{3, 1, 0}, {3, 1.1, 0}, {-2, -2, 0}, {-2, -2.1, 0}};
    straight_ = robot.plan;
  }

  void StartOne(int which) {
    static const std::vector<std::pair<std::string, Texts>> kRequests{
        {"navigate_to", {{"goal_pos", "[3, 2]"}}},
        {"nav_2d", {{"goal_pos", "[-3, 2]"}}},
        {"move", {{"path", "[[2, 0], [0, 2]]"}, {"loops", "2"}}},
        {"explore", {{"boundary", "[[0, 0], [6, 0], [6, 5], [0, 5]]"}}},
        {"track", {{"duration", "20"}}},
        {"follow_line", {{"distance", "4"}}},
        {"avoid_obstacle", {{"goal_pos", "[4, 0]"}}},
        {"visual_servoing", {{"target", "dock"}}},
        {"leave_tight_start", {}},
        {"clear", {}},
        {"wait", {}},
        {"back_up", {}},
        {"spin", {}},
        {"nav_3d", {{"goal_pos", "[3, 2, 1]"}}},
    };
    const auto& [name, parameters] = kRequests[static_cast<std::size_t>(which) % kRequests.size()];
    robot.robot_kind = name == "nav_3d" ? "cf2x" : "jetbot";
    if (name == "nav_3d") robot.at.at.z_m = 1;
    RC_ASSERT(Start(name, parameters));
  }

  void Apply(int input) {
    switch (input) {
      case 0:
        return KillOr(robot.planner_up, [&] { robot.KillPlanner(); });
      case 1:
        return KillOr(robot.controller_up, [&] { robot.KillController(); });
      case 2:
        robot.odometry_up = !robot.odometry_up;
        return;
      case 3:
        robot.scan_up = !robot.scan_up;
        return;
      case 4:
        target_seen = !target_seen;
        return;
      case 5:
        return robot.FailDrive(MakeError(navigation::Fault::kObstacle, "a person"));
      case 6:
        return robot.FailDrive(MakeError(navigation::Fault::kLate, "late"));
      case 7:
        robot.answers = !robot.answers;
        return;
      case 8:
        if (run().running()) paused ? Resume() : Pause();
        return;
      case 9:
        return static_cast<void>(manager->Cancel(run().name(), "at random").ok());
      case 10:
        now += std::chrono::hours(1);
        return;
      case 11:
        now -= std::chrono::minutes(1);
        return;
      case 12:
        plans_ = !plans_;
        robot.plan = plans_ ? straight_ : [](const auto&, const auto&) -> Result<navigation::Path> {
          return Error{kCodeFailed, "no path"};
        };
        return;
      default:
        return RunFor(input / 4.0);
    }
  }

  bool target_seen = true;

 private:
  template <class Kill>
  static void KillOr(bool& up, Kill&& kill) {
    if (up) {
      kill();
    } else {
      up = true;
    }
  }

  std::function<Result<navigation::Path>(const navigation::Pose&, const navigation::Pose&)>
      straight_;
  bool plans_ = true;
};

// The process is restarted while they run; its drives and plans are lost.
TEST(NavigationSkills, ContinueInAnotherProcess) {
  for (int which = 0; which < 7; ++which) {
    Hall hall;
    hall.StartOne(which);
    hall.RunFor(3);
    ASSERT_EQ(hall.feedback().status, Status::kProcessing) << hall.run().name();
    const auto saved = hall.manager->Save();
    ASSERT_TRUE(saved) << saved.error().message;
    hall.manager = std::make_unique<skill::Manager>(hall.registry.All());
    ASSERT_THAT(hall.manager->Restore(saved.value()), IsEmpty()) << which;
    EXPECT_TRUE(hall.RunToItsEnd(200)) << hall.run().name();
    EXPECT_EQ(hall.feedback().status, Status::kCompleted)
        << hall.run().name() << ": " << hall.feedback().message;
  }
}

RC_GTEST_PROP(NavigationSkills, EndAndLeaveTheRobotAtAStand, ()) {
  Hall hall;
  const int which = *rc::gen::element(0, 1, 2, 3, 4, 5, 6, 7);
  hall.StartOne(which);
  const auto inputs = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 24));
  for (const int input : inputs) {
    hall.Apply(input);
    if (hall.paused) hall.RunFor(3);
    if (hall.paused) RC_ASSERT(hall.robot.Rests());
  }
  if (hall.paused) hall.Resume();
  hall.Step();  // the time of a jump passes
  // Every server is lost now: each ends by itself, or by a cancellation.
  if (*rc::gen::arbitrary<bool>()) {
    hall.robot.KillPlanner();
    hall.robot.KillController();
    hall.robot.odometry_up = hall.target_seen = hall.robot.scan_up = false;
  } else {
    static_cast<void>(hall.manager->Cancel(hall.run().name(), "the end").ok());
  }
  const bool was_cancelled = hall.run().cancelling();
  RC_ASSERT(hall.RunToItsEnd(was_cancelled ? 6 : 200));
  RC_TAG(hall.run().name() + " " + std::string(skill::Name(hall.feedback().status)));
  if (was_cancelled && hall.robot.odometry_up) RC_ASSERT(hall.robot.Rests());
  for (int i = 0; i < 30; ++i) hall.robot.Advance(Milliseconds(100));
  RC_ASSERT(hall.robot.Rests());
  RC_ASSERT((hall.feedback().progress == 100) == (hall.feedback().status == Status::kCompleted));
}

RC_GTEST_PROP(NavigationSkills, ReachTheirGoalWhenTheySaySo, ()) {
  Hall hall;
  hall.StartOne(0);
  const auto inputs = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 40));
  for (const int input : inputs) hall.Apply(input);
  if (hall.paused) hall.Resume();
  hall.RunToItsEnd(300);
  if (hall.feedback().status != Status::kCompleted) return;
  RC_ASSERT(std::hypot(hall.robot.at.at.x_m - 3, hall.robot.at.at.y_m - 2) < 0.5);
}

}  // namespace musher::navigation_skills_test
