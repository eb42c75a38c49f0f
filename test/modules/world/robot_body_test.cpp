// Robots that are driven by velocity.

#include "musher/modules/world/body/robot_body.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "musher/test/modules/world/rooms.hpp"

namespace musher::world::robot_body_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Nothing in the way, and the ground at 0.
RobotPlace OpenPlace() {
  return {[](const Vector3d&, const Vector3d&) { return std::optional<std::string>(); },
          [](const Vector3d&) { return 0.0; }};
}

struct Driven {
  explicit Driven(const RobotSpec& spec, std::uint64_t seed = 1) : body(spec, seed) {}
  void Steps(int count, bool empty = false) {
    for (int i = 0; i < count; ++i) {
      now += kStep;
      body.Step(place, empty, now, kStep);
    }
  }
  RobotBody body;
  RobotPlace place = OpenPlace();
  Duration now{};
};

TEST(RobotBody, KeepsItsLimitsAtEachStepWhateverIsCommanded) {
  for (const RobotSpec& spec : {GroundRobot("g", 0, 0), FlyingRobot("f", 0, 0)}) {
    SCOPED_TRACE(spec.name);
    Driven run(spec);
    transport::sim::Random random(7);
    const auto any = [&] { return static_cast<double>(random.Next() % 2001) / 100 - 10; };
    BodyVelocity last;
    for (int i = 0; i < 2000; ++i) {
      if (i % 7 == 0) run.body.Take({{any(), any(), any()}, any()}, run.now);
      run.Steps(1);
      const BodyVelocity now = run.body.velocity();
      const double dt = 0.02 + 1e-9;
      EXPECT_LE(now.linear_m_s.head<2>().norm(), spec.limits.speed_m_s + 1e-9);
      EXPECT_LE(std::abs(now.linear_m_s.z()), spec.limits.climb_m_s + 1e-9);
      EXPECT_LE(std::abs(now.turn_rad_s), spec.limits.turn_rad_s + 1e-9);
      if (!run.body.airborne() && spec.kind == RobotKind::kFlyer) {
        last = now;
        continue;
      }
      EXPECT_LE((now.linear_m_s - last.linear_m_s).head<2>().norm(),
                spec.limits.acceleration_m_s2 * dt);
      EXPECT_LE(std::abs(now.turn_rad_s - last.turn_rad_s),
                spec.limits.turn_acceleration_rad_s2 * dt);
      last = now;
    }
  }
}

TEST(RobotBody, ReachesACommandedSpeedAndIsWhereItTakesIt) {
  Driven run(GroundRobot("g", 0, 0));
  for (int i = 0; i < 100; ++i) {  // 2 s
    run.body.Take({{1, 0, 0}, 0}, run.now);
    run.Steps(1);
  }
  EXPECT_NEAR(run.body.velocity().linear_m_s.x(), 1, 1e-9);
  EXPECT_NEAR(run.body.position_m().x(), 2 - 0.5 * 0.4, 0.02);  // 0.4 s to 1 m/s at 2.5 m/s²
  EXPECT_NEAR(run.body.position_m().y(), 0, 1e-9);
  EXPECT_EQ(run.body.position_m().z(), 0);
}

TEST(RobotBody, StopsHalfASecondAfterTheLastCommandAndAFlyerHovers) {
  for (RobotSpec spec : {GroundRobot("g", 0, 0), FlyingRobot("f", 0, 0)}) {
    spec.start_m.z() = spec.kind == RobotKind::kFlyer ? 1 : 0;
    Driven run(spec);
    run.body.Take({{0.5, 0, 0}, 0.5}, run.now);
    run.Steps(25);
    EXPECT_GT(run.body.velocity().linear_m_s.norm(), 0.49) << spec.name;
    run.Steps(20);  // 0.4 s to brake
    EXPECT_EQ(run.body.velocity().linear_m_s.norm(), 0) << spec.name;
    EXPECT_EQ(run.body.velocity().turn_rad_s, 0) << spec.name;
    const Vector3d at = run.body.position_m();
    run.Steps(50);
    EXPECT_EQ(run.body.position_m(), at) << spec.name;
    EXPECT_EQ(at.z(), spec.start_m.z()) << spec.name;
  }
}

TEST(RobotBody, ThatIsDifferentialNeverMovesAside) {
  RobotSpec spec = GroundRobot("g", 0, 0);
  spec.kind = RobotKind::kDifferential;
  Driven run(spec);
  for (int i = 0; i < 50; ++i) {
    run.body.Take({{0, 1, 0}, 0}, run.now);
    run.Steps(1);
  }
  EXPECT_EQ(run.body.position_m(), Vector3d(0, 0, 0));
}

TEST(RobotBody, RefusesAVelocityThatIsNoNumberAndKeepsTheLastOne) {
  Driven run(GroundRobot("g", 0, 0));
  ASSERT_FALSE(run.body.Take({{1, 0, 0}, 0}, run.now));
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(run.body.Take({{0, bad, 0}, 0}, run.now));
    EXPECT_TRUE(run.body.Take({{0, 0, 0}, bad}, run.now));
  }
  run.Steps(20);
  EXPECT_GT(run.body.velocity().linear_m_s.x(), 0.9);
}

TEST(RobotBody, StaysWhereItIsBeforeAnObstacleAndNamesIt) {
  Driven run(GroundRobot("g", 0, 0));
  run.place.obstacle = [](const Vector3d&, const Vector3d& to) {
    return to.x() > 0.5 ? std::optional<std::string>("wall") : std::nullopt;
  };
  for (int i = 0; i < 100; ++i) {
    run.body.Take({{1, 0, 0}, 0}, run.now);
    run.Steps(1);
    ASSERT_LE(run.body.position_m().x(), 0.5);
  }
  EXPECT_GT(run.body.position_m().x(), 0.45);
  EXPECT_EQ(run.body.stopped_by(), "wall");
  EXPECT_EQ(run.body.velocity().linear_m_s.norm(), 0);
}

TEST(RobotBody, TakesOffAndLandsAndDoesNotSlideOnTheGround) {
  Driven run(FlyingRobot("f", 0, 0));
  const auto fly = [&](const BodyVelocity& velocity, int steps) {
    for (int i = 0; i < steps; ++i) {
      run.body.Take(velocity, run.now);
      run.Steps(1);
    }
  };
  fly({{1, 0, 0}, 0}, 50);
  EXPECT_FALSE(run.body.airborne());
  EXPECT_EQ(run.body.position_m(), Vector3d(0, 0, 0));
  fly({{0, 0, 0.5}, 0}, 100);
  EXPECT_TRUE(run.body.airborne());
  EXPECT_NEAR(run.body.position_m().z(), 1 - 0.5 * 0.1, 0.02);
  fly({{0, 0, -0.5}, 0}, 200);
  EXPECT_FALSE(run.body.airborne());
  EXPECT_EQ(run.body.position_m().z(), 0);
}

TEST(RobotBody, SinksToTheGroundWithAnEmptyBattery) {
  RobotSpec spec = FlyingRobot("f", 0, 0);
  spec.start_m.z() = 1;
  Driven run(spec);
  for (int i = 0; i < 150; ++i) {
    run.body.Take({{0, 0, 1}, 0}, run.now);
    run.Steps(1, true);
  }
  EXPECT_EQ(run.body.position_m().z(), 0);
  EXPECT_FALSE(run.body.airborne());
}

TEST(RobotBody, IsPushedByTheSameGustsFromTheSameSeedAndOnlyInTheAir) {
  RobotSpec spec = FlyingRobot("f", 0, 0);
  spec.wind.drift_m_s = 0.2;
  const auto after = [&](std::uint64_t seed, double height) {
    spec.start_m.z() = height;
    Driven run(spec, seed);
    run.Steps(500);
    return run.body.position_m();
  };
  EXPECT_EQ(after(1, 1), after(1, 1));
  EXPECT_NE(after(1, 1), after(2, 1));
  EXPECT_GT((after(1, 1) - Vector3d(0, 0, 1)).norm(), 0.01);
  EXPECT_LT((after(1, 1) - Vector3d(0, 0, 1)).norm(), 0.2 * 10 * 3);
  EXPECT_EQ(after(1, 0), Vector3d(0, 0, 0));
}

}  // namespace musher::world::robot_body_test
