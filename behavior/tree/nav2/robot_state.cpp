// The conditions of nav2 on the robot itself: its motion, its battery, its transforms.

#include <cmath>

#include "musher/behavior/tree/nav2/checked.hpp"
#include "musher/behavior/tree/nav2/recent_tick.hpp"
#include "musher/behavior/tree/nav2/register.hpp"

namespace musher::tree::nav2 {
namespace {

// RUNNING while it stands, but not for long enough.
class IsStopped : public Condition {
 public:
  IsStopped(Setup& setup, const Robot& robot)
      : threshold_(setup.Input<double>("velocity_threshold", 0.01,
                                       "m/s and rad/s; it is slower where it stands")),
        duration_ms_(setup.Input<double>("duration_stopped", 1000.0, "ms; for so long")),
        robot_(robot) {}

 private:
  Status Evaluate(const Tick& tick) override {
    const double threshold = Checked(threshold_);
    const double duration_ms = Checked(duration_ms_);
    if (recent_.Begins(tick, status())) since_.reset();
    const std::optional<Motion> motion = robot_.motion();
    const bool stands =
        motion && motion->speed_m_s < threshold && std::abs(motion->turn_rad_s) < threshold;
    if (!stands) {
      since_.reset();
      return Status::kFailure;
    }
    if (!since_) since_ = tick.now;
    const double stood_ms = 1000 * ToSeconds(tick.now - *since_);
    return stood_ms >= duration_ms ? Status::kSuccess : Status::kRunning;
  }

  InPort<double> threshold_;
  InPort<double> duration_ms_;
  const Robot& robot_;
  RecentTick recent_;
  std::optional<Time> since_;
};

// While a task moves the base. A robot that waits before an obstacle is stuck, too.
class IsStuck : public Condition {
 public:
  IsStuck(Setup&, const Robot& robot) : robot_(robot) {}

 private:
  static constexpr double kPlaceM = 0.1;
  static constexpr double kPlaceRad = 0.2;
  static constexpr Duration kStuckAfter = std::chrono::seconds(3);

  Status Evaluate(const Tick& tick) override {
    if (recent_.Begins(tick, status())) place_.reset();
    const std::optional<Pose> pose = robot_.IsDriven() ? robot_.pose() : std::nullopt;
    if (!pose) {
      place_.reset();
      return Status::kFailure;
    }
    const bool is_there =
        place_ && Apart(robot_, *place_, *pose) < kPlaceM &&
        std::abs(std::remainder(pose->yaw_rad - place_->yaw_rad, 2 * M_PI)) < kPlaceRad;
    if (!is_there) {
      place_ = *pose;
      since_ = tick.now;
    }
    return StatusOf(tick.now - since_ >= kStuckAfter);
  }

  const Robot& robot_;
  RecentTick recent_;
  std::optional<Pose> place_;
  Time since_{};  // there
};

class IsBatteryLow : public Condition {
 public:
  IsBatteryLow(Setup& setup, const Robot& robot)
      : least_(setup.Input<double>("min_battery", "0 to 1; with `is_voltage` V")),
        topic_(setup.OptionalInput<std::string>("battery_topic", "else that of the robot")),
        by_voltage_(setup.Input<bool>("is_voltage", false, "true: its voltage counts")),
        robot_(robot) {}

 private:
  Status Evaluate(const Tick&) override {
    const double least = Checked(least_);
    const std::optional<Battery> battery = robot_.battery(topic_.Or(""));
    if (!battery) return Status::kFailure;
    const std::optional<double> level = by_voltage_.Get() ? battery->voltage_v : battery->share;
    return StatusOf(level && *level <= least);
  }

  InPort<double> least_;
  InPort<std::string> topic_;
  InPort<bool> by_voltage_;
  const Robot& robot_;
};

class BatteryCharge : public Condition {
 public:
  BatteryCharge(Setup& setup, const Robot& robot)
      : topic_(setup.OptionalInput<std::string>("battery_topic", "else that of the robot")),
        robot_(robot) {}

 private:
  Status Evaluate(const Tick&) override {
    const std::optional<Battery> battery = robot_.battery(topic_.Or(""));
    return StatusOf(battery && battery->charges);
  }

  InPort<std::string> topic_;
  const Robot& robot_;
};

// Once it was, it always is.
class TransformAvailable : public Condition {
 public:
  TransformAvailable(Setup& setup, const Robot& robot)
      : child_(setup.Input<std::string>("child", "a frame")),
        parent_(setup.Input<std::string>("parent", "the frame in which it lies")),
        robot_(robot) {}

 private:
  Status Evaluate(const Tick&) override {
    if (!found_) found_ = robot_.HasTransform(parent_.Get(), child_.Get());
    return StatusOf(found_);
  }

  InPort<std::string> child_;
  InPort<std::string> parent_;
  const Robot& robot_;
  bool found_ = false;
};

}  // namespace

void AddStateNodes(Factory& factory, Robot& robot) {
  constexpr NodeKind kKind = NodeKind::kCondition;
  const std::string stopped =
      "SUCCESS where the robot has stood for so long, RUNNING where it stands, else FAILURE; also "
      "where its motion is not known.";
  AddNode<IsStopped>(factory, "IsStopped", kKind, true, stopped, robot);
  AddNode<IsStopped>(factory, "CheckStopStatus", NodeKind::kAction, true, stopped, robot);
  AddNode<IsStuck>(factory, "IsStuck", kKind, false,
                   "SUCCESS where the base is driven, and the robot has not come 0.1 m and not "
                   "turned 0.2 rad for 3 s in which it was ticked.",
                   robot);
  AddNode<IsBatteryLow>(factory, "IsBatteryLow", kKind, false,
                        "SUCCESS where the level of the battery is not above the least one. "
                        "FAILURE also where it is not known.",
                        robot);
  AddNode<BatteryCharge>(factory, "IsBatteryCharging", kKind, false,
                         "SUCCESS where the battery is charged.", robot);
  AddNode<TransformAvailable>(factory, "TransformAvailable", kKind, false,
                              "SUCCESS once it was known where a frame lies in another one.",
                              robot);
}

}  // namespace musher::tree::nav2
