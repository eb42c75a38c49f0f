#pragma once
// A robot that moves in simulated time, with a planner and a controller that a test scripts, and a
// fixture that runs skills on it, ten steps a second.

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/behavior/skill/manager.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/modules/skills/skills/navigation_skills.hpp"
#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/travelled_path.hpp"

namespace musher::skills::testing {

class MovingRobot : public Robot {
 public:
  // --- what a test sets ---
  std::string robot_kind = "jetbot";
  navigation::Pose at;
  navigation::Point corrected;  // of `at`, what its odometry does not have
  double pelvis_m = 0;          // the height of its pose above `at`
  std::optional<double> ceiling;
  double drive_speed_m_s = 1;
  bool drives_brake = true;  // else a cancelled drive goes on
  bool planner_up = true;
  bool controller_up = true;
  bool odometry_up = true;
  bool scan_up = true;
  bool answers = true;  // the planner; else a request stays open
  Duration planning_time = std::chrono::milliseconds(300);
  // The planner; by default a straight path.
  std::function<Result<navigation::Path>(const navigation::Pose&, const navigation::Pose&)> plan =
      [](const navigation::Pose& start, const navigation::Pose& goal) -> Result<navigation::Path> {
    return navigation::Path{start, goal};
  };
  GroundMap ground_map;
  std::optional<BatteryLevel> level;
  bool has_teleop = false;
  std::vector<navigation::Point> points;  // of obstacles
  double scan_covers_rad = M_PI;          // to each side of straight ahead
  // A place that is blocked by what the map does not have. The robot stops in front of it, and the
  // drive ends as those of the controller server do; one that replaces it leads on to the obstacle,
  // or has its own time. The planner then plans as the real one: where no path leads around it, its
  // path leads through.
  std::function<bool(const navigation::Point&)> blocked = [](const auto&) { return false; };
  std::function<std::optional<Line>(const navigation::Pose&)> see_line =
      [](const navigation::Pose&) { return std::optional<Line>(); };
  std::function<std::optional<Look>(const std::string& target, Time)> look =
      [](const std::string&, Time) { return std::optional<Look>(); };
  std::map<std::string, std::function<std::optional<navigation::Pose>(Time)>> targets;
  double target_hz = 10;                       // of their poses
  std::vector<navigation::RobotIntent> known;  // other robots
  std::function<Result<navigation::Path>()> refuge;
  // Planner and controller, about a request to forget what they have seen; nullopt: no reply.
  std::optional<Result<bool>> clear_reply = Result<bool>(true);
  std::string held_by;   // what its gate stops it for; empty: nothing
  std::string not_held;  // why a flyer is not held at its place; empty: it is

  // --- what a test reads ---
  int plans = 0;
  int drives = 0;
  int cleared = 0;
  int stops = 0;                 // commands to stand
  int commands_in_drives = 0;    // to the base, while the controller drives it
  int drives_from_a_motion = 0;  // that have begun while the base turned or rolled by a command
  std::vector<navigation::Path> driven_paths;
  double travelled_m = 0;
  double nearest_m = 1e9;  // to a point of an obstacle, so far
  bool cornered = false;

  bool driving() const { return drive_ != nullptr; }
  bool Rests() const {
    return !drive_ && navigation::Speed(velocity_) < 1e-6 && std::abs(velocity_.yaw_rad_s) < 1e-6;
  }

  // The drive ends with this error.
  void FailDrive(const Error& error) {
    if (!drive_) return;
    drive_->end.Set(error);
    drive_.reset();
  }
  // Another client has the drive cancelled.
  void CancelDrive() {
    drive_->end.Finish(false);
    drive_.reset();
  }
  // The controller says that it has arrived.
  void EndDrive() {
    drive_->end.Finish(true);
    drive_.reset();
  }
  // The processes exit: what they do is abandoned.
  void KillPlanner() {
    planner_up = false;
    requests_.clear();
  }
  void KillController() {
    controller_up = false;
    FailDrive({kCodeNetError, "the server is lost"});
  }

  void Advance(Duration step) {
    constexpr int kParts = 5;
    for (int i = 0; i < kParts; ++i) Move(ToSeconds(step) / kParts);
    now_ += step;
    CancelEarlier();
    constexpr Duration kLost = std::chrono::seconds(5);  // as the client of an action has it
    lost_for_ = controller_up ? Duration{} : lost_for_ + step;
    if (lost_for_ >= kLost) FailDrive({kCodeNetError, "the server is lost"});
    AnswerRequests();
  }

  // --- Robot ---
  const std::string& name() const override { return name_; }
  const std::string& kind() const override { return robot_kind; }
  bool flies() const override { return robot_kind == "cf2x" || robot_kind == "drone_autel"; }
  double radius_m() const override { return 0.2; }
  std::optional<double> ceiling_m() const override { return ceiling; }
  Time Now() const override { return now_; }
  std::optional<navigation::Pose> pose() const override {
    if (!odometry_up) return std::nullopt;
    return navigation::Pose{{at.at.x_m, at.at.y_m, at.at.z_m + pelvis_m}, at.yaw_rad};
  }
  std::optional<navigation::Pose> odometry() const override {
    auto odometry = pose();
    if (!odometry) return odometry;
    odometry->at.x_m -= corrected.x_m;
    odometry->at.y_m -= corrected.y_m;
    return odometry;
  }
  navigation::Velocity velocity() const override { return velocity_; }
  navigation::Path travelled() const override { return travelled_.Back(); }
  void SetVelocity(const navigation::Velocity& command) override {
    if (drive_) ++commands_in_drives;
    command_ = held_by.empty() ? command : navigation::Velocity{};
    if (command == navigation::Velocity{}) ++stops;
  }
  std::string HeldBy() const override { return held_by; }
  std::string WhyNotHeld() const override { return not_held; }
  void StopMotion() override {
    command_.reset();
    ++stops;
  }
  bool HasTeleop() const override { return has_teleop; }
  std::optional<BatteryLevel> battery() const override { return level; }
  bool HasTransform(const std::string& parent, const std::string& child) const override {
    return parent == "map" && child == "base_link" && odometry_up;
  }
  bool HasPlanner() const override { return planner_up; }
  bool HasController() const override { return controller_up; }
  bool Drives() const override { return driving(); }
  void CancelEarlierDrives() override {
    earlier_ = drive_;
    CancelEarlier();
  }
  skill::Future<navigation::Path> ComputePath(
      const navigation::Pose& goal, const std::optional<navigation::Pose>& start) override {
    ++plans;
    requests_.push_back({goal, start.value_or(at), now_ + planning_time, {}});
    return requests_.back().source.future();
  }
  std::unique_ptr<Drive> FollowPath(const navigation::Path& path) override {
    ++drives;
    driven_paths.push_back(path);
    if (!drive_ && !Rests()) ++drives_from_a_motion;
    auto state = std::make_shared<DriveState>();
    state->path = path;
    if (drive_) {
      drive_->end.Finish(false);
      state->waited_s = drive_->waited_s;
    }
    auto handle = std::make_unique<Handle>(*this, state);
    if (controller_up) {
      drive_ = state;
    } else {
      state->end.Fail("the server is lost");
    }
    return handle;
  }
  navigation::RobotIntent intent() override {
    navigation::RobotIntent own{.robot = "/robot_0", .cornered = cornered, .at = at.at, .path = {}};
    for (std::size_t i = drive_ ? drive_->next : 0; drive_ && i < drive_->path.size(); ++i) {
      own.path.push_back(drive_->path[i].at);
    }
    return own;
  }
  skill::Future<bool> ClearMemory() override {
    ++cleared;
    clearing_ = {};
    if (clear_reply) clearing_.Set(*clear_reply);
    return clearing_.future();
  }
  std::vector<navigation::RobotIntent> others() const override { return known; }
  void NoteCornered(Duration /*time*/) override { cornered = true; }
  skill::Future<navigation::Path> ComputeRefuge() override {
    skill::Source<navigation::Path> source;
    source.Set(refuge());
    return source.future();
  }
  GroundMap map() override { return ground_map; }
  std::vector<navigation::Point> obstacles() const override {
    return scan_up ? points : std::vector<navigation::Point>();
  }
  bool HasScan() const override { return scan_up; }
  bool ScanCovers(const navigation::Point& place) const override {
    return scan_up && std::abs(std::atan2(place.y_m, place.x_m)) <= scan_covers_rad;
  }
  std::vector<SeenObject> objects() const override { return {}; }
  std::optional<std::vector<SeenObject>> Detect() override { return std::nullopt; }
  bool HasObjects() const override { return false; }
  std::optional<Look> LookFor(const std::string& target) override { return look(target, now_); }
  std::optional<navigation::Pose> PoseOf(const std::string& topic) override {
    const auto found = targets.find(topic);
    return found == targets.end() ? std::nullopt : found->second(now_);
  }
  std::uint64_t PosesOf(const std::string& /*topic*/) const override {
    return static_cast<std::uint64_t>(target_hz * ToSeconds(now_.time_since_epoch()));
  }
  bool HasCamera(const std::string& /*camera*/) const override { return false; }
  std::vector<std::string> cameras() const override { return {}; }
  skill::Future<Picture> TakePicture(const std::string& /*camera*/) override { return {}; }
  skill::Future<std::string> SavePng(const Picture& /*picture*/,
                                     const std::string& /*path*/) override {
    return {};
  }
  std::optional<Line> line() const override { return see_line(at); }
  bool HasHand() const override { return false; }
  skill::Future<HandReply> UseHand(const HandRequest& /*request*/) override { return {}; }

 private:
  struct DriveState {
    navigation::Path path;
    std::size_t next = 0;
    bool cancelled = false;
    double waited_s = 0;
    skill::Source<bool> end;
  };
  class Handle : public Drive {
   public:
    Handle(MovingRobot& robot, std::shared_ptr<DriveState> state)
        : robot_(robot), state_(std::move(state)), end_(state_->end.future()) {}
    ~Handle() override { Cancel(); }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    std::optional<double> distance_to_goal_m() const override {
      return navigation::Distance(robot_.at.at, state_->path.back().at);
    }
    void Cancel() override { state_->cancelled = true; }
    skill::Future<bool> end() const override { return end_; }

   private:
    MovingRobot& robot_;
    std::shared_ptr<DriveState> state_;
    skill::Future<bool> end_;
  };
  struct Request {
    navigation::Pose goal;
    navigation::Pose start;
    Time ready;
    skill::Source<navigation::Path> source;
  };

  void CancelEarlier() {
    if (!controller_up || !earlier_) return;
    earlier_->cancelled = true;
    earlier_.reset();
  }
  void AnswerRequests() {
    for (Request& request : requests_) {
      if (!answers || !planner_up || request.ready > now_ || request.source.future().done())
        continue;
      request.source.Set(plan(request.start, request.goal));
    }
    std::erase_if(requests_, [](const Request& request) {
      return request.source.future().done() || !request.source.wanted();
    });
  }

  // Towards `target` in the frame of the map, with 2 m/s² and 4 rad/s².
  void Accelerate(const navigation::Velocity& target, double step_s) {
    constexpr double kMPerS2 = 2, kRadPerS2 = 4;
    const double x = target.x_m_s - velocity_.x_m_s, y = target.y_m_s - velocity_.y_m_s;
    const double z = target.z_m_s - velocity_.z_m_s;
    const double change = std::hypot(x, y, z);
    const double share = change > kMPerS2 * step_s ? kMPerS2 * step_s / change : 1;
    velocity_.x_m_s += share * x;
    velocity_.y_m_s += share * y;
    velocity_.z_m_s += share * z;
    velocity_.yaw_rad_s +=
        std::clamp(target.yaw_rad_s - velocity_.yaw_rad_s, -kRadPerS2 * step_s, kRadPerS2 * step_s);
  }

  void Move(double step_s) {
    const navigation::Point before = at.at;
    if (drive_) {
      if (!WaitsAtObstacle(step_s)) MoveAlong(step_s);
    } else {
      const navigation::Velocity body = command_.value_or(navigation::Velocity());
      const double c = std::cos(at.yaw_rad), s = std::sin(at.yaw_rad);
      Accelerate({c * body.x_m_s - s * body.y_m_s, s * body.x_m_s + c * body.y_m_s, body.z_m_s,
                  body.yaw_rad_s},
                 step_s);
      at.at = {at.at.x_m + velocity_.x_m_s * step_s, at.at.y_m + velocity_.y_m_s * step_s,
               at.at.z_m + velocity_.z_m_s * step_s};
      at.yaw_rad = navigation::Wrapped(at.yaw_rad + velocity_.yaw_rad_s * step_s);
    }
    travelled_m += navigation::Distance(before, at.at);
    travelled_.Add(at);
    for (const navigation::Point& point : points) {
      nearest_m = std::min(nearest_m, std::hypot(point.x_m - at.at.x_m, point.y_m - at.at.y_m));
    }
  }

  // 0.5 m before it, for 2 s. Once it waits, more has to be free.
  bool WaitsAtObstacle(double step_s) {
    if (drive_->cancelled || drive_->next >= drive_->path.size()) return false;
    constexpr double kLookM = 0.05;
    const double room_m = drive_->waited_s > 0 ? 0.6 : 0.5;
    navigation::Point from = at.at;
    double looked_m = 0;
    bool stops = false;
    for (std::size_t i = drive_->next; i < drive_->path.size() && looked_m < room_m; ++i) {
      const navigation::Point to = drive_->path[i].at;
      const double length_m = navigation::Distance(from, to);
      for (double along = 0; along <= length_m && looked_m + along <= room_m; along += kLookM) {
        stops =
            stops || blocked(navigation::Between(from, to, length_m > 0 ? along / length_m : 0));
      }
      looked_m += length_m;
      from = to;
    }
    if (!stops) {
      drive_->waited_s = 0;
      return false;
    }
    velocity_ = {};
    drive_->waited_s += step_s;
    constexpr double kFailureToleranceS = 2;
    if (drive_->waited_s >= kFailureToleranceS) {
      FailDrive(MakeError(navigation::Fault::kObstacle, "an obstacle stays in the way"));
    }
    return true;
  }

  // On the path at once, without a lag; the speed changes by 2 m/s².
  void MoveAlong(double step_s) {
    constexpr double kMPerS2 = 2;
    const double wanted = drive_->cancelled && drives_brake ? 0 : drive_speed_m_s;
    const double speed = navigation::Speed(velocity_);
    const double now = speed + std::clamp(wanted - speed, -kMPerS2 * step_s, kMPerS2 * step_s);
    double left_m = now * step_s;
    while (drive_->next < drive_->path.size()) {
      const navigation::Pose& to = drive_->path[drive_->next];
      const double distance = navigation::Distance(at.at, to.at);
      if (distance > left_m) {
        at.at = navigation::Between(at.at, to.at, left_m / distance);
        velocity_ = {now, 0, 0, 0};
        break;
      }
      left_m -= distance;
      at = to;
      ++drive_->next;
    }
    const bool arrived = drive_->next == drive_->path.size();
    if (!arrived && !(drive_->cancelled && now < 1e-9)) return;
    velocity_ = {};
    drive_->end.Finish(arrived);
    drive_.reset();
  }

  const std::string name_ = "robot_0";
  Time now_{};
  navigation::Velocity velocity_;  // in the frame of the map
  std::optional<navigation::Velocity> command_;
  navigation::TravelledPath travelled_;
  std::vector<Request> requests_;
  std::shared_ptr<DriveState> drive_;
  std::shared_ptr<DriveState> earlier_;  // to be cancelled, once its controller can be reached
  Duration lost_for_{};                  // the controller
  skill::Source<bool> clearing_;
};

class SkillsOnARobot {
 public:
  SkillsOnARobot() {
    MUSHER_CHECK(RegisterNavigationSkills(registry, robot).ok());
    manager = std::make_unique<skill::Manager>(registry.All());
  }

  Result<> Start(const std::string& name,
                 const std::vector<std::pair<std::string, std::string>>& parameters = {}) {
    name_ = name;
    return manager->StartWithTexts(name, parameters);
  }
  void Step(Duration step = std::chrono::milliseconds(100)) {
    robot.Advance(step);
    if (!paused) manager->RunOnce(now += step);
    if (paused) now += step;
    note_();
  }
  void RunFor(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(10 * seconds)); ++i) Step();
  }
  // Until its end, or for so long.
  bool RunToItsEnd(double seconds) {
    for (int i = 0; i < static_cast<int>(10 * seconds) && run().running(); ++i) Step();
    return run().ended();
  }
  bool RunToState(const std::string& state, double seconds = 60) {
    for (int i = 0; i < static_cast<int>(10 * seconds) && run().Path() != state; ++i) Step();
    return run().Path() == state;
  }
  void Pause() {
    paused = true;
    manager->Pause();
  }
  void Resume() { paused = false; }
  // Called after each step.
  void EachStep(std::function<void()> note) { note_ = std::move(note); }

  const skill::Run& run() const { return *manager->Find(name_); }
  const skill::Feedback& feedback() const { return run().feedback(); }
  const std::string& message() const { return feedback().message; }

  MovingRobot robot;
  skill::Registry registry;
  std::unique_ptr<skill::Manager> manager;
  Time now{};
  bool paused = false;

 private:
  std::string name_;
  std::function<void()> note_ = [] {};
};

}  // namespace musher::skills::testing
