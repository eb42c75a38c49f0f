#include "musher/modules/world/sensors/sensing.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "musher/test/modules/world/scenes.hpp"

namespace musher::world::sensing_test {

using ::testing::Each;
using ::testing::SizeIs;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A wall across, its face at x = `x_m`.
Box WallAt(double x_m) {
  Box wall;
  wall.center_m = {x_m + 0.5, 0};
  wall.half_m = {0.5, 9};
  return wall;
}

Scene Precise() {
  Scene scene = EmptyYard();
  for (Reach* reach :
       {&scene.sensors.lidar.reach, &scene.sensors.ultrasonic.reach, &scene.sensors.tof.reach}) {
    reach->noise_m = 0;
  }
  scene.sensors.gps.noise_m = 0;
  return scene;
}

TEST(Sensing, ScansAWallAheadAtTheDistanceOfEachAngle) {
  Scene scene = Precise();
  scene.boxes = {WallAt(3)};
  const msg::LaserScan scan = MeasureScan(World(scene));
  ASSERT_THAT(scan.ranges, SizeIs(361));
  const double lidar_x = scene.sensors.lidar.mount.position_m.x();
  for (const std::size_t ray : {100u, 180u, 250u}) {
    const double angle = scan.angle_min + static_cast<double>(ray) * scan.angle_increment;
    EXPECT_NEAR(scan.ranges[ray], (3 - lidar_x) / std::cos(angle), 1e-4) << ray;
  }
  EXPECT_NEAR(scan.angle_min + 360 * scan.angle_increment, scan.angle_max, 1e-5);
}

TEST(Sensing, TurnsWithTheBodySoThatWhatIsLeftIsAtPositiveAngles) {
  Scene scene = Precise();
  scene.start.yaw_rad = M_PI / 2;  // its left is -x
  scene.circles = {Circle{"", {-2, 0}, 0.3}};
  const msg::LaserScan scan = MeasureScan(World(scene));
  const auto nearest = std::min_element(scan.ranges.begin(), scan.ranges.end());
  const double angle =
      scan.angle_min + static_cast<double>(nearest - scan.ranges.begin()) * scan.angle_increment;
  EXPECT_GT(angle, 1.2);
  EXPECT_NEAR(*nearest, 1.7, 0.05);
}

TEST(Sensing, ReadsInfinityWhereNothingIsAndMinusInfinityWhereItIsTooNear) {
  Scene scene = Precise();
  scene.fence_height_m = 0;
  EXPECT_THAT(MeasureScan(World(scene)).ranges, Each(kInfinity));
  EXPECT_EQ(MeasureUltrasonic(World(scene)).range, kInfinity);
  scene.boxes = {WallAt(0.3)};
  EXPECT_EQ(MeasureUltrasonic(World(scene)).range, -kInfinity);
}

TEST(Sensing, MeasuresTheNearestThingInItsCone) {
  Scene scene = Precise();
  const double front = scene.sensors.ultrasonic.mount.position_m.x();
  scene.boxes = {WallAt(front + 0.7)};
  EXPECT_NEAR(MeasureUltrasonic(World(scene)).range, 0.7, 0.002);
  // A thin post beside the axis, inside of the cone and outside of it.
  scene.boxes.clear();
  scene.circles = {Circle{"", {front + 0.6, 0.1}, 0.05}};
  EXPECT_NEAR(MeasureUltrasonic(World(scene)).range, 0.57, 0.03);
  scene.circles = {Circle{"", {front + 0.6, 0.3}, 0.05}};
  EXPECT_EQ(MeasureUltrasonic(World(scene)).range, kInfinity);
}

TEST(Sensing, MeasuresTheGroundBeforeItsFeetInMillimetres) {
  const Scene scene = Precise();
  for (std::size_t position = 0; position < kTofNames.size(); ++position) {
    const msg::SingleTofPayload tof = MeasureTof(World(scene), position);
    ASSERT_THAT(tof.data, SizeIs(msg::SingleTofPayload::kZones));
    ASSERT_THAT(tof.intensity, SizeIs(msg::SingleTofPayload::kZones));
    EXPECT_EQ(tof.tof_position, position);
    EXPECT_TRUE(tof.data_available);
    const double height = scene.body.stand_height_m + scene.sensors.tof.up_m;
    const double down = scene.sensors.tof.down_rad + scene.sensors.tof.view_rad * (7.5 / 8 - 0.5);
    // Straight below the middle of the view; an own zone is a little aside of it.
    EXPECT_NEAR(tof.data[7 * 8 + 3], height / std::sin(down), 0.01);
    for (const float zone : tof.data) {
      if (std::isinf(zone)) continue;
      EXPECT_NEAR(std::remainder(static_cast<double>(zone), 0.001), 0, 1e-7);
    }
  }
}

TEST(Sensing, SeesWithEachTofWhatIsOnItsOwnSide) {
  Scene scene = Precise();
  const auto nearest = [&](std::size_t position) {
    const std::vector<float> data = MeasureTof(World(scene), position).data;
    return *std::min_element(data.begin(), data.end());
  };
  const std::vector<double> bare = {nearest(0), nearest(1), nearest(2), nearest(3)};
  scene.circles = {Circle{"", {0.45, 0.18}, 0.05}};  // ahead on the left
  EXPECT_LT(nearest(0), bare[0] - 0.1);
  EXPECT_DOUBLE_EQ(nearest(2), bare[2]);
  EXPECT_DOUBLE_EQ(nearest(3), bare[3]);
  scene.circles = {Circle{"", {-0.45, -0.18}, 0.05}};  // behind on the right
  EXPECT_DOUBLE_EQ(nearest(0), bare[0]);
  EXPECT_LT(nearest(3), bare[3] - 0.1);
}

TEST(Sensing, ReportsItsPositionOnTheEarth) {
  Scene scene = Precise();
  scene.sensors.gps.latitude_deg = 60;
  scene.sensors.gps.longitude_deg = 179.99999;
  scene.start.position_m = {5, 3};
  const msg::NavSatFix fix = MeasureFix(World(scene));
  constexpr double kMetresOfADegree = 111'319.49;
  EXPECT_NEAR((fix.latitude - 60) * kMetresOfADegree, 3, 1e-3);
  // Half as wide there as at the equator, and across the date line.
  EXPECT_NEAR((fix.longitude + 180.00001) * kMetresOfADegree / 2, 5, 1e-2);
  EXPECT_NEAR(fix.altitude, 45.29, 1e-9);
  EXPECT_EQ(fix.status.status, msg::NavSatStatus::kFix);
  scene.sensors.gps.fix = GpsSpec::Fix::kNone;
  const msg::NavSatFix none = MeasureFix(World(scene));
  EXPECT_EQ(none.status.status, msg::NavSatStatus::kNoFix);
  EXPECT_TRUE(std::isnan(none.latitude));
}

TEST(Sensing, CountsTheSatellitesOfAFix) {
  Scene scene = EmptyYard();
  scene.sensors.gps.satellites = 12;
  EXPECT_EQ(CountSatellites(World(scene)).data, 12);
  scene.sensors.gps.fix = GpsSpec::Fix::kNone;
  EXPECT_EQ(CountSatellites(World(scene)).data, 0);
}

TEST(Sensing, MeasuresHowFarAndInWhichDirectionTheTagIs) {
  Scene scene = EmptyYard();
  scene.sensors.uwb.noise_m = 0;
  scene.sensors.uwb.noise_rad = 0;
  scene.start = {{1, 1}, M_PI / 2};  // looks along y
  scene.sensors.uwb.tag_m = {-2, 1};
  const auto left = MeasureTag(World(scene));
  ASSERT_TRUE(left);
  EXPECT_NEAR(left->dist, 3, 1e-5);
  EXPECT_NEAR(left->angle, M_PI / 2, 1e-5) << "left is positive";
  EXPECT_EQ(left->n_los, 0);
  scene.sensors.uwb.tag_m = {1, -1};
  const auto behind = MeasureTag(World(scene));
  ASSERT_TRUE(behind);
  EXPECT_NEAR(std::abs(behind->angle), M_PI, 1e-5);
  EXPECT_GT(behind->rssi_1, left->rssi_1) << "it is nearer";
  scene.sensors.uwb.most_m = 1;
  EXPECT_FALSE(MeasureTag(World(scene))) << "too far";
}

TEST(Sensing, ReportsThatTheTagIsBehindAnObstacle) {
  Scene scene = EmptyYard();
  scene.boxes = {WallAt(3)};
  scene.sensors.uwb.tag_m = {5, 0};
  const auto hidden = MeasureTag(World(scene));
  ASSERT_TRUE(hidden);
  EXPECT_EQ(hidden->n_los, 1);
  scene.boxes.clear();
  const auto seen = MeasureTag(World(scene));
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->n_los, 0);
  EXPECT_GT(seen->rssi_1, hidden->rssi_1);
}

TEST(Sensing, HasTheNoiseOfTheScene) {
  Scene scene = EmptyYard();
  scene.sensors.lidar.reach.noise_m = 0.02;
  scene.boxes = {WallAt(3)};
  World world(scene);
  double squares = 0;
  double sum = 0;
  constexpr int kScans = 2000;
  for (int i = 0; i < kScans; ++i) {
    world.Step();
    const double off = MeasureScan(world).ranges[180] - 2.84;
    sum += off;
    squares += off * off;
  }
  EXPECT_NEAR(sum / kScans, 0, 0.002);
  EXPECT_NEAR(std::sqrt(squares / kScans), 0.02, 0.002);
}

TEST(Sensing, IsTheSameFromTheSameSeedAndLeavesTheBodysRandomGeneratorAlone) {
  const Scene scene = FullYard();
  World listened(scene);
  World alone(scene);
  Commander walking(listened);
  Commander also(alone);
  for (int i = 0; i < 20; ++i) {
    walking.Walk({0.4, 0, 0.2}, Milliseconds(200));
    also.Walk({0.4, 0, 0.2}, Milliseconds(200));
    MeasureScan(listened);
    MeasureTof(listened, 2);
  }
  EXPECT_EQ(listened.body().pose(), alone.body().pose());
  EXPECT_EQ(MeasureScan(listened), MeasureScan(alone));
  EXPECT_EQ(MeasureTof(listened, 1).data, MeasureTof(alone, 1).data);
  EXPECT_EQ(MeasureFix(listened), MeasureFix(alone));
  Scene other = scene;
  other.seed = 2;
  EXPECT_NE(MeasureScan(World(scene)).ranges, MeasureScan(World(other)).ranges);
}

}  // namespace musher::world::sensing_test
