// Drives of one robot with random maps, paths, localisations and sensor faults: it touches nothing
// that its scan sees, and every drive ends.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "musher/modules/navigation/controller_server/path_drive.hpp"
#include "musher/navigation/planner/planner.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/test/navigation/scanned_body.hpp"

namespace musher::navigation::testing::path_drive_property_test {

using Map = std::shared_ptr<const Clearance>;

struct Outcome {
  bool ended = false;
  double seconds = 0;
  double least_room_m = 1;
  double planned_s = 0;
  std::string reason;
};

class RandomDrive {
 public:
  explicit RandomDrive(std::uint64_t seed)
      : random_(seed),
        walls_(Fenced(RandomBoxes(seed, 9, 0.05, 0.03 + 0.1 * Share()))),
        body_(walls_, {FreePlace(walls_, 0.35, random_), 2 * M_PI * Share()}, {}),
        drive_(Robot(), {}) {}

  Outcome Run() {
    Outcome outcome;
    ChooseMap();
    Sense(true);
    const auto refused = drive_.Start(ChoosePath(), now_);
    if (refused) {
      outcome.ended = true;
      outcome.reason = refused->reason;
      return outcome;
    }
    outcome.planned_s = ToSeconds(drive_.trajectory().duration());
    const double longest_s = 3 * outcome.planned_s + 120;
    for (; outcome.seconds < longest_s && !outcome.ended; outcome.seconds += kStepS, ++steps_) {
      now_ += FromSeconds(kStepS);
      if (OneIn(200)) InjectFault();
      Sense(false);
      const PathDrive::Step step = drive_.Update(now_);
      body_.Move(stuck_ ? Velocity{} : step.command, kStepS);
      outcome.least_room_m = std::min(outcome.least_room_m, body_.room_m());
      outcome.ended = step.end.has_value();
      if (step.end) outcome.reason = step.end->reason;
    }
    for (int i = 0; i < 60; ++i) body_.Move({}, kStepS);  // it rolls out
    outcome.least_room_m = std::min(outcome.least_room_m, body_.room_m());
    return outcome;
  }

 private:
  static constexpr double kStepS = 1.0 / 60;

  static ControllerRobot Robot() {
    ControllerRobot robot;
    robot.name = "r";
    robot.odometry = "r/odom";
    robot.scanners = {{.topic = "r/scan"}};
    robot.lag_s = 0.1;
    robot.gate.reaction_s += robot.lag_s;
    return robot;
  }

  double Share() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  double Between(double least, double most) { return least + (most - least) * Share(); }
  bool OneIn(int count) { return random_() % static_cast<std::uint64_t>(count) == 0; }

  // The true one, none, or any other.
  void ChooseMap() {
    if (OneIn(3)) return drive_.SetMap(nullptr, now_);
    drive_.SetMap(
        OneIn(2) ? std::make_shared<const Clearance>(walls_.map())
                 : std::make_shared<const Clearance>(Fenced(RandomBoxes(random_(), 9, 0.05, 0.1))),
        now_);
  }

  // Planned by the true map or by an empty one, or straight through everything.
  Path ChoosePath() {
    const Pose goal{FreePlace(walls_, 0.35, random_), 2 * M_PI * Share()};
    const CellMap map = OneIn(2) ? walls_.map() : Fenced(RandomBoxes(random_(), 9, 0.05, 0));
    const auto planner = Planner::Make(map, {});
    auto plan = planner ? planner.value().Find(body_.pose(), goal) : planner.error();
    if (plan && !OneIn(4)) return plan.value().path;
    return {body_.pose(), goal};
  }

  void InjectFault() {
    switch (random_() % 8) {
      case 0:
        off_ = {Between(-1, 1), Between(-1, 1), 0};
        break;
      case 1:
        frozen_ = body_.pose();
        break;
      case 2:
        odometry_from_ = now_ + FromSeconds(Between(0, 2));
        break;
      case 3:
        scan_from_ = now_ + FromSeconds(Between(0, 2));
        break;
      case 4:
        stuck_ = OneIn(2);
        break;
      case 5:
        ChooseMap();
        break;
      case 6:
        off_.x_m += Between(-0.3, 0.3);  // a correction
        break;
      default:
        frozen_.reset();
        off_ = {};
    }
  }

  void Sense(bool all) {
    if (all || (steps_ % 2 == 0 && now_ >= odometry_from_)) {
      Pose believed = frozen_.value_or(body_.pose());
      believed.at.x_m += off_.x_m;
      believed.at.y_m += off_.y_m;
      const Velocity velocity = InBodyFrame(body_.velocity(), -believed.yaw_rad);
      drive_.OnOdometry({believed, velocity}, now_.time_since_epoch(), now_);
    }
    if (all || (steps_ % 6 == 0 && now_ >= scan_from_)) {
      drive_.OnScan(0, body_.Look(random_), now_.time_since_epoch(), now_);
    }
  }

  std::mt19937_64 random_;
  Clearance walls_;
  ScannedBody body_;
  PathDrive drive_;
  Time now_ = Time{} + std::chrono::seconds(10);
  Time odometry_from_{}, scan_from_{};
  Point off_;
  std::optional<Pose> frozen_;
  bool stuck_ = false;
  int steps_ = 0;
};

// Of a drive in open space: the largest changes of its commands in a second, until its end.
struct Changes {
  double linear_m_s2 = 0;
  double yaw_rad_s2 = 0;
  double passed_m = 0;  // beyond the goal, and beside it
  bool arrived = false;
};

// A random path is driven with a known lag, exact odometry or one with noise, limits of the speed
// that come and go, and paths that replace it.
Changes ChangesOf(std::uint64_t seed) {
  constexpr double kStepS = 1.0 / 60;
  std::mt19937_64 random(seed);
  const auto between = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  const auto one_in = [&](int count) { return random() % static_cast<std::uint64_t>(count) == 0; };
  const Clearance open(Fenced(RandomBoxes(seed, 60, 0.5, 0)));
  ControllerRobot robot;
  robot.name = "r";
  robot.odometry = "r/odom";
  robot.differential = seed % 2 == 0;
  robot.lag_s = seed % 3 == 0 ? 0 : between(0.02, 0.2);
  robot.limits.acceleration_m_s2 = between(0.8, 2);
  robot.limits.yaw_rad_s2 = between(1, 3);
  const double noise_m_s = one_in(2) ? 0 : 0.05;
  ScannedBodyOptions options;
  options.lag_s = robot.lag_s;
  options.acceleration_m_s2 = 10;
  ScannedBody body(open, {{30, 30, 0}, between(-3, 3)}, options);
  PathDrive drive(robot, {});
  Time now = Time{} + std::chrono::seconds(10);
  const auto sense = [&] {
    Velocity velocity = InBodyFrame(body.velocity(), -body.pose().yaw_rad);
    velocity.x_m_s += between(-noise_m_s, noise_m_s);
    velocity.y_m_s += between(-noise_m_s, noise_m_s);
    drive.OnOdometry({body.pose(), velocity}, now.time_since_epoch(), now);
  };
  const auto any_path = [&] {
    Path path = {body.pose()};
    for (int i = 0; i < 3; ++i) {
      const Point& last = path.back().at;
      path.push_back({{std::clamp(last.x_m + between(-4, 4), 5.0, 55.0),
                       std::clamp(last.y_m + between(-4, 4), 5.0, 55.0), 0},
                      between(-3, 3)});
    }
    return path;
  };
  Changes changes;
  sense();
  Path path = any_path();
  EXPECT_FALSE(drive.Start(path, now));
  Velocity last;
  double last_yaw_rad = body.pose().yaw_rad;
  for (int step = 0; step < 60 * 120; ++step) {
    now += FromSeconds(kStepS);
    if (step % 2 == 0 || !robot.differential) sense();
    if (one_in(150)) drive.LimitSpeed(one_in(2) ? between(0.1, 1.2) : HUGE_VAL);
    if (step < 60 * 40 && one_in(250)) {
      path = any_path();
      EXPECT_FALSE(drive.Start(path, now));
    }
    const PathDrive::Step result = drive.Update(now);
    if (result.end) {
      changes.arrived = result.end->error_code == FollowCode::kNone;
      if (!changes.arrived) ADD_FAILURE() << "seed " << seed << ": " << result.end->reason;
      break;
    }
    const double yaw_rad = body.pose().yaw_rad;
    const Velocity a = robot.differential ? last : InBodyFrame(last, -last_yaw_rad);
    const Velocity b = robot.differential ? result.command : InBodyFrame(result.command, -yaw_rad);
    changes.linear_m_s2 =
        std::max(changes.linear_m_s2, std::hypot(b.x_m_s - a.x_m_s, b.y_m_s - a.y_m_s) / kStepS);
    changes.yaw_rad_s2 = std::max(changes.yaw_rad_s2, std::abs(b.yaw_rad_s - a.yaw_rad_s) / kStepS);
    last = result.command;
    last_yaw_rad = yaw_rad;
    body.Move(result.command, kStepS);
  }
  changes.linear_m_s2 /= robot.limits.acceleration_m_s2;
  changes.yaw_rad_s2 /= robot.limits.yaw_rad_s2;
  for (int i = 0; i < 60; ++i) body.Move({}, kStepS);
  changes.passed_m = Distance(body.pose().at, path.back().at);
  return changes;
}

void ExpectCommandsWithinLimits(std::uint64_t from, std::uint64_t to) {
  for (std::uint64_t seed = from; seed < to; ++seed) {
    const Changes changes = ChangesOf(seed);
    EXPECT_TRUE(changes.arrived) << "seed " << seed;
    EXPECT_LT(changes.linear_m_s2, 1.1) << "of its limit, seed " << seed;
    EXPECT_LT(changes.yaw_rad_s2, 1.01) << "of its limit, seed " << seed;
    EXPECT_LT(changes.passed_m, 0.35) << "seed " << seed;
  }
}

TEST(RandomCommands, StayWithinTheAccelerationsAlsoWithALagAndNewPaths) {
  ExpectCommandsWithinLimits(1, 25);
}

TEST(RandomCommandsNightly, StayWithinTheAccelerationsAlsoWithALagAndNewPaths) {
  ExpectCommandsWithinLimits(1000, 1300);
}

// How many of them have arrived.
int ExpectEnds(std::uint64_t from, std::uint64_t to) {
  int arrived = 0;
  for (std::uint64_t seed = from; seed < to; ++seed) {
    const Outcome outcome = RandomDrive(seed).Run();
    EXPECT_TRUE(outcome.ended) << "seed " << seed << " of " << outcome.planned_s << " s";
    EXPECT_GT(outcome.least_room_m, 0) << "seed " << seed << ": " << outcome.reason;
    arrived += outcome.ended && outcome.reason.empty();
  }
  return arrived;
}

TEST(RandomDrives, TouchNothingThatTheirScanSeesAndEnd) {
  EXPECT_GT(ExpectEnds(1, 13), 0) << "some arrive";
}

TEST(RandomDrivesNightly, TouchNothingThatTheirScanSeesAndEnd) {
  ExpectEnds(1000, 3000);
}

}  // namespace musher::navigation::testing::path_drive_property_test
