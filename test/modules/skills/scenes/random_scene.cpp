#include "musher/test/modules/skills/scenes/random_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "musher/test/modules/skills/scenes/scene_world.hpp"

namespace musher::skills::testing {
namespace {

using navigation::Point;

constexpr double kOfFlightsM = 1;       // the height of flights
constexpr double kFlyers = 0.2;         // share of the scenes
constexpr double kPersonM = 0.25;       // the radius of a person
constexpr double kPersonsApartM = 1.5;  // from where a robot starts
constexpr double kRobotsApartM = 1.2;
constexpr int kTries = 200;  // for a place

// A place of the grid; y to the top, as of Scene::At().
struct Square {
  int x = 0, y = 0;
};
// As one value, whose random numbers every compiler draws in the same order: those of arguments it
// may not.
struct Patch {
  Square from, size;
};

class SceneMaker {
 public:
  explicit SceneMaker(std::uint64_t seed) : random_(seed) {}

  Scene Make() {
    scene_.expects = Scene::Expects::kEnds;
    scene_.limit_s = 300;
    scene_.flies = Chance(kFlyers);
    switch (Below(5)) {
      case 0:
        MakeHall();
        break;
      case 1:
        MakeRooms();
        break;
      case 2:
        MakeCorridor();
        break;
      case 3:
        MakeMaze();
        break;
      default:
        MakeTraps();
    }
    if (scene_.flies) Note("flyer");
    MakeMapWrong();
    AddRobots();
    AddPersons();
    AddFault();
    return std::move(scene_);
  }

 private:
  int Below(int count) { return static_cast<int>(random_() % static_cast<std::uint64_t>(count)); }
  int From(int least, int most) { return least + Below(most - least + 1); }
  double Between(double least, double most) {
    return least + (most - least) * (static_cast<double>(random_() % 10'001) / 10'000);
  }
  bool Chance(double share) { return Between(0, 1) < share; }

  void Note(const std::string& word) { scene_.name += (scene_.name.empty() ? "" : ", ") + word; }

  char& At(const Square& at) {
    return scene_
        .map[static_cast<std::size_t>(scene_.height() - 1 - at.y)][static_cast<std::size_t>(at.x)];
  }

  void Fill(const Patch& patch, char with, bool only_free = false) {
    const auto& [from, size] = patch;
    for (int y = from.y; y < from.y + size.y; ++y) {
      for (int x = from.x; x < from.x + size.x; ++x) {
        const bool inside = x > 0 && y > 0 && x < scene_.width() - 1 && y < scene_.height() - 1;
        if (inside && (!only_free || At({x, y}) == '.')) At({x, y}) = with;
      }
    }
  }

  void Blank(const Square& size, char with) {
    scene_.map.assign(static_cast<std::size_t>(size.y),
                      std::string(static_cast<std::size_t>(size.x), '#'));
    Fill({{1, 1}, {size.x - 2, size.y - 2}}, with);
  }

  void MakeHall() {
    Note("hall");
    Blank({From(22, 40), From(18, 30)}, '.');
    const int boxes = scene_.width() * scene_.height() / From(50, 120);
    for (int i = 0; i < boxes; ++i) {
      Fill({{Below(scene_.width()), Below(scene_.height())}, {From(1, 5), From(1, 5)}}, '#');
    }
  }

  // Walls over the whole height or width, each with a door or two.
  void MakeRooms() {
    Note("rooms");
    Blank({From(26, 42), From(18, 30)}, '.');
    for (int x = From(8, 11); x < scene_.width() - 7; x += From(8, 12)) {
      Fill({{x, 1}, {1, scene_.height() - 2}}, '#');
      for (int door = From(1, 2); door > 0; --door) {
        Fill({{x, From(2, scene_.height() - 8)}, {1, From(2, 5)}}, '.');
      }
    }
    if (!Chance(0.5)) return;
    const int y = From(7, scene_.height() - 8);
    Fill({{1, y}, {scene_.width() - 2, 1}}, '#');
    for (int x = From(2, 5); x < scene_.width() - 5; x += From(6, 10)) {
      Fill({{x, y}, {From(2, 5), 1}}, '.');
    }
  }

  // A room at each end, bays aside.
  void MakeCorridor() {
    Note("corridor");
    Blank({From(30, 46), 21}, '#');
    const int wide = From(3, 6), room = From(6, 9), y = 10 - wide / 2;
    Fill({{1, y}, {scene_.width() - 2, wide}}, '.');
    Fill({{1, 4}, {room, 13}}, '.');
    Fill({{scene_.width() - 1 - room, 4}, {room, 13}}, '.');
    for (int bay = Below(3); bay > 0; --bay) {
      const int x = From(room + 2, scene_.width() - room - 7);
      Fill({{x, Chance(0.5) ? y + wide : y - 4}, {From(3, 5), 4}}, '.');
    }
  }

  // Ways of three squares, between walls of one; some walls are taken out.
  void MakeMaze() {
    Note("maze");
    const int columns = From(3, 8), rows = From(3, 6);
    Blank({4 * columns + 1, 4 * rows + 1}, '#');
    std::vector<bool> seen(static_cast<std::size_t>(columns * rows), false);
    std::vector<Square> way = {{0, 0}};
    const auto visit = [&](const Square& room) {
      seen[static_cast<std::size_t>(room.y * columns + room.x)] = true;
      Fill({{4 * room.x + 1, 4 * room.y + 1}, {3, 3}}, '.');
    };
    visit({0, 0});
    while (!way.empty()) {
      std::vector<Square> next;
      for (const Square& step : {Square{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const Square room{way.back().x + step.x, way.back().y + step.y};
        const bool inside = room.x >= 0 && room.y >= 0 && room.x < columns && room.y < rows;
        if (inside && !seen[static_cast<std::size_t>(room.y * columns + room.x)]) {
          next.push_back(step);
        }
      }
      if (next.empty()) {
        way.pop_back();
        continue;
      }
      const Square step = next[static_cast<std::size_t>(Below(static_cast<int>(next.size())))];
      const Square from = way.back();
      way.push_back({from.x + step.x, from.y + step.y});
      visit(way.back());
      Fill({{4 * from.x + 1 + 2 * step.x, 4 * from.y + 1 + 2 * step.y}, {3, 3}}, '.');
    }
    for (int i = Below(4); i > 0; --i) {
      Fill({{4 * From(1, columns - 1), 4 * Below(rows) + 1}, {1, 3}}, '.');
    }
  }

  // Us that are open to one of four sides.
  void MakeTraps() {
    Note("U traps");
    Blank({From(28, 42), From(22, 30)}, '.');
    for (int i = From(1, 3); i > 0; --i) {
      const Square at{From(3, scene_.width() - 14), From(3, scene_.height() - 14)};
      const Square size{From(5, 11), From(5, 11)};
      // In the map, or not.
      const char wall = Chance(0.5) ? '#' : 'x';
      Fill({at, size}, wall);
      Fill({{at.x + 1, at.y + 1}, {size.x - 2, size.y - 2}}, '.');
      switch (Below(4)) {
        case 0:
          Fill({{at.x, at.y + 1}, {1, size.y - 2}}, '.');
          break;
        case 1:
          Fill({{at.x + size.x - 1, at.y + 1}, {1, size.y - 2}}, '.');
          break;
        case 2:
          Fill({{at.x + 1, at.y}, {size.x - 2, 1}}, '.');
          break;
        default:
          Fill({{at.x + 1, at.y + size.y - 1}, {size.x - 2, 1}}, '.');
      }
    }
  }

  void MakeMapWrong() {
    if (Chance(0.4)) return;
    constexpr std::array<std::pair<char, const char*>, 3> kKinds{
        {{'x', "map lacks a box"}, {'o', "map has a box too many"}, {'%', "late map"}}};
    const auto& [with, word] = kKinds[static_cast<std::size_t>(Below(3))];
    for (int i = From(1, 3); i > 0; --i) {
      Fill({{From(2, scene_.width() - 3), From(2, scene_.height() - 3)}, {From(1, 4), From(1, 4)}},
           with, true);
    }
    Note(word);
    if (with != '%') return;
    scene_.map_is_late = Chance(0.2);
    for (int i = From(1, 3); i > 0; --i) {
      scene_.events.push_back({.kind = SceneEvent::Kind::kMap, .at_s = Between(0.5, 25)});
    }
  }

  bool IsFree(const Square& at, int around) const {
    for (int y = at.y - around; y <= at.y + around; ++y) {
      for (int x = at.x - around; x <= at.x + around; ++x) {
        if (scene_.IsWall(x, y)) return false;
      }
    }
    return true;
  }

  Square AnySquare() { return {From(1, scene_.width() - 2), From(1, scene_.height() - 2)}; }
  Point Middle(const Square& at) const {
    return {(at.x + 0.5) * scene_.cell_m, (at.y + 0.5) * scene_.cell_m,
            scene_.flies ? kOfFlightsM : 0};
  }
  static double Apart(const Point& a, const Point& b) {
    return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
  }
  double ToRobots(const Point& place) const {
    double least_m = 1e9;
    for (const SceneRobot& robot : scene_.robots) {
      least_m = std::min(least_m, Apart(robot.start.at, place));
    }
    return least_m;
  }

  // 1 to 4 cm from a wall, if the second square in some direction is one.
  void MoveToWall(const Square& at, Point& place) {
    const double gap_m = 1.5 * scene_.cell_m - kSceneBodyM - Between(0.01, 0.04);
    for (const Square& to : {Square{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (!scene_.IsWall(at.x + 2 * to.x, at.y + 2 * to.y)) continue;
      place.x_m += to.x * gap_m;
      place.y_m += to.y * gap_m;
      Note("tight start");
      return;
    }
  }

  void AddRobots() {
    const int count = Chance(0.65) ? 1 : Chance(0.75) ? 2 : 3;
    for (int i = 0; i < count; ++i) {
      SceneRobot robot;
      Square start, goal;
      int tries = 0;
      do {
        start = AnySquare();
        goal = AnySquare();
      } while (++tries < kTries &&
               !(IsFree(start, 1) && IsFree(goal, 0) && ToRobots(Middle(start)) > kRobotsApartM &&
                 Apart(Middle(start), Middle(goal)) > 2));
      if (tries == kTries) break;
      robot.start = {Middle(start), Between(-M_PI, M_PI)};
      robot.goal = {Middle(goal), 0};
      robot.priority = Chance(0.3) ? From(-2, 2) : 0;
      if (Chance(0.15)) MoveToWall(start, robot.start.at);
      scene_.robots.push_back(robot);
    }
    if (scene_.robots.empty()) return MakeRoomForOne();
    if (scene_.robots.size() > 1) Note(std::to_string(scene_.robots.size()) + " robots");
  }

  // The drawing has left no place for a robot.
  void MakeRoomForOne() {
    Fill({{2, 2}, {scene_.width() - 4, 5}}, '.');
    scene_.robots.push_back({{Middle({4, 4}), 0}, {Middle({scene_.width() - 5, 4}), 0}, 0});
  }

  // Whether a person can go there straight on.
  bool CanWalk(const Point& from, const Point& to) const {
    const int steps = static_cast<int>(Apart(from, to) / 0.1) + 1;
    for (int step = 0; step <= steps; ++step) {
      const Point at = navigation::Between(from, to, static_cast<double>(step) / steps);
      for (int corner = 0; corner < 8; ++corner) {
        const double angle_rad = corner * M_PI / 4;
        const double x = at.x_m + (kPersonM + 0.1) * std::cos(angle_rad);
        const double y = at.y_m + (kPersonM + 0.1) * std::sin(angle_rad);
        if (scene_.IsWall(static_cast<int>(x / scene_.cell_m),
                          static_cast<int>(y / scene_.cell_m))) {
          return false;
        }
      }
    }
    return true;
  }

  void AddPersons() {
    const int wanted = Chance(0.45) ? 0 : From(1, 3);
    for (int i = 0; i < wanted; ++i) {
      SceneMover person;
      Point last{};
      for (int tries = 0; tries < kTries && person.path.size() < 3; ++tries) {
        const Point place = Middle(AnySquare());
        const bool first = person.path.empty();
        if (first ? ToRobots(place) < kPersonsApartM : Apart(last, place) < 1) continue;
        if (!CanWalk(first ? place : last, place)) continue;
        if (first && TouchesPerson(place)) continue;
        person.path.push_back(last = place);
      }
      if (person.path.empty()) continue;
      person.speed_m_s = Between(0.2, 1.2);
      person.begins_s = Between(0, 10);
      person.waits_s = Chance(0.5) ? 0 : Between(1, 30);
      person.stays = Chance(0.3);
      scene_.movers.push_back(std::move(person));
    }
    const std::size_t count = scene_.movers.size();
    if (count > 0) Note(std::to_string(count) + (count == 1 ? " person" : " persons"));
  }

  bool TouchesPerson(const Point& place) const {
    return std::ranges::any_of(scene_.movers, [&](const SceneMover& other) {
      return Apart(other.path.front(), place) < 2 * kPersonM;
    });
  }

  void AddFault() {
    if (Chance(0.55)) return;
    using Kind = SceneEvent::Kind;
    constexpr std::array<std::pair<Kind, const char*>, 6> kKinds{
        {{Kind::kJump, "jump"},
         {Kind::kJump, "jump"},
         {Kind::kFreeze, "frozen odometry"},
         {Kind::kNoOdometry, "no odometry"},
         {Kind::kNoScan, "no scan"},
         {Kind::kStuck, "stuck"}}};
    const auto& [kind, word] = kKinds[static_cast<std::size_t>(Below(6))];
    SceneEvent event{.kind = kind, .at_s = Between(0.5, 20)};
    event.lasts_s = Chance(0.3) ? 0 : Between(0.5, 8);
    if (kind == Kind::kJump) {
      const double far_m = Chance(0.2) ? Between(5, 30) : Between(0.1, 3);
      const double angle_rad = Between(-M_PI, M_PI);
      event.x_m = far_m * std::cos(angle_rad);
      event.y_m = far_m * std::sin(angle_rad);
    }
    scene_.events.push_back(event);
    Note(word);
  }

  std::mt19937_64 random_;
  Scene scene_;
};

}  // namespace

Scene LandingScene(std::uint64_t seed) {
  constexpr double kAboveHeadsM = 2;
  Scene scene = RandomScene(seed);
  if (!scene.flies) return scene;
  std::mt19937_64 random(seed);
  scene.lands = true;
  scene.name += ", landing";
  for (SceneRobot& robot : scene.robots) {
    robot.start.at.z_m = robot.goal.at.z_m = kAboveHeadsM;
  }
  for (SceneMover& mover : scene.movers) {
    mover.height_m = 0.9 + 0.7 * static_cast<double>(random() % 1000) / 1000;
  }
  return scene;
}

Scene RandomScene(std::uint64_t seed) {
  return SceneMaker(seed).Make();
}

}  // namespace musher::skills::testing
