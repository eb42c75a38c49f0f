// The course of the repository can be driven: a driver that knows its true pose reaches all zones
// with no foot on a line. It also shows that the zones, lines and gaps fit the robot.

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/modules/world/simulation/referee_report.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::course_drive_test {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;

constexpr double kSouth = -M_PI / 2;
constexpr double kWest = M_PI;
constexpr double kCrossA = -1.80;
constexpr double kS1 = -0.40;
constexpr double kS2X = 5.03;
constexpr double kS2Y = 0.743;
constexpr double kQrBX = 12.83;

class Driver {
 public:
  explicit Driver(World& world) : world_(world), commander_(world) {}

  // Straight there, turning on the way.
  void Go(double x, double y, double yaw_rad) {
    for (int i = 0; i < 3000; ++i) {
      const Pose2& pose = world_.body().pose();
      const Vector2d away = Vector2d(x, y) - pose.position_m;
      const double turn = std::remainder(yaw_rad - pose.yaw_rad, 2 * M_PI);
      if (away.norm() < 0.015 && std::abs(turn) < 0.015) return;
      const double speed = std::min(0.4, 1.5 * away.norm());
      const Vector2d along = Rotation2Dd(-pose.yaw_rad) * Vector2d(away.normalized() * speed);
      const double turn_rate = std::clamp(2 * turn, -0.6, 0.6);
      commander_.Walk({along.x(), along.y(), turn_rate}, kStep);
    }
    ADD_FAILURE() << "the driver does not reach (" << x << ", " << y << ")";
  }
  void Lie() { Rest(7, 1); }
  void Stand() { Rest(12, 0); }

 private:
  void Rest(int mode, int gait) {
    EXPECT_EQ(commander_.Do(mode, gait), std::nullopt);
    Pass(world_, Seconds(4));
  }

  World& world_;
  Commander commander_;
};

// The middle of the S lane: two arcs of 50 degrees.
void DriveS(Driver& driver, bool back) {
  std::vector<Pose2> points = {{{1.7, kS1}, 0}};
  for (double turned = 0.1; turned < 0.87; turned += 0.1) {
    points.push_back(
        {Vector2d(1.7, 1.2) + 1.6 * Vector2d(std::sin(turned), -std::cos(turned)), turned});
  }
  for (double turned = 0.8; turned > 0.05; turned -= 0.1) {
    points.push_back(
        {Vector2d(4.1513, -0.857) + 1.6 * Vector2d(-std::sin(turned), std::cos(turned)), turned});
  }
  points.push_back({{4.3, kS2Y}, 0});
  if (back) std::reverse(points.begin(), points.end());
  for (const Pose2& point : points) {
    driver.Go(point.position_m.x(), point.position_m.y(), point.yaw_rad + (back ? kWest : 0));
  }
}

// From lane Q into a bay of A, and back into lane Q.
void VisitBayA(Driver& driver, const std::string& bay) {
  const double x = bay == "A1" ? -1.23 : 1.23;
  driver.Go(0, kCrossA, kSouth);
  driver.Go(x, kCrossA, kSouth);
  driver.Go(x, -1.28, kSouth);
  driver.Lie();
  driver.Stand();
  driver.Go(x, kCrossA, kSouth);
  driver.Go(0, kCrossA, kSouth);
}

void VisitBayB(Driver& driver, const std::string& bay) {
  const double y = kS2Y + (bay == "B1" ? 1.42 : -1.42);
  driver.Go(kQrBX, y, 0);
  driver.Go(kQrBX + 0.8, y, 0);
  driver.Lie();
  driver.Stand();
}

double LaneY(const std::string& lane) {
  return kS2Y + (lane == "L1" ? 1.3 : -1.3);
}

void Drive(const std::vector<std::string>& order, Driver& driver) {
  driver.Stand();
  driver.Go(0, 0, 0);
  driver.Go(0, 0, kSouth);
  VisitBayA(driver, order.at(2));
  driver.Go(0, kS1, kSouth);
  driver.Go(0, kS1, 0);
  DriveS(driver, false);
  driver.Go(kS2X, kS2Y, 0);
  driver.Go(kS2X, LaneY(order.at(5)), 0);
  driver.Go(kQrBX, LaneY(order.at(5)), 0);
  driver.Go(kQrBX, kS2Y, 0);
  VisitBayB(driver, order.at(7));
  driver.Go(kQrBX, kS2Y + (order.at(7) == "B1" ? 1.42 : -1.42), 0);
  VisitBayB(driver, order.at(8));
  const double last_y = kS2Y + (order.at(8) == "B1" ? 1.42 : -1.42);
  driver.Go(kQrBX + 0.8, last_y, kWest);
  driver.Go(kQrBX, last_y, kWest);
  driver.Go(kQrBX, LaneY(order.at(9)), kWest);
  driver.Go(kS2X, LaneY(order.at(9)), kWest);
  driver.Go(kS2X, kS2Y, kWest);
  DriveS(driver, true);
  driver.Go(0, kS1, kWest);
  driver.Go(0, kS1, kSouth);
  VisitBayA(driver, order.at(12));
  driver.Go(0, 0, kSouth);
  driver.Go(0, 0, 0);
  driver.Go(-0.83, 0, 0);
  driver.Lie();
}

// Of the eight choices four, among which every value meets every other.
TEST(CourseDrive, ReachesAllZonesInOrderWithNoFootOnALineInEveryRun) {
  constexpr std::array<std::array<const char*, 3>, 4> kChoices = {{{"A-1", "left", "B-1"},
                                                                   {"A-1", "right", "B-2"},
                                                                   {"A-2", "left", "B-2"},
                                                                   {"A-2", "right", "B-1"}}};
  for (const auto& [qr_a, arrow, qr_b] : kChoices) {
    if (std::string_view(arrow) == "left" && !musher::testing::Nightly()) continue;
    const SceneReading reading =
        ReadSceneFile(SourceDir() + "/config/scenes/course.toml",
                      {.seed = 5, .chosen = {{"qr_a", qr_a}, {"arrow", arrow}, {"qr_b", qr_b}}});
    ASSERT_TRUE(reading.scene);
    World world(*reading.scene);
    Driver driver(world);
    Drive(reading.scene->referee.order, driver);
    const Referee& referee = world.referee();
    EXPECT_TRUE(referee.finished() && referee.touch_count() == 0 && referee.collisions() == 0)
        << RefereeText(world.scene(), referee, world.now());
  }
}

}  // namespace musher::world::course_drive_test
