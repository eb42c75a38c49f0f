// The board, in virtual time; and its actuator under injected faults.

#include "leg_board.hpp"

#include "musher/simulation/actuator_fault_test.hpp"

using musher::Milliseconds;
using Status = musher::msg::MotionStatus;

struct Robot {
  // Commands it for that time, 20 times a second, and returns its last report.
  musher::msg::BodyState For(musher::Duration time) {
    musher::msg::BodyState state;
    for (const musher::Time end = now + time; now < end; now += Milliseconds(50)) {
      if (sends) board.Take(command, now);
      state = board.Report(now);
    }
    return state;
  }
  musher::msg::BodyState Do(std::int8_t mode, std::int8_t gait, std::vector<float> speed = {}) {
    command.mode = mode;
    command.gait_id = gait;
    command.vel_des = std::move(speed);
    ++command.life_count;
    return For(Milliseconds(2000));
  }

  Board board;
  Board::Command command;
  bool sends = true;
  musher::Time now{};
};

TEST(Board, StandsUpAndWalksAsFarAsItIsCommanded) {
  Robot robot;
  const auto stands = robot.Do(12, 0);
  EXPECT_EQ(stands.mode, 12);
  EXPECT_EQ(stands.order_process_bar, 100);
  EXPECT_EQ(stands.life_count, robot.command.life_count) << "it has taken the command";
  const auto walks = robot.Do(11, 27, {0.5F, 0, 0});
  EXPECT_NEAR(walks.pose.position.x, 1.0, 0.06);
  EXPECT_EQ(robot.Do(11, 1).twist.linear.x, 0) << "WALK_STAND";
}

TEST(Board, StopsWithoutItsManager) {
  Robot robot;
  robot.Do(12, 0);
  robot.Do(11, 27, {0.5F, 0, 0});
  robot.sends = false;
  const double x_m = robot.For(Milliseconds(600)).pose.position.x;
  const auto later = robot.For(Milliseconds(2000));
  EXPECT_NEAR(later.pose.position.x, x_m, 0.03);
  EXPECT_EQ(later.twist.linear.x, 0);
}

TEST(Board, RefusesWhatItCannotDo) {
  Robot robot;
  EXPECT_EQ(robot.Do(17, 1).switch_status, Status::kBanTrans) << "a flip";
  EXPECT_NE(robot.board.Report(robot.now).life_count, robot.command.life_count);
  robot.Do(0, 0);
  EXPECT_EQ(robot.Do(11, 27, {0.5F, 0, 0}).switch_status, Status::kEstop) << "first it stands up";
  robot.Do(7, 1);
  EXPECT_FALSE(robot.board.legs().powered) << "nor does it lie down by its motors";
}

TEST(LegBoard, HasNoPowerInAnEmergency) {
  musher::simulation::ActuatorFaultTest<LegBoard> test;
  test.config_file = "robot.toml";
  test.after_emergency_stop = [](const LegBoard& board, const musher::ActuatorReport&) {
    EXPECT_FALSE(board.board().legs().powered);
  };
  test.Run();
}
