#include "musher/test/modules/navigation/scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <memory>
#include <random>

#include "musher/modules/navigation/controller_server/path_drive.hpp"
#include "musher/modules/navigation/planner_server/planner_work.hpp"
#include "musher/navigation/grid/local_grid.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/test/navigation/scanned_body.hpp"

namespace musher::navigation::testing {
namespace {

constexpr double kCellM = 0.05;
constexpr double kStepS = 1.0 / 60;
constexpr double kRadiusM = 0.2;
constexpr double kBlockedS = 60;  // as navigate_to has it

void BlockBox(CellMap& map, double x_m, double y_m, double to_x_m, double to_y_m) {
  for (int y = 0; y < map.size_y; ++y) {
    for (int x = 0; x < map.size_x; ++x) {
      const Point at = map.CentreOf({x, y, 0});
      if (at.x_m > x_m && at.x_m < to_x_m && at.y_m > y_m && at.y_m < to_y_m) {
        map.blocked[map.IndexOf({x, y, 0})] = 1;
      }
    }
  }
}

CellMap Room(double x_m, double y_m) {
  CellMap map;
  map.resolution_m = kCellM;
  map.size_x = static_cast<int>(std::lround(x_m / kCellM));
  map.size_y = static_cast<int>(std::lround(y_m / kCellM));
  map.blocked.assign(static_cast<std::size_t>(map.size_x) * map.size_y, 0);
  return Fenced(std::move(map));
}

// Two rooms of 4 x 5 m with a door.
CellMap RoomsWithADoor(double width_m, double middle_m = 2.5) {
  CellMap map = Room(8.2, 5);
  BlockBox(map, 4, 0, 4.2, middle_m - width_m / 2);
  BlockBox(map, 4, middle_m + width_m / 2, 4.2, 5);
  return map;
}

// Corridors of 0.9 m, by a walk that visits each square once.
CellMap Maze(std::uint64_t seed, int side) {
  constexpr double kSquareM = 1.0, kWallM = 0.1;
  CellMap map = Room(side * kSquareM + kWallM, side * kSquareM + kWallM);
  std::mt19937_64 random(seed);
  std::vector<std::array<bool, 2>> open(static_cast<std::size_t>(side) * side);  // right, up
  std::vector<bool> visited(open.size());
  std::vector<int> stack = {0};
  visited[0] = true;
  while (!stack.empty()) {
    const int at = stack.back(), x = at % side, y = at / side;
    std::vector<int> next;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int nx = x + dx, ny = y + dy;
      if (nx < 0 || ny < 0 || nx >= side || ny >= side) continue;
      if (!visited[static_cast<std::size_t>(ny * side + nx)]) next.push_back(ny * side + nx);
    }
    if (next.empty()) {
      stack.pop_back();
      continue;
    }
    const int to = next[random() % next.size()];
    const int low = std::min(at, to);
    open[static_cast<std::size_t>(low)][std::abs(at - to) == 1 ? 0 : 1] = true;
    visited[static_cast<std::size_t>(to)] = true;
    stack.push_back(to);
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const auto& here = open[static_cast<std::size_t>(y * side + x)];
      const double left = x * kSquareM, low = y * kSquareM, right = left + kSquareM,
                   up = low + kSquareM;
      if (!here[0]) BlockBox(map, right, low, right + kWallM, up + kWallM);
      if (!here[1]) BlockBox(map, left, up, right + kWallM, up + kWallM);
    }
  }
  return map;
}

// The walls in several layers, for a flyer.
CellMap InSpace(const CellMap& flat) {
  constexpr int kEvery = 4;  // cells of 0.2 m
  CellMap map;
  map.resolution_m = kEvery * flat.resolution_m;
  map.origin = flat.origin;
  map.size_x = (flat.size_x + kEvery - 1) / kEvery;
  map.size_y = (flat.size_y + kEvery - 1) / kEvery;
  map.size_z = 12;
  map.blocked.assign(static_cast<std::size_t>(map.size_x) * map.size_y * map.size_z, 0);
  for (std::size_t i = 0; i < flat.count(); ++i) {
    if (!flat.blocked[i]) continue;
    Cell cell = map.CellOf(flat.CentreOf(flat.CellAt(i)));
    for (cell.z = 0; cell.z < map.size_z; ++cell.z) map.blocked[map.IndexOf(cell)] = 1;
  }
  for (int x = 0; x < map.size_x; ++x) {
    for (int y = 0; y < map.size_y; ++y) {
      map.blocked[map.IndexOf({x, y, 0})] = map.blocked[map.IndexOf({x, y, 11})] = 1;
    }
  }
  return map;
}

// Goes from one place to the next ones, and stands at the last; it stops before a body.
SceneMover Walker(std::vector<Point> places, double speed_m_s, double begin_s = 0,
                  double stands_s = 0) {
  return {0.25, [=](double at_s, const Point& /*robot*/) {
            double left_m = speed_m_s * std::max(0.0, at_s - begin_s);
            if (stands_s > 0 && at_s > begin_s + stands_s) {
              // It has stood at the second place; then it goes on.
              left_m = std::max(left_m - speed_m_s * stands_s, Distance(places[0], places[1]));
            } else if (stands_s > 0) {
              left_m = std::min(left_m, Distance(places[0], places[1]));
            }
            for (std::size_t i = 1; i < places.size(); ++i) {
              const double length_m = Distance(places[i - 1], places[i]);
              if (left_m < length_m) return Between(places[i - 1], places[i], left_m / length_m);
              left_m -= length_m;
            }
            return places.back();
          }};
}

Scene Plain(const std::string& kind, const std::string& name, CellMap world, const Pose& start,
            const Pose& goal) {
  Scene scene;
  scene.kind = kind;
  scene.name = name;
  scene.map = world;
  scene.world = std::move(world);
  scene.start = start;
  scene.goal = goal;
  return scene;
}

void AddMazes(std::vector<Scene>& scenes) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const int side = seed <= 4 ? 5 : 7;
    const double far_m = side - 0.45;
    scenes.push_back(Plain("maze", fmt::format("seed {}", seed), Maze(seed, side),
                           {{0.55, 0.55, 0}, 0}, {{far_m, far_m, 0}, 0}));
  }
}

// Of things that the map does not have.
void AddTraps(std::vector<Scene>& scenes) {
  for (const double depth_m : {1.0, 1.8, 2.6}) {
    for (const double off_m : {0.0, 0.5}) {
      Scene scene = Plain("U trap", fmt::format("{} m deep, {} m off", depth_m, off_m), Room(9, 8),
                          {{1, 4, 0}, 0}, {{8, 4, 0}, 0});
      const double low = 2.6 + off_m, high = low + 2.4, end = 5.5;
      BlockBox(scene.world, end, low, end + 0.2, high);
      BlockBox(scene.world, end - depth_m, low, end, low + 0.2);
      BlockBox(scene.world, end - depth_m, high - 0.2, end, high);
      scenes.push_back(std::move(scene));
    }
  }
}

void AddDoors(std::vector<Scene>& scenes) {
  for (const double width_m : {0.5, 0.7, 0.75, 0.8, 0.9, 1.2}) {
    Scene scene = Plain("door", fmt::format("{} m", width_m), RoomsWithADoor(width_m),
                        {{1, 1, 0}, 0}, {{7, 4, 0}, 0});
    scene.passable = width_m > 0.6;
    scenes.push_back(std::move(scene));
  }
}

void AddMoversInDoors(std::vector<Scene>& scenes) {
  for (const double stands_s : {5.0, 15.0, 40.0, 300.0}) {
    Scene scene = Plain("mover in the door", fmt::format("for {} s", stands_s), RoomsWithADoor(1),
                        {{1, 2.5, 0}, 0}, {{7, 2.5, 0}, 0});
    scene.movers = {Walker({{6.5, 1, 0}, {4.1, 2.5, 0}, {1.5, 4.3, 0}}, 0.8, 0, stands_s + 3.5)};
    scene.passable = stands_s < 100;
    scenes.push_back(std::move(scene));
  }
  Scene two = Plain("mover in the door", "and another door", RoomsWithADoor(1, 1.2),
                    {{1, 1.2, 0}, 0}, {{7, 1.2, 0}, 0});
  for (CellMap* map : {&two.world, &two.map}) {
    for (int y = 0; y < map->size_y; ++y) {
      for (int x = 0; x < map->size_x; ++x) {
        const Point at = map->CentreOf({x, y, 0});
        const bool door = at.x_m > 3.9 && at.x_m < 4.3 && at.y_m > 3.3 && at.y_m < 4.3;
        if (door) map->blocked[map->IndexOf({x, y, 0})] = 0;
      }
    }
  }
  two.movers = {Walker({{6, 0.6, 0}, {4.1, 1.2, 0}}, 0.8)};
  scenes.push_back(std::move(two));
}

void AddLateMaps(std::vector<Scene>& scenes) {
  for (const double late_s : {0.0, 1.0, 1.6, 2.2, 2.8, 4.0}) {
    Scene scene = Plain("late map", fmt::format("after {} s", late_s), Room(9, 5), {{1, 2.5, 0}, 0},
                        {{8, 2.5, 0}, 0});
    BlockBox(scene.world, 4, 1.8, 4.4, 3.2);
    scene.late_map = scene.world;
    scene.late_map_s = late_s;
    scenes.push_back(std::move(scene));
  }
}

void AddJumps(std::vector<Scene>& scenes) {
  for (const double jump_m : {0.3, 1.0, 5.0, 30.0}) {
    Scene scene = Plain("jump", fmt::format("{} m", jump_m), RoomsWithADoor(1), {{1, 2.5, 0}, 0},
                        {{7, 2.5, 0}, 0});
    scene.jump = {0.6 * jump_m, 0.8 * jump_m, 0};
    scene.jump_s = 2;
    scene.passable = jump_m < 0.5;
    scenes.push_back(std::move(scene));
  }
}

// A corridor of 1 m with another robot in it.
void AddCorridors(std::vector<Scene>& scenes) {
  CellMap corridor = Room(10, 4);
  BlockBox(corridor, 2, 0, 8, 1.5);
  BlockBox(corridor, 2, 2.5, 8, 4);
  const Pose start{{1, 2, 0}, 0}, goal{{9, 2, 0}, 0};
  const std::vector<std::pair<const char*, SceneMover>> others = {
      {"stands", Walker({{5, 2, 0}, {5, 2, 0}}, 1)},
      {"comes and goes back", Walker({{7, 2, 0}, {5, 2, 0}, {9, 2, 0}, {9, 1, 0}}, 0.5)},
      {"drives ahead, slowly", Walker({{2.5, 2, 0}, {8.5, 2, 0}, {9, 3.4, 0}}, 0.3)},
      {"comes and stops at the body",
       {0.2,
        [at = Point{8, 2, 0}, last_s = 0.0](double at_s, const Point& robot) mutable {
          const double step_m = 0.5 * std::max(0.0, at_s - last_s);
          last_s = at_s;
          if (at.x_m - robot.x_m > 0.8) at.x_m -= step_m;
          return at;
        }}},
  };
  for (const auto& [name, mover] : others) {
    Scene scene = Plain("head-on corridor", name, corridor, start, goal);
    scene.movers = {mover};
    scene.passable =
        std::string(name) != "stands" && std::string(name).find("body") == std::string::npos;
    scenes.push_back(std::move(scene));
  }
}

void AddPersons(std::vector<Scene>& scenes) {
  for (const bool flies : {false, true}) {
    const std::string kind = flies ? "flyer and person" : "robot and person";
    const std::vector<std::pair<const char*, SceneMover>> persons = {
        {"stands in the way", Walker({{4, 3, 0}, {4, 3, 0}}, 1)},
        {"crosses", Walker({{4, 0.6, 0}, {4, 5.4, 0}}, 0.8)},
        {"comes along", Walker({{7, 3.1, 0}, {1, 3.1, 0}, {1, 5, 0}}, 0.8)},
        {"walks to and fro",
         Walker({{4, 1, 0}, {4, 5, 0}, {4, 1, 0}, {4, 5, 0}, {4, 5.3, 0}}, 0.6)},
    };
    for (const auto& [name, person] : persons) {
      Scene scene = Plain(kind, name, Room(8, 6), {{1, 3, 0}, 0}, {{7, 3, 0}, 0});
      scene.movers = {person};
      scene.flies = flies;
      scenes.push_back(std::move(scene));
    }
  }
}

double CpuMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) / 1e6;
}

class SceneRun {
 public:
  SceneRun(const Scene& scene, bool gated)
      : scene_(scene),
        walls_(scene.world),
        body_(walls_, scene.start, {}),
        drive_(RobotOf(scene, gated), {}),
        grid_(LocalGridRules{}) {
    planner_robot_.flies = scene.flies;
    planner_robot_.radius_m = kRadiusM;
    if (scene.flies) planner_config_.ceiling_m = 2.2;
    TakeMap(scene.map);
    for (const SceneMover& mover : scene.movers) movers_.push_back(mover.at(0, scene.start.at));
  }

  SceneEnd Do() {
    constexpr double kLongestS = 300;
    Sense(true);
    for (; at_s_ < kLongestS && !ended_; at_s_ += kStepS, ++steps_) {
      now_ += FromSeconds(kStepS);
      Happen();
      Sense(false);
      if (!drive_.driving()) Plan();
      const PathDrive::Step step = drive_.Update(now_);
      body_.Move(step.command, kStepS);
      Compare();
      if (step.end) OnEnd(*step.end);
    }
    end_.seconds = at_s_;
    return end_;
  }

 private:
  static ControllerRobot RobotOf(const Scene& scene, bool gated) {
    ControllerRobot robot;
    robot.name = "r";
    robot.odometry = "r/odom";
    robot.scanners = {{.topic = "r/scan"}};
    robot.lag_s = 0.1;
    robot.gate.reaction_s += robot.lag_s;
    robot.radius_m = kRadiusM;
    robot.flies = scene.flies;
    robot.differential = !scene.flies;
    if (!gated) {
      robot.gate.margin_m = -kRadiusM;  // no point is too near
      robot.gate.blind_m_s = 100;
    }
    return robot;
  }

  void TakeMap(const CellMap& flat) {
    CellMap map = scene_.flies ? InSpace(flat) : flat;
    drive_.SetMap(std::make_shared<const Clearance>(map), now_);
    PlannerRules rules;
    rules.radius_m = planner_robot_.radius_m + planner_robot_.margin_m;
    rules.comfort_m = planner_robot_.comfort_m;
    rules.start_within_m = planner_robot_.margin_m;
    rules.heading = scene_.flies ? Heading::kTurning : Heading::kAlong;
    planner_.emplace(Planner::Make(std::move(map), rules).value());
    before_.clear();
  }

  void Happen() {
    if (scene_.late_map && !has_late_map_ && at_s_ >= scene_.late_map_s) {
      has_late_map_ = true;
      TakeMap(*scene_.late_map);
    }
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      movers_[i] = scene_.movers[i].at(at_s_, body_.pose().at);
    }
  }

  Pose Believed() const {
    Pose pose = body_.pose();
    if (at_s_ >= scene_.jump_s) {
      pose.at.x_m += scene_.jump.x_m;
      pose.at.y_m += scene_.jump.y_m;
    }
    if (scene_.flies) pose.at.z_m = kHeightM;
    return pose;
  }

  void Sense(bool all) {
    const Pose believed = Believed();
    if (all || steps_ % 2 == 0) {
      drive_.OnOdometry({believed, InBodyFrame(body_.velocity(), -believed.yaw_rad)},
                        now_.time_since_epoch(), now_);
      grid_.NotePlace(believed.at);
    }
    if (!all && steps_ % 6 != 0) return;
    Scan scan = body_.Look(random_);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const double angle =
          body_.pose().yaw_rad + scan.from_rad + static_cast<double>(i) * scan.step_rad;
      scan.ranges_m[i] = static_cast<float>(ToMovers(angle, scan.ranges_m[i]));
    }
    drive_.OnScan(0, scan, now_.time_since_epoch(), now_);
    grid_.Add(scan, believed, now_);
  }

  double ToMovers(double angle, double range_m) const {
    const double c = std::cos(angle), s = std::sin(angle);
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      const double x = movers_[i].x_m - body_.pose().at.x_m,
                   y = movers_[i].y_m - body_.pose().at.y_m;
      const double along = x * c + y * s, radius_m = scene_.movers[i].radius_m;
      const double square = radius_m * radius_m - (x * x + y * y - along * along);
      if (along > 0 && square >= 0) range_m = std::min(range_m, along - std::sqrt(square));
    }
    return range_m;
  }

  void Plan() {
    if (at_s_ < next_plan_s_) return;
    PathRequest request{Believed(), scene_.goal, grid_.Points(now_), before_};
    if (scene_.flies) request.goal.at.z_m = kHeightM;
    const double begin_ms = CpuMs();
    const PathReply reply = FindPath(*planner_, request, planner_config_, planner_robot_, {});
    if (end_.plans++ > 0) end_.replan_ms.push_back(CpuMs() - begin_ms);
    if (!reply.plan) return Refuse(reply.plan.error().message);
    before_ = reply.plan.value().path;
    if (const auto refused = drive_.Start(before_, now_)) Refuse(refused->reason);
  }

  void OnEnd(const DriveEnd& end) {
    if (end.error_code == FollowCode::kNone) {
      const Point& at = body_.pose().at;
      const double off_m = std::hypot(at.x_m - scene_.goal.at.x_m, at.y_m - scene_.goal.at.y_m);
      if (off_m > 0.5) return Refuse("arrived elsewhere");
      end_.kind = SceneEnd::Kind::kArrived;
      ended_ = true;
      return;
    }
    constexpr std::uint16_t kObstacle = 104;
    if (end.error_code != kObstacle) return Refuse(end.reason);
    const double moved_m = Distance(body_.pose().at, blocked_at_);
    if (moved_m > 0.5 || blocked_since_s_ < 0) {
      blocked_since_s_ = at_s_;
      blocked_at_ = body_.pose().at;
    }
    if (at_s_ - blocked_since_s_ > kBlockedS) return Refuse("blocked: " + end.reason);
    next_plan_s_ = at_s_ + 0.3;
  }

  void Refuse(const std::string& why) {
    end_.kind = SceneEnd::Kind::kRefused;
    end_.reason = why;
    drive_.Stop();
    for (int i = 0; i < 60; ++i) {
      body_.Move({}, kStepS);
      Compare();
    }
    ended_ = true;
  }

  void Compare() {
    constexpr double kMovesMS = 0.05;
    const double speed_m_s = std::hypot(body_.velocity().x_m_s, body_.velocity().y_m_s);
    const double room_m = body_.room_m();
    end_.least_room_m = std::min(end_.least_room_m, room_m);
    bool touches = room_m <= 0, comes = false;
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      const double x = movers_[i].x_m - body_.pose().at.x_m,
                   y = movers_[i].y_m - body_.pose().at.y_m;
      if (std::hypot(x, y) > kRadiusM + scene_.movers[i].radius_m) continue;
      const Velocity v = InBodyFrame(body_.velocity(), -body_.pose().yaw_rad);
      const bool towards = v.x_m_s * x + v.y_m_s * y > kMovesMS * std::hypot(x, y);
      (towards ? touches : comes) = true;
    }
    touches = touches && (room_m > 0 || speed_m_s > 0);
    if (touches && !touched_) ++end_.contacts;
    if (comes && !came_) ++end_.contacts_of_movers;
    touched_ = touches;
    came_ = comes;
  }

  static constexpr double kHeightM = 1.2;
  const Scene& scene_;
  std::mt19937_64 random_{7};
  Clearance walls_;
  ScannedBody body_;
  PathDrive drive_;
  LocalGrid grid_;
  PlannerConfig planner_config_;
  PlannerRobot planner_robot_;
  std::optional<Planner> planner_;
  Path before_;
  std::vector<Point> movers_;
  Time now_ = Time{} + std::chrono::seconds(10);
  double at_s_ = 0;
  int steps_ = 0;
  bool has_late_map_ = false;
  bool ended_ = false;
  bool touched_ = false, came_ = false;
  double next_plan_s_ = 0;
  double blocked_since_s_ = -1;
  Point blocked_at_;
  SceneEnd end_;
};

}  // namespace

std::vector<Scene> HeldScenes() {
  std::vector<Scene> scenes;
  AddMazes(scenes);
  AddTraps(scenes);
  AddDoors(scenes);
  AddMoversInDoors(scenes);
  AddLateMaps(scenes);
  AddJumps(scenes);
  AddCorridors(scenes);
  AddPersons(scenes);
  return scenes;
}

SceneEnd RunScene(const Scene& scene, bool gated) {
  return SceneRun(scene, gated).Do();
}

}  // namespace musher::navigation::testing
