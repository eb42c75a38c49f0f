#include "musher/test/modules/skills/scenes/scene_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace musher::skills::testing {
namespace {

using navigation::Point;
using navigation::Velocity;

constexpr double kApartAgainM = 0.01;
constexpr double kStandsMS = 0.02;
constexpr double kHeadM = 1e-3;  // where only heads are seen, from above

double Flat(const Point& a, const Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

}  // namespace

SceneWorld::SceneWorld(const Scene& scene, std::uint64_t seed) : scene_(scene), random_(seed) {
  for (const SceneRobot& robot : scene.robots) bodies_.push_back({.pose = robot.start});
  for (const SceneMover& mover : scene.movers) {
    movers_.push_back({.at = mover.path.front(), .rests_until_s = mover.begins_s});
  }
}

void SceneWorld::Command(std::size_t robot, const Velocity& velocity) {
  bodies_[robot].command = velocity;
}

bool SceneWorld::IsOver(const SceneEvent& event, double now_s) {
  return event.lasts_s > 0 && now_s >= event.at_s + event.lasts_s;
}

bool SceneWorld::Holds(SceneEvent::Kind kind) const {
  return std::ranges::any_of(scene_.events, [&](const SceneEvent& event) {
    return event.kind == kind && now_s_ >= event.at_s && !IsOver(event, now_s_);
  });
}

Point SceneWorld::JumpNow() const {
  Point off;
  for (const SceneEvent& event : scene_.events) {
    if (event.kind != SceneEvent::Kind::kJump || now_s_ < event.at_s) continue;
    if (IsOver(event, now_s_)) continue;
    off.x_m += event.x_m;
    off.y_m += event.y_m;
  }
  return off;
}

// The exact distance to the nearest square that is a wall.
double SceneWorld::ToWalls(const Point& centre, double within_m) const {
  const double c = scene_.cell_m;
  double least_m = within_m;
  const auto from = [&](double at) { return static_cast<int>(std::floor((at - within_m) / c)); };
  const auto to = [&](double at) { return static_cast<int>(std::floor((at + within_m) / c)); };
  for (int y = from(centre.y_m); y <= to(centre.y_m); ++y) {
    for (int x = from(centre.x_m); x <= to(centre.x_m); ++x) {
      if (!scene_.IsWall(x, y)) continue;
      const double nearest_x = std::clamp(centre.x_m, x * c, (x + 1) * c);
      const double nearest_y = std::clamp(centre.y_m, y * c, (y + 1) * c);
      least_m = std::min(least_m, std::hypot(centre.x_m - nearest_x, centre.y_m - nearest_y));
    }
  }
  return least_m;
}

bool SceneWorld::Reaches(const SceneMover& mover, double height_m) const {
  return !scene_.flies || height_m - kSceneBodyHeightM < mover.height_m;
}

bool SceneWorld::SinksOntoMover(const Point& from, const Point& to) const {
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const SceneMover& mover = scene_.movers[i];
    const bool below = Reaches(mover, to.z_m) && !Reaches(mover, from.z_m);
    if (below && Flat(to, movers_[i].at) <= mover.radius_m + kSceneBodyM) return true;
  }
  return false;
}

double SceneWorld::RoomOf(std::size_t robot, const Point& at) const {
  double room_m = ToWalls(at, 1);
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    if (!Reaches(scene_.movers[i], at.z_m)) continue;
    room_m = std::min(room_m, Flat(at, movers_[i].at) - scene_.movers[i].radius_m);
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (i != robot) room_m = std::min(room_m, Flat(at, bodies_[i].pose.at) - kSceneBodyM);
  }
  return room_m - kSceneBodyM;
}

void SceneWorld::MoveBody(std::size_t robot, double seconds) {
  constexpr double kLagS = 0.1, kMostMS2 = 2.5;
  Body& body = bodies_[robot];
  const double share = 1 - std::exp(-seconds / kLagS);
  Velocity& wanted = body.wanted;
  wanted.x_m_s += share * (body.command.x_m_s - wanted.x_m_s);
  wanted.y_m_s += share * (body.command.y_m_s - wanted.y_m_s);
  wanted.z_m_s += share * (body.command.z_m_s - wanted.z_m_s);
  wanted.yaw_rad_s += share * (body.command.yaw_rad_s - wanted.yaw_rad_s);
  const double dx = wanted.x_m_s - body.velocity.x_m_s, dy = wanted.y_m_s - body.velocity.y_m_s;
  const double change = std::hypot(dx, dy), most = kMostMS2 * seconds;
  const double part = change > most ? most / change : 1;
  body.velocity = {body.velocity.x_m_s + part * dx, body.velocity.y_m_s + part * dy, wanted.z_m_s,
                   wanted.yaw_rad_s};
  if (!scene_.flies) body.velocity.y_m_s = body.velocity.z_m_s = 0;  // it has wheels
  if (Holds(SceneEvent::Kind::kStuck)) body.velocity = {};
  const double c = std::cos(body.pose.yaw_rad), s = std::sin(body.pose.yaw_rad);
  Point to = body.pose.at;
  to.x_m += (c * body.velocity.x_m_s - s * body.velocity.y_m_s) * seconds;
  to.y_m += (s * body.velocity.x_m_s + c * body.velocity.y_m_s) * seconds;
  to.z_m = std::max(0.0, to.z_m + body.velocity.z_m_s * seconds);
  body.pose.yaw_rad = navigation::Wrapped(body.pose.yaw_rad + body.velocity.yaw_rad_s * seconds);
  const double room_m = RoomOf(robot, to), before_m = RoomOf(robot, body.pose.at);
  body.least_room_m = std::min(body.least_room_m, room_m);
  if (room_m <= 0 && room_m <= before_m && Flat(to, body.pose.at) > 0) {
    int& count = SinksOntoMover(body.pose.at, to) ? body.from_above : body.contacts;
    count += body.touches ? 0 : 1;
    body.touches = true;
    body.velocity.x_m_s = body.velocity.y_m_s = 0;
    return;
  }
  if (room_m > kApartAgainM) body.touches = false;
  body.travelled_m += Flat(to, body.pose.at);
  body.pose.at = to;
}

void SceneWorld::Turn(std::size_t index) {
  const SceneMover& mover = scene_.movers[index];
  Mover& state = movers_[index];
  state.rests_until_s = now_s_ + mover.waits_s;
  const auto last = static_cast<int>(mover.path.size()) - 1;
  if (mover.stays && static_cast<int>(state.to) == last) {
    state.rests_until_s = 1e9;
    return;
  }
  if (static_cast<int>(state.to) == last) state.direction = -1;
  if (state.to == 0) state.direction = 1;
  state.to =
      static_cast<std::size_t>(std::clamp(static_cast<int>(state.to) + state.direction, 0, last));
}

// Back to the place from which it came.
void SceneWorld::TurnRound(std::size_t index) {
  Mover& state = movers_[index];
  state.direction = -state.direction;
  const auto last = static_cast<int>(scene_.movers[index].path.size()) - 1;
  state.to =
      static_cast<std::size_t>(std::clamp(static_cast<int>(state.to) + state.direction, 0, last));
  state.waited_s = 0;
}

void SceneWorld::MoveMover(std::size_t index, double seconds) {
  const SceneMover& mover = scene_.movers[index];
  Mover& state = movers_[index];
  if (mover.path.size() < 2 || now_s_ < state.rests_until_s) return;
  const Point& goal = mover.path[state.to];
  const double left_m = Flat(state.at, goal), step_m = std::min(left_m, mover.speed_m_s * seconds);
  if (left_m < 1e-6) return Turn(index);
  const Point to{state.at.x_m + (goal.x_m - state.at.x_m) * step_m / left_m,
                 state.at.y_m + (goal.y_m - state.at.y_m) * step_m / left_m, 0};
  for (const Body& body : bodies_) {
    if (!Reaches(mover, body.pose.at.z_m)) continue;
    const double apart_m = Flat(to, body.pose.at) - mover.radius_m - kSceneBodyM;
    const bool nearer = Flat(to, body.pose.at) < Flat(state.at, body.pose.at);
    if (mover.yields && nearer && apart_m < mover.yields_m) {
      state.waited_s += seconds;
      if (state.waited_s >= mover.turns_s) TurnRound(index);
      return;
    }
    if (apart_m > kApartAgainM) state.touches = false;
    if (!nearer || apart_m > 0) continue;
    // It is the robot's only if that has moved, which MoveBody() then says.
    const bool stands = std::hypot(body.velocity.x_m_s, body.velocity.y_m_s) < kStandsMS;
    if (stands && !state.touches) ++hits_of_movers_;
    state.touches = true;
    return;
  }
  state.at = to;
  state.waited_s = 0;
}

void SceneWorld::Step(double seconds) {
  now_s_ += seconds;
  for (std::size_t i = 0; i < movers_.size(); ++i) MoveMover(i, seconds);
  for (std::size_t i = 0; i < bodies_.size(); ++i) MoveBody(i, seconds);
}

// From square to square along the ray.
double SceneWorld::ToWallAlong(const Point& from, double angle_rad, double most_m) const {
  const double c = scene_.cell_m, dx = std::cos(angle_rad), dy = std::sin(angle_rad);
  int x = static_cast<int>(std::floor(from.x_m / c)),
      y = static_cast<int>(std::floor(from.y_m / c));
  const auto to_next = [c](double at, int cell, double direction) {
    if (std::abs(direction) < 1e-12) return 1e9;
    return ((direction > 0 ? cell + 1 : cell) * c - at) / direction;
  };
  const double every_x = std::abs(dx) < 1e-12 ? 1e9 : c / std::abs(dx);
  const double every_y = std::abs(dy) < 1e-12 ? 1e9 : c / std::abs(dy);
  double next_x = to_next(from.x_m, x, dx), next_y = to_next(from.y_m, y, dy), along_m = 0;
  while (along_m < most_m) {
    if (scene_.IsWall(x, y)) return along_m;
    if (next_x < next_y) {
      along_m = next_x;
      next_x += every_x;
      x += dx > 0 ? 1 : -1;
    } else {
      along_m = next_y;
      next_y += every_y;
      y += dy > 0 ? 1 : -1;
    }
  }
  return most_m;
}

// Where a ray meets a column, of a person or a robot; `most_m`: it does not.
double SceneWorld::ToColumn(const Ray& ray, const Column& column, double most_m) {
  const double x = column.at.x_m - ray.from.x_m, y = column.at.y_m - ray.from.y_m;
  const double c = std::cos(ray.turn_rad), s = std::sin(ray.turn_rad);
  const double down = std::cos(ray.off_rad), aside = std::sin(ray.off_rad);
  const double middle_m = x * c + y * s;
  const double square = column.radius_m * column.radius_m - std::pow(y * c - x * s, 2);
  if (square < 0) return most_m;
  // Of the way over the ground, between its sides.
  const double enters_m = std::max(0.0, middle_m - std::sqrt(square));
  const double leaves_m = middle_m + std::sqrt(square);
  if (leaves_m < 0) return most_m;
  const double to_top_m = std::max(0.0, (ray.from.z_m - column.top_m) / down);
  const double along_m = aside > 0      ? std::max(enters_m / aside, to_top_m)
                         : enters_m > 0 ? most_m
                                        : to_top_m;
  const bool below = ray.from.z_m - along_m * down < column.bottom_m;
  return below || along_m * aside > leaves_m ? most_m : std::min(most_m, along_m);
}

// Persons, who stand on the ground, robots, walls, and the ground.
double SceneWorld::DownAlong(std::size_t robot, const Point& from, double off_rad,
                             double turn_rad) const {
  const double down = std::cos(off_rad), aside = std::sin(off_rad);
  const Ray ray{from, off_rad, turn_rad};
  double nearest_m = from.z_m / down;
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const SceneMover& mover = scene_.movers[i];
    const double bottom_m = scene_.only_heads ? mover.height_m - kHeadM : 0;
    nearest_m = ToColumn(ray, {movers_[i].at, bottom_m, mover.height_m, mover.radius_m}, nearest_m);
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Point& at = bodies_[i].pose.at;
    if (i == robot) continue;
    nearest_m = ToColumn(
        ray, {at, at.z_m - kSceneBodyHeightM, at.z_m + kSceneBodyHeightM, kSceneBodyM}, nearest_m);
  }
  if (aside > 0) {
    nearest_m = std::min(nearest_m, ToWallAlong(from, turn_rad, nearest_m * aside) / aside);
  }
  return nearest_m;
}

double SceneWorld::LookDown(std::size_t robot) {
  constexpr int kRings = 4, kRaysARing = 6;
  Point from = bodies_[robot].pose.at;
  from.z_m = std::max(0.0, from.z_m - kSceneBodyHeightM);
  double nearest_m = DownAlong(robot, from, 0, 0);
  for (int ring = 1; ring <= kRings; ++ring) {
    for (int i = 0; i < kRaysARing * ring; ++i) {
      const double off_rad = kSceneConeRad / 2 * ring / kRings;
      const double turn_rad = 2 * M_PI * i / (kRaysARing * ring);
      nearest_m = std::min(nearest_m, DownAlong(robot, from, off_rad, turn_rad));
    }
  }
  std::uniform_real_distribution<double> error_m(-0.01, 0.01);
  return nearest_m < kSceneDownM ? std::max(0.0, nearest_m + error_m(random_))
                                 : std::numeric_limits<double>::infinity();
}

std::vector<float> SceneWorld::Look(std::size_t robot, double most_m) {
  constexpr int kRays = 360;
  const navigation::Pose& pose = bodies_[robot].pose;
  struct Disc {
    Point at;
    double radius_m;
  };
  std::vector<Disc> discs;
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    if (!Reaches(scene_.movers[i], pose.at.z_m)) continue;
    discs.push_back({movers_[i].at, scene_.movers[i].radius_m});
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (i != robot) discs.push_back({bodies_[i].pose.at, kSceneBodyM});
  }
  std::uniform_real_distribution<double> error_m(-0.005, 0.005);
  std::vector<float> ranges;
  for (int i = 0; i < kRays; ++i) {
    const double angle_rad = pose.yaw_rad + i * 2 * M_PI / kRays;
    double range_m = ToWallAlong(pose.at, angle_rad, most_m);
    for (const Disc& disc : discs) {
      const double x = disc.at.x_m - pose.at.x_m, y = disc.at.y_m - pose.at.y_m;
      const double along = x * std::cos(angle_rad) + y * std::sin(angle_rad);
      const double square = disc.radius_m * disc.radius_m - (x * x + y * y - along * along);
      if (along > 0 && square >= 0) range_m = std::min(range_m, along - std::sqrt(square));
    }
    if (range_m < most_m) range_m += error_m(random_);
    ranges.push_back(static_cast<float>(range_m));
  }
  return ranges;
}

}  // namespace musher::skills::testing
