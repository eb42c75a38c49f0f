#include "musher/modules/world/picture/fleet_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "musher/modules/world/paint/palette.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;

constexpr double kName = 11;
constexpr double kDash = 6;  // pixels
constexpr double kDrivenWidth = 3;
constexpr double kPlannedWidth = 1.6;

void Dashed(const std::vector<Pixel>& points, const Color& color, double width, Canvas& canvas) {
  double along = 0;  // pixels since the first point
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Pixel way = points[i + 1] - points[i];
    const double length = way.norm();
    double at = 0;
    while (at < length) {
      const double in_dash = std::fmod(along + at, 2 * kDash);
      const double to = std::min(length, at + (in_dash < kDash ? kDash : 2 * kDash) - in_dash);
      if (in_dash < kDash) {
        canvas.Line(points[i] + way * (at / length), points[i] + way * (to / length), color, width);
      }
      at = std::max(to, at + 1e-3);
    }
    along += length;
  }
}

std::vector<Pixel> Pixels(const std::vector<Vector2d>& points, const ToPixel& at) {
  std::vector<Pixel> pixels;
  pixels.reserve(points.size());
  for (const Vector2d& point : points) pixels.push_back(at(point));
  return pixels;
}

// Its name stands out from what is below it.
void NameBeside(const std::string& name, const Pixel& at, const Color& color, Canvas& canvas) {
  const double half = canvas.TextWidth(name, kName) / 2;
  canvas.FillRect(at + Pixel(-half - 3, -kName), at + Pixel(half + 3, 3), kPaper);
  canvas.Text(name, at, kName, color, Align::kCenter);
}

void DrawSolid(const Solid& solid, const ToPixel& at, double scale, Canvas& canvas) {
  if (const auto* circle = std::get_if<Circle>(&solid.shape)) {
    canvas.Disc(at(circle->center_m), circle->radius_m * scale, circle->color);
    canvas.Ring(at(circle->center_m), circle->radius_m * scale, Mix(circle->color, kInk, 0.4), 1.2);
    return;
  }
  const Box& box = std::get<Box>(solid.shape);
  const Rotation2Dd turn(box.yaw_rad);
  std::vector<Pixel> corners;
  for (const auto& [x, y] :
       {std::pair(1, 1), std::pair(-1, 1), std::pair(-1, -1), std::pair(1, -1)}) {
    corners.push_back(at(box.center_m + turn * Vector2d(x * box.half_m.x(), y * box.half_m.y())));
  }
  canvas.Fill(corners, box.color);
  canvas.Outline(corners, Mix(box.color, kInk, 0.4), 1.2);
}

void DrawRobot(const World& world, std::size_t index, const ToPixel& at, double scale,
               Canvas& canvas) {
  const RobotSpec& spec = world.scene().robots[index];
  const FleetRobot& robot = world.fleet().robots()[index];
  const Pixel middle = at(robot.body.position_m().head<2>());
  const double radius = std::max(spec.radius_m * scale, 5.0);
  const double yaw = robot.body.yaw_rad();
  const Pixel ahead(std::cos(yaw), -std::sin(yaw));
  if (spec.kind == RobotKind::kFlyer) {  // four rotors
    const Pixel aside(-ahead.y(), ahead.x());
    for (const auto& [x, y] :
         {std::pair(1, 1), std::pair(-1, 1), std::pair(-1, -1), std::pair(1, -1)}) {
      const Pixel rotor = middle + (ahead * x + aside * y) * radius * 0.8;
      canvas.Line(middle, rotor, kInk, 2);
      canvas.Disc(rotor, radius * 0.5, spec.color);
      canvas.Ring(rotor, radius * 0.5, kInk, 1);
    }
    canvas.Disc(middle, radius * 0.4, kInk);
  } else {
    canvas.Disc(middle, radius, spec.color);
    canvas.Ring(middle, radius, kInk, 1.4);
  }
  canvas.Line(middle, middle + ahead * radius * 1.3, kPaper, 2);
}

void NameRobot(const World& world, std::size_t index, const ToPixel& at, double scale,
               Canvas& canvas) {
  const RobotSpec& spec = world.scene().robots[index];
  const FleetRobot& robot = world.fleet().robots()[index];
  const Pixel middle = at(robot.body.position_m().head<2>());
  const double radius = std::max(spec.radius_m * scale, 5.0);
  std::string name = spec.name;
  if (robot.body.airborne()) {
    char height[24];
    std::snprintf(height, sizeof(height), ", %.1f m up", robot.body.position_m().z());
    name += height;
  }
  if (robot.holds) name += " with " + world.scene().objects[*robot.holds].name;
  NameBeside(name, middle + Pixel(0, radius * 1.4 + 14), spec.color, canvas);
}

void CrossCollisions(const Track& track, const ToPixel& at, Canvas& canvas) {
  for (const Bump& bump : track.bumps()) {
    const Pixel where = at(bump.where_m);
    canvas.Line(where - Pixel(5, 5), where + Pixel(5, 5), kBumpRed, 2);
    canvas.Line(where + Pixel(-5, 5), where + Pixel(5, -5), kBumpRed, 2);
  }
}

}  // namespace

void DrawFleetWays(const World& world, const ToPixel& at, Canvas& canvas) {
  const Scene& scene = world.scene();
  for (const MoverSpec& mover : scene.movers) {
    std::vector<Vector2d> points = mover.points_m;
    if (mover.round_trip) points.push_back(points.front());
    Dashed(Pixels(points, at), Mix(mover.color, kGround, 0.5), 1.4, canvas);
  }
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const FleetRobot& robot = world.fleet().robots()[i];
    const Color color = scene.robots[i].color;
    std::vector<Pixel> way;
    for (const Sample& sample : robot.track.samples()) {
      way.push_back(at(sample.pose.position_m));
    }
    way.push_back(at(robot.body.position_m().head<2>()));
    canvas.Polyline(way, Mix(color, kPaper, 0.25), kDrivenWidth);
    canvas.Ring(way.front(), 5, color, 2);
    Dashed(Pixels(robot.planned_m, at), Mix(color, kInk, 0.6), kPlannedWidth, canvas);
  }
}

// Names last: no body hides them.
void DrawFleet(const World& world, const ToPixel& at, double scale, Canvas& canvas) {
  const Scene& scene = world.scene();
  const Fleet& fleet = world.fleet();
  for (std::size_t i = 0; i < scene.movers.size(); ++i) {
    DrawSolid(SolidOf(scene.movers[i], fleet.movers()[i]), at, scale, canvas);
  }
  for (std::size_t i = 0; i < scene.robots.size(); ++i) DrawRobot(world, i, at, scale, canvas);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    DrawSolid(SolidOf(scene.objects[i], fleet.objects()[i]), at, scale, canvas);
  }
  for (const FleetRobot& robot : fleet.robots()) CrossCollisions(robot.track, at, canvas);
  for (std::size_t i = 0; i < scene.movers.size(); ++i) {
    const MoverSpec& spec = scene.movers[i];
    const Pixel below(0, spec.radius_m * scale + 14);
    NameBeside(spec.name, at(fleet.movers()[i].position_m()) + below, spec.color, canvas);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const FleetObject& object = fleet.objects()[i];
    if (object.held_by) continue;  // its robot's name has it
    const Pixel below(0, scene.objects[i].size_m.head<2>().norm() / 2 * scale + 13);
    NameBeside(scene.objects[i].name, at(object.middle_m.head<2>()) + below, kInk, canvas);
  }
  for (std::size_t i = 0; i < scene.robots.size(); ++i) NameRobot(world, i, at, scale, canvas);
}

Pixel DrawFleetLegend(const World& world, const Pixel& corner, Canvas& canvas) {
  constexpr double kRow = 24;
  constexpr double kLetters = 12;
  const Scene& scene = world.scene();
  Pixel at = corner;
  canvas.Text("Robots: driven way, battery", at, 13, kInk);
  at.y() += kRow;
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const FleetRobot& robot = world.fleet().robots()[i];
    char facts[48];
    std::snprintf(facts, sizeof(facts), "%.1f m   %.0f %%", robot.driven_m,
                  robot.battery.percent());
    canvas.FillRect(at + Pixel(0, -9), at + Pixel(26, 1), scene.robots[i].color);
    canvas.Text(scene.robots[i].name, at + Pixel(38, 0), kLetters, kInk);
    canvas.Text(facts, at + Pixel(236, 0), kLetters, kGreyInk, Align::kRight);
    at.y() += kRow;
  }
  const auto row = [&](const std::string& text) {
    canvas.Text(text, at + Pixel(38, 0), kLetters, kInk);
    at.y() += kRow;
  };
  at.y() += kRow / 2;
  canvas.Ring(at + Pixel(13, -4), 5, kInk, 2);
  row("where a robot began");
  canvas.Line(at + Pixel(0, -4), at + Pixel(26, -4), kGreyInk, kDrivenWidth);
  row("way that it has driven");
  Dashed({at + Pixel(0, -4), at + Pixel(26, -4)}, kInk, kPlannedWidth, canvas);
  row("path that was planned last");
  if (!scene.movers.empty()) {
    Dashed({at + Pixel(0, -4), at + Pixel(26, -4)}, Mix(scene.movers[0].color, kGround, 0.5), 1.4,
           canvas);
    row("way of what moves by itself");
  }
  int collisions = 0;
  for (const FleetRobot& robot : world.fleet().robots()) collisions += robot.collisions;
  canvas.Line(at + Pixel(8, -9), at + Pixel(18, 1), kBumpRed, 2);
  canvas.Line(at + Pixel(8, 1), at + Pixel(18, -9), kBumpRed, 2);
  row("collision (" + std::to_string(collisions) + ")");
  return at;
}

}  // namespace musher::world
