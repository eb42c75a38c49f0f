// RateController, DistanceController, SpeedController, GoalUpdatedController: decorators that tick
// their child now and then, and return RUNNING in between. GoalUpdater, PathLongerOnApproach,
// SingleTrigger.
//
// Each begins from the start when it is idle: at first, after a halt, and after its parent has
// completed. PathLongerOnApproach stands in reactive controls; see recent_tick.hpp.

#include <algorithm>

#include "musher/behavior/tree/nav2/checked.hpp"
#include "musher/behavior/tree/nav2/goal_watch.hpp"
#include "musher/behavior/tree/nav2/recent_tick.hpp"
#include "musher/behavior/tree/nav2/register.hpp"

namespace musher::tree::nav2 {
namespace {

double Positive(const InPort<double>& port) {
  const double value = port.Get();
  if (!(value > 0)) throw PortError("port '" + port.name() + "' has to be above 0");
  return value;
}

double SecondsSince(Time begin, const Tick& tick) {
  return ToSeconds(tick.now - begin);
}

// Ticks its child on as long as that is RUNNING, also where a breakpoint holds it: it is idle then.
class Paced : public Decorator {
 protected:
  bool goes_on() const { return goes_on_ && status() != Status::kIdle; }
  Status Go(Tick& tick) {
    const Status status = TickChild(tick);
    goes_on_ = status == Status::kRunning;
    return status;
  }

 private:
  bool goes_on_ = false;
};

class RateController : public Paced {
 public:
  explicit RateController(Setup& setup)
      : hz_(setup.Input<double>("hz", 10.0, "how often in a second it may begin its child")) {}

 private:
  Status OnTick(Tick& tick) override {
    if (status() == Status::kIdle) since_.reset();
    const double period_s = 1 / Positive(hz_);
    const bool waits = since_ && !goes_on() && SecondsSince(*since_, tick) < period_s;
    if (waits) return Status::kRunning;
    if (!since_) since_ = tick.now;
    const Status status = Go(tick);
    if (status == Status::kSuccess) since_ = tick.now;
    return status;
  }

  InPort<double> hz_;
  std::optional<Time> since_;  // the last success of the child, at first its begin
};

class DistanceController : public Paced {
 public:
  DistanceController(Setup& setup, const Robot& robot)
      : distance_m_(setup.Input<double>("distance", 1.0, "m that the robot travels in between")),
        robot_(robot) {
    IgnoreFrames(setup);
  }

  static void IgnoreFrames(Setup& setup) {
    static_cast<void>(setup.OptionalInput<std::string>("global_frame", "ignored: the map"));
    static_cast<void>(setup.OptionalInput<std::string>("robot_base_frame", "ignored: the robot"));
  }

 private:
  Status OnTick(Tick& tick) override {
    const bool begins = status() == Status::kIdle;
    const double distance_m = Checked(distance_m_);
    const std::optional<Pose> pose = robot_.pose();
    if (!pose) {
      child().Reset(tick);
      return Status::kFailure;
    }
    if (begins) begin_ = *pose;
    const bool near = Apart(robot_, begin_, *pose) < distance_m;
    if (!begins && near && !goes_on()) return Status::kRunning;
    const Status status = Go(tick);
    if (status == Status::kSuccess) begin_ = *pose;
    return status;
  }

  InPort<double> distance_m_;
  const Robot& robot_;
  Pose begin_;
};

class SpeedController : public Paced {
 public:
  SpeedController(Setup& setup, const Robot& robot)
      : min_rate_hz_(setup.Input<double>("min_rate", 0.1, "Hz, up to min_speed")),
        max_rate_hz_(setup.Input<double>("max_rate", 1.0, "Hz, from max_speed on")),
        min_speed_m_s_(setup.Input<double>("min_speed", 0.0, "m/s")),
        max_speed_m_s_(setup.Input<double>("max_speed", 0.5, "m/s")),
        goals_(setup),
        robot_(robot) {
    static_cast<void>(setup.OptionalInput<double>("filter_duration", "ignored: s"));
  }

 private:
  Status OnTick(Tick& tick) override {
    const bool has_new_goal = goals_.HasChanged();
    const bool begins = status() == Status::kIdle || has_new_goal;
    if (begins) {
      since_ = tick.now;
      period_s_ = 1 / Positive(max_rate_hz_);
    }
    const bool is_over = SecondsSince(since_, tick) >= period_s_;
    if (!begins && !is_over && !goes_on()) return Status::kRunning;
    if (is_over) {
      since_ = tick.now;
      period_s_ = 1 / RateHz();
    }
    return Go(tick);
  }

  double RateHz() const {
    const double least_hz = Positive(min_rate_hz_);
    const double most_hz = Positive(max_rate_hz_);
    const double from = min_speed_m_s_.Get();
    const double to = max_speed_m_s_.Get();
    if (least_hz > most_hz) throw PortError("min_rate is above max_rate");
    if (!(from < to)) throw PortError("min_speed is not below max_speed");
    const double share = std::clamp((robot_.speed_m_s() - from) / (to - from), 0.0, 1.0);
    return least_hz + share * (most_hz - least_hz);
  }

  InPort<double> min_rate_hz_;
  InPort<double> max_rate_hz_;
  InPort<double> min_speed_m_s_;
  InPort<double> max_speed_m_s_;
  GoalWatch goals_;
  const Robot& robot_;
  Time since_{};
  double period_s_ = 0;
};

class GoalUpdatedController : public Paced {
 public:
  explicit GoalUpdatedController(Setup& setup) : goals_(setup) {}

 private:
  Status OnTick(Tick& tick) override {
    const bool has_new_goal = goals_.HasChanged();
    const bool begins = status() == Status::kIdle || has_new_goal;
    return begins || goes_on() ? Go(tick) : Status::kRunning;
  }

  GoalWatch goals_;
};

Time StampOf(const Pose& goal) {
  return goal.stamp;
}
Time StampOf(const Goals& goals) {
  return goals.poses.empty() ? Time{} : goals.poses.front().stamp;
}

// The goal of a port, or an update of it that is newer. A goal without a stamp can not be compared
// with: then an update counts that has come since the goal was set. Where no entry has a goal, an
// update that a run before has passed on does not count.
template <class T>
class UpdatedGoal {
 public:
  UpdatedGoal(InPort<T> commanded, OutPort<T> output)
      : commanded_(std::move(commanded)), output_(std::move(output)) {}

  void OnNewRun(const std::optional<T>& update) {
    const bool is_entry = commanded_.entry() != nullptr && commanded_.Find() != nullptr;
    if (!is_entry) known_ = passed_;
    if (is_entry && Sequence() != seen_) known_ = update;
    seen_ = Sequence();
  }
  // False: there is no goal.
  bool Pass(const std::optional<T>& update) {
    if (Sequence() != seen_) {  // a goal was set while the tree runs
      known_ = last_;
      seen_ = Sequence();
    }
    last_ = update;
    const T* commanded = commanded_.Find();
    const bool updates = update && IsNewer(*update, commanded);
    if (updates && passed_ != update) passed_ = update;
    const T* passed = updates ? &*update : commanded;
    if (passed == nullptr) return false;
    const std::uint64_t before = Sequence();
    output_.Set(*passed);
    seen_ += Sequence() - before;  // it may be the same entry
    return true;
  }

 private:
  bool IsNewer(const T& update, const T* commanded) const {
    const bool is_stamped = commanded != nullptr && StampOf(*commanded) != Time{};
    return is_stamped ? StampOf(update) >= StampOf(*commanded) : update != known_;
  }
  std::uint64_t Sequence() const {
    return commanded_.entry() != nullptr ? commanded_.entry()->sequence : 0;
  }

  InPort<T> commanded_;
  OutPort<T> output_;
  std::optional<T> known_;  // update that does not count
  std::optional<T> passed_;
  std::optional<T> last_;   // update that the last Pass() has seen
  std::uint64_t seen_ = 0;  // of the entry, without what it has set itself
};

class GoalUpdater : public Decorator, public RunObserver {
 public:
  GoalUpdater(Setup& setup, const Robot& robot)
      : goal_{setup.OptionalInput<Pose>("input_goal", "the goal as it was commanded"),
              setup.Output<Pose>("output_goal", "the goal that came last")},
        goals_{setup.OptionalInput<Goals>("input_goals", "the same of several"),
               setup.Output<Goals>("output_goals", "the same of several")},
        robot_(robot) {}

 private:
  void OnNewRun(const Tick& /*tick*/) override {
    goal_.OnNewRun(robot_.goal_update());
    goals_.OnNewRun(robot_.goals_update());
  }
  Status OnTick(Tick& tick) override {
    const bool has_goal = goal_.Pass(robot_.goal_update());
    const bool has_goals = goals_.Pass(robot_.goals_update());
    if (has_goal || has_goals) return TickChild(tick);
    child().Reset(tick);
    return Status::kFailure;
  }

  UpdatedGoal<Pose> goal_;
  UpdatedGoal<Goals> goals_;
  const Robot& robot_;
};

// The child is ticked while the path to the same goal is much longer than it was, and this goal is
// near.
class PathLongerOnApproach : public Decorator {
 public:
  explicit PathLongerOnApproach(Setup& setup)
      : path_(setup.Input<Path>("path", "the path that is followed")),
        near_m_(setup.Input<double>("prox_len", 3.0, "m of the path before: the goal is near")),
        factor_(setup.Input<double>("length_factor", 2.0, "how many times longer it has become")) {}

 private:
  Status OnTick(Tick& tick) override {
    const Path* path = path_.Find();
    const Path present = path != nullptr ? *path : Path{};
    if (recent_.Begins(tick, status())) before_ = present;
    if (!IsLonger(present)) {
      child().Reset(tick);
      before_ = present;
      return Status::kSuccess;
    }
    const Status status = TickChild(tick);
    if (IsCompleted(status)) before_ = present;
    return status;
  }

  bool IsLonger(const Path& present) const {
    if (present.poses.empty() || before_.poses.empty() || present == before_) return false;
    if (Distance(present.poses.back(), before_.poses.back()) > 0) return false;
    const double length_m = LengthOf(before_);
    return length_m < Checked(near_m_) && LengthOf(present) > Checked(factor_) * length_m;
  }

  InPort<Path> path_;
  InPort<double> near_m_;
  InPort<double> factor_;
  RecentTick recent_;
  Path before_;
};

class SingleTrigger : public Decorator {
 private:
  Status OnTick(Tick& tick) override {
    if (status() == Status::kIdle) done_ = false;
    if (done_) return Status::kFailure;
    const Status status = TickChild(tick);
    done_ = IsCompleted(status);
    return status;
  }

  bool done_ = false;
};

}  // namespace

void AddDecoratorNodes(Factory& factory, Robot& robot) {
  constexpr NodeKind kKind = NodeKind::kDecorator;
  AddNode<RateController>(factory, "RateController", kKind, true,
                          "Begins its child so often in a second; RUNNING in between.");
  AddNode<DistanceController>(factory, "DistanceController", kKind, true,
                              "Begins its child each time the robot has travelled so far; RUNNING "
                              "in between.",
                              robot);
  AddNode<SpeedController>(factory, "SpeedController", kKind, true,
                           "Begins its child the more often, the faster the robot is; RUNNING in "
                           "between.",
                           robot);
  AddNode<GoalUpdatedController>(factory, "GoalUpdatedController", kKind, true,
                                 "Begins its child at first and when the goal has changed; "
                                 "RUNNING in between.");
  AddNode<GoalUpdater>(factory, "GoalUpdater", kKind, false,
                       "Passes the goal on, or a newer one that has come on a topic; FAILURE "
                       "where there is neither.",
                       robot);
  AddNode<PathLongerOnApproach>(factory, "PathLongerOnApproach", kKind, false,
                                "Ticks its child where the path has become much longer near the "
                                "goal; else SUCCESS.");
  AddNode<SingleTrigger>(factory, "SingleTrigger", kKind, false,
                         "Ticks its child until it has ended once; FAILURE from then on.");
}

}  // namespace musher::tree::nav2
