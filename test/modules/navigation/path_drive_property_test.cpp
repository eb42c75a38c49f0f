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
