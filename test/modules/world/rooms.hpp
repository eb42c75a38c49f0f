#pragma once
// A place with robots for tests: a yard of 10 by 10 m, a robot with a hand on the ground, a second
// one, and a flyer.

#include "musher/test/modules/world/scenes.hpp"

namespace musher::world {

inline RobotSpec GroundRobot(const std::string& name, double x_m, double y_m) {
  RobotSpec robot;
  robot.name = name;
  robot.start_m = {x_m, y_m, 0};
  robot.lidar.reach.noise_m = 0;
  return robot;
}

inline RobotSpec FlyingRobot(const std::string& name, double x_m, double y_m) {
  RobotSpec robot = GroundRobot(name, x_m, y_m);
  robot.kind = RobotKind::kFlyer;
  robot.radius_m = 0.15;
  robot.height_m = 0.1;
  return robot;
}

inline ObjectSpec BoxOf(const std::string& name, const Eigen::Vector3d& middle_m) {
  ObjectSpec object;
  object.name = name;
  object.category = "box";
  object.middle_m = middle_m;
  return object;
}

inline Scene RobotYard() {
  Scene scene;
  scene.name = "robot yard";
  scene.has_body = false;
  scene.least_m = {-5, -5};
  scene.most_m = {5, 5};
  scene.ceiling_m = 2.4;
  scene.robots = {GroundRobot("jetbot_0", 0, 0), GroundRobot("jetbot_1", 0, 3),
                  FlyingRobot("cf2x_0", -3, 0)};
  scene.robots[0].hand.emplace();
  return scene;
}

// Commands the robot that velocity ten times a second, for that long.
inline void DriveFor(World& world, std::size_t robot, const BodyVelocity& velocity, Duration time) {
  for (Duration done{}; done < time; done += kStep) {
    if (done % Milliseconds(100) == Duration::zero()) world.Drive(robot, velocity);
    world.Step();
  }
}

}  // namespace musher::world
