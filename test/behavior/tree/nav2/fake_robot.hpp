#pragma once
// A robot for the nodes of nav2: a test places it, and ends its tasks. It logs what begins ("spin
// 1.57") and what is cancelled ("spin!").

#include <map>

#include "musher/behavior/tree/nav2/nodes.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::nav2 {

class FakeRobot : public Robot {
 public:
  std::optional<Pose> at = Pose{};
  double speed = 0;
  std::optional<Pose> new_goal;
  std::optional<Goals> new_goals;
  std::map<std::string, std::string, std::less<>> selected;
  // The end of each task of this name, at its next poll. None: it goes on.
  std::map<std::string, TaskEnd, std::less<>> ends;
  RouteProgress progress;  // of the task "track"
  bool has_tasks = true;
  bool polls_throw = false;
  bool has_wings = false;
  bool sees_free = true;
  mutable Path seen_path;       // of the last IsFree()
  bool has_controllers = true;  // several, by their names
  std::optional<Motion> moves = Motion{};
  bool is_driven = false;
  std::map<std::string, Battery, std::less<>> batteries;   // by their topics
  std::map<std::string, std::string, std::less<>> frames;  // the parent of each child
  std::map<std::string, std::uint64_t, std::less<>> calls;
  double most_turn = 10;
  double most_drive = 10;
  std::string log;

  std::string Take() { return std::exchange(log, ""); }

  std::optional<Pose> pose() const override { return at; }
  double speed_m_s() const override { return speed; }
  std::optional<Motion> motion() const override { return moves; }
  bool IsDriven() const override { return is_driven; }
  std::optional<Battery> battery(std::string_view topic) const override {
    const auto found = batteries.find(topic);
    return found == batteries.end() ? std::nullopt : std::optional(found->second);
  }
  bool HasTransform(std::string_view parent, std::string_view child) const override {
    const auto found = frames.find(child);
    return found != frames.end() && found->second == parent;
  }
  std::uint64_t Calls(std::string_view service) const override {
    const auto found = calls.find(service);
    return found == calls.end() ? 0 : found->second;
  }
  bool flies() const override { return has_wings; }
  bool selects_controllers() const override { return has_controllers; }
  double most_turn_rad_s() const override { return most_turn; }
  double most_drive_m_s() const override { return most_drive; }
  std::optional<Pose> goal_update() const override { return new_goal; }
  std::optional<Goals> goals_update() const override { return new_goals; }
  bool IsFree(const Path& path) const override {
    seen_path = path;
    return sees_free;
  }
  bool CancelDrives() override {
    if (has_tasks) log += "cancel drives; ";
    return has_tasks;
  }
  bool CancelRoutes() override {
    if (has_tasks) log += "cancel routes; ";
    return has_tasks;
  }
  std::string Selected(std::string_view topic) const override {
    const auto found = selected.find(topic);
    return found == selected.end() ? "" : found->second;
  }
  std::unique_ptr<Task> ComputePath(const Pose& goal, const std::optional<Pose>& start,
                                    const std::string& planner) override {
    const std::string from = start ? " from " + NumberText(start->x_m) : "";
    return Begin("plan",
                 " to " + NumberText(goal.x_m) + from + (planner.empty() ? "" : " by " + planner));
  }
  std::unique_ptr<Task> FollowPath(const Path& path, const std::string& controller) override {
    return Begin("follow", " " + NumberText(LengthOf(path)) + " m" +
                               (controller.empty() ? "" : " by " + controller));
  }
  std::unique_ptr<Task> Spin(double angle_rad, Duration limit) override {
    return Begin("spin", " " + NumberText(angle_rad) + " in " + NumberText(ToSeconds(limit)));
  }
  std::unique_ptr<Task> Drive(double distance_m, double speed_m_s, Duration limit) override {
    return Begin("drive", " " + NumberText(distance_m) + " at " + NumberText(speed_m_s) + " in " +
                              NumberText(ToSeconds(limit)));
  }
  std::unique_ptr<Task> ComputeRoute(const RouteRequest& request) override {
    return Begin("route", " " + TextOf(request));
  }
  std::unique_ptr<Task> TrackRoute(const RouteRequest& request) override {
    return Begin("track", " " + TextOf(request));
  }
  std::unique_ptr<Task> SmoothPath(const Path& path, const std::string& smoother,
                                   bool check) override {
    return Begin("smooth", " " + NumberText(LengthOf(path)) + " m" +
                               (smoother.empty() ? "" : " by " + smoother) +
                               (check ? ", checked" : ""));
  }
  std::unique_ptr<Task> ClearCostmap(const std::string& service) override {
    return Begin("clear", " " + service);
  }
  std::unique_ptr<Task> CheckPlaces(const OccupancyRequest& request) override {
    return Begin("check", TextOf(request.places) + (request.whole_body ? "" : " exactly") +
                              (request.unknown_counts ? ", unknown too" : ""));
  }
  std::unique_ptr<Task> Navigate(const Goals& places) override {
    return Begin("navigate", TextOf(places));
  }
  std::unique_ptr<Task> FollowObject(const std::string& topic, Duration limit) override {
    return Begin("object", " " + topic + " for " + NumberText(ToSeconds(limit)));
  }
  std::unique_ptr<Task> Teleoperate(Duration limit) override {
    return Begin("teleop", " " + NumberText(ToSeconds(limit)));
  }

 private:
  class FakeTask : public Task {
   public:
    FakeTask(FakeRobot& robot, std::string name) : robot_(robot), name_(std::move(name)) {}
    ~FakeTask() override {
      if (!ended_) robot_.log += name_ + "! ";
    }
    std::optional<TaskEnd> Poll(Time /*now*/) override {
      if (robot_.polls_throw) throw std::runtime_error("its link is lost");
      const auto found = robot_.ends.find(name_);
      if (found == robot_.ends.end()) return std::nullopt;
      ended_ = true;
      return found->second;
    }
    const RouteProgress* progress() const override {
      return name_ == "track" ? &robot_.progress : nullptr;
    }

   private:
    FakeRobot& robot_;
    const std::string name_;
    bool ended_ = false;
  };

  static std::string TextOf(const Goals& places) {
    std::string text;
    for (const Pose& place : places.poses) text += " " + NumberText(place.x_m);
    return text;
  }
  static std::string TextOf(const RouteRequest& request) {
    if (!request.by_poses) {
      return std::to_string(request.start_id) + " to " + std::to_string(request.goal_id);
    }
    return (request.start ? "from " + NumberText(request.start->x_m) + " " : "") + "to " +
           NumberText(request.goal.x_m);
  }
  std::unique_ptr<Task> Begin(const std::string& name, const std::string& how) {
    if (!has_tasks) return nullptr;
    log += name + how + "; ";
    return std::make_unique<FakeTask>(*this, name);
  }
};

// A tree with the nodes of nav2 and Say (trees.hpp).
struct Nav2Tree : testing::Test, Logged {
  Nav2Tree() { AddNodes(factory, robot); }

  void Make(const std::string& content) { tree = MakeTree(Main(content), factory); }
  // One tick: its letter, then what the Says have logged.
  std::string TickAt(std::int64_t ms) {
    const Result<Status> result = tree->TickExactlyOnce(At(ms));
    fault = result ? "" : result.error().message;
    return std::string(1, Letter(result)) + " " + Take();
  }
  std::string Next() { return TickAt(now_ms += 10); }
  // `times` ticks, a line for each.
  std::string NextTicks(int times) {
    std::string lines;
    for (int i = 0; i < times; ++i) lines += Next() + "\n";
    return lines;
  }
  template <class T>
  void Put(const std::string& key, const T& value) {
    ASSERT_TRUE(tree->board().Set(key, value));
  }

  FakeRobot robot;
  std::unique_ptr<Tree> tree;
  std::string fault;
  std::int64_t now_ms = 0;
};

inline std::string SayXml(const std::string& name, const std::string& does) {
  return "<Say name=\"" + name + "\" does=\"" + does + "\"/>";
}
inline Path Straight(double length_m) {
  return {{Pose{}, Pose{.x_m = length_m}}};
}

}  // namespace musher::tree::nav2
