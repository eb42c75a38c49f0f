#include "musher/modules/skills/nav2/mission_tasks.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "musher/behavior/skill/run.hpp"
#include "musher/modules/skills/skills/navigate_to.hpp"
#include "musher/modules/skills/skills/track.hpp"
#include "musher/navigation/planner/cell_map.hpp"

namespace musher::skills {
namespace {

using tree::nav2::TaskEnd;

constexpr Duration kBaseLimit = std::chrono::seconds(10);

// A task that has the base from its begin to its end.
class BaseTask : public tree::nav2::Task {
 public:
  explicit BaseTask(Handover& handover) : handover_(handover) {}
  ~BaseTask() override { handover_.Release(*this); }

  std::optional<TaskEnd> Poll(Time now) final {
    if (!since_) since_ = now;
    if (!begun_) {
      const bool driven = handover_.IsDriven();
      begun_ = !driven && handover_.Take(*this) && handover_.Stands();
      if (!begun_) {
        if (now - *since_ < kBaseLimit) return std::nullopt;
        return TaskEnd{.error = driven ? "a drive has not ended" : "the base is not free"};
      }
      last_ = now;
    }
    handover_.NoteMotion();
    std::optional<TaskEnd> end = Step(now, now - std::exchange(last_, now));
    if (end) handover_.Release(*this);
    return end;
  }

 private:
  // Since it has the base; the first one takes no time.
  virtual std::optional<TaskEnd> Step(Time now, Duration step) = 0;

  Handover& handover_;
  std::optional<Time> since_;
  bool begun_ = false;
  Time last_{};
};

// Runs of one skill, one after the other.
class SkillTask : public BaseTask {
 public:
  using Make = std::function<std::unique_ptr<skill::Skill>()>;

  SkillTask(Handover& handover, std::string name, Make make, std::vector<skill::Values> runs)
      : BaseTask(handover),
        name_(std::move(name)),
        make_(std::move(make)),
        runs_(std::move(runs)) {}
  ~SkillTask() override {
    if (run_ != nullptr && run_->running()) run_->CancelNow("its node was halted");
  }

 private:
  std::optional<TaskEnd> Step(Time /*now*/, Duration step) override {
    if (run_ == nullptr || run_->ended()) {
      run_ = std::make_unique<skill::Run>(name_, make_());
      const Result<> begun = run_->Begin(runs_[at_]);
      if (!begun) return Failed(begun.error().message);
    }
    run_->Step(step);
    if (!run_->ended()) return std::nullopt;
    if (run_->state() != skill::kSucceeded) return Failed(run_->feedback().message);
    if (++at_ < runs_.size()) return std::nullopt;
    return TaskEnd{.success = true};
  }
  TaskEnd Failed(const std::string& why) const {
    const std::string place = runs_.size() > 1 ? "place " + std::to_string(at_ + 1) + ": " : "";
    return {.error = place + why};
  }

  const std::string name_;
  const Make make_;
  const std::vector<skill::Values> runs_;
  std::size_t at_ = 0;
  std::unique_ptr<skill::Run> run_;
};

// Nothing commands the base but the person.
class TeleopTask : public BaseTask {
 public:
  TeleopTask(const Robot& robot, Handover& handover, Duration limit)
      : BaseTask(handover), robot_(robot), limit_(limit) {}

 private:
  std::optional<TaskEnd> Step(Time now, Duration /*step*/) override {
    if (!robot_.HasTeleop()) return TaskEnd{.error = robot_.name() + " has no topic for a person"};
    if (!begin_) begin_ = now;
    if (limit_ == Duration{} || now - *begin_ < limit_) return std::nullopt;
    return TaskEnd{.error_code = tree::nav2::kTeleopTimeout, .error = "its time is over"};
  }

  const Robot& robot_;
  const Duration limit_;
  std::optional<Time> begin_;
};

class PlaceCheck : public tree::nav2::Task {
 public:
  PlaceCheck(Robot& robot, tree::nav2::OccupancyRequest request)
      : robot_(robot), request_(std::move(request)) {}

  std::optional<TaskEnd> Poll(Time /*now*/) override {
    if (robot_.flies()) return TaskEnd{.error = robot_.name() + " flies: it is for the ground"};
    const GroundMap map = robot_.map();
    if (map.cells == nullptr && map.awaited) return std::nullopt;
    if (map.cells == nullptr && map.expected) return TaskEnd{.error = "no map has come"};
    if (map.cells == nullptr && !robot_.HasScan()) {
      return TaskEnd{.error = "there is no map, and no scan of " + robot_.name()};
    }
    TaskEnd end{.success = true};
    for (const tree::nav2::Pose& place : request_.places.poses) {
      end.occupied.push_back(IsOccupied({place.x_m, place.y_m, 0}, map));
    }
    return end;
  }

 private:
  bool IsOccupied(const navigation::Point& place, const GroundMap& map) const {
    const double radius_m = request_.whole_body ? robot_.radius_m() : 0;
    constexpr double kExactlyM = 0.05;  // half a place, where there is no map
    const double point_m =
        std::max(radius_m, map.cells != nullptr ? map.cells->resolution_m / 2 : kExactlyM);
    const bool seen = std::ranges::any_of(robot_.obstacles(), [&](const navigation::Point& point) {
      return std::hypot(point.x_m - place.x_m, point.y_m - place.y_m) <= point_m;
    });
    if (seen) return true;
    if (map.cells == nullptr) return request_.unknown_counts;
    const navigation::CellMap& cells =
        request_.unknown_counts && map.known != nullptr ? *map.known : *map.cells;
    if (!cells.Has(cells.CellOf(place))) return request_.unknown_counts;
    return Touches(cells, place, radius_m);
  }
  // Whether a disc touches a blocked cell.
  static bool Touches(const navigation::CellMap& map, const navigation::Point& place,
                      double radius_m) {
    const navigation::Point at = map.InCells(place);
    const double radius = radius_m / map.resolution_m;
    const navigation::Cell middle = map.CellOf(place);
    const int around = static_cast<int>(std::ceil(radius));
    for (int y = middle.y - around; y <= middle.y + around; ++y) {
      for (int x = middle.x - around; x <= middle.x + around; ++x) {
        if (!map.Has({x, y, 0}) || map.blocked[map.IndexOf({x, y, 0})] == 0) continue;
        const double off_x = std::max(std::abs(x + 0.5 - at.x_m) - 0.5, 0.0);
        const double off_y = std::max(std::abs(y + 0.5 - at.y_m) - 0.5, 0.0);
        if (std::hypot(off_x, off_y) <= radius) return true;
      }
    }
    return false;
  }

  Robot& robot_;
  const tree::nav2::OccupancyRequest request_;
};

}  // namespace

std::unique_ptr<tree::nav2::Task> MakeNavigation(Robot& robot, Handover& handover,
                                                 const tree::nav2::Goals& places) {
  std::vector<skill::Values> runs;
  for (const tree::nav2::Pose& place : places.poses) {
    const double half_rad = place.yaw_rad / 2;
    runs.push_back(
        {{"goal_pos", skill::Numbers{place.x_m, place.y_m, place.z_m}},
         {"goal_quat_wxyz", skill::Numbers{std::cos(half_rad), 0, 0, std::sin(half_rad)}}});
  }
  return std::make_unique<SkillTask>(
      handover, "navigate_to", [&robot] { return std::make_unique<NavigateTo>(robot); },
      std::move(runs));
}

std::unique_ptr<tree::nav2::Task> MakeFollowing(Robot& robot, Handover& handover,
                                                const std::string& topic, Duration limit) {
  return std::make_unique<SkillTask>(
      handover, "track", [&robot] { return std::make_unique<Track>(robot); },
      std::vector<skill::Values>{{{"target_topic", topic}, {"duration", ToSeconds(limit)}}});
}

std::unique_ptr<tree::nav2::Task> MakeTeleoperation(Robot& robot, Handover& handover,
                                                    Duration limit) {
  return std::make_unique<TeleopTask>(robot, handover, limit);
}

std::unique_ptr<tree::nav2::Task> MakePlaceCheck(Robot& robot,
                                                 const tree::nav2::OccupancyRequest& request) {
  return std::make_unique<PlaceCheck>(robot, request);
}

}  // namespace musher::skills
