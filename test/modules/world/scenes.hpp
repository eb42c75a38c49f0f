#pragma once
// Scenes for tests: an empty yard, and one with things in it.

#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include "musher/actuator/worker.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

inline Duration Seconds(double seconds) {
  return FromSeconds(seconds);
}

// Ground that holds: no slip, no noise.
inline Scene EmptyYard() {
  Scene scene;
  scene.name = "empty yard";
  scene.least_m = {-10, -10};
  scene.most_m = {10, 10};
  scene.start_standing = true;
  scene.body.slip = 0;
  scene.body.noise = 0;
  return scene;
}

inline Scene FullYard() {
  Scene scene = EmptyYard();
  scene.body.slip = 0.05;
  scene.body.noise = 0.05;
  scene.boxes = {{"kennel", {3, 2}, {1, 0.5}, 0.4},
                 {"wall", {-3, 0}, {0.05, 3}, 0},
                 {"wall", {-1.5, 3}, {1.5, 0.05}, 0}};
  scene.circles = {{"tree", {2, -2}, 0.6}, {"post", {0, 4}, 0.1}};
  return scene;
}

// Executes work at once.
class PromptWorker : public Worker {
 public:
  void Run(Work work, Done done) override { done(work()); }
};

// Executes work when Release() is called.
class HeldWorker : public Worker {
 public:
  void Run(Work work, Done done) override {
    held_ = [work = std::move(work), done = std::move(done)] { done(work()); };
  }
  bool holds() const { return held_ != nullptr; }
  void Release() { std::exchange(held_, nullptr)(); }

 private:
  std::function<void()> held_;
};

// A commander: each command is a new one.
class Commander {
 public:
  explicit Commander(World& world) : world_(world) {}

  std::optional<std::string> Do(int mode, int gait, const Eigen::Vector3d& speed = {0, 0, 0},
                                Duration duration = {}) {
    BoardCommand command;
    command.mode = mode;
    command.gait = gait;
    command.speed = speed;
    command.duration = duration;
    command.life_count = ++life_count_;
    return world_.Command(command);
  }

  // Walks for that long, commanding as often as motion_manager does.
  void Walk(const Eigen::Vector3d& speed, Duration time, int gait = 27) {
    for (Duration done{}; done < time; done += kStep) {
      if (done % Milliseconds(40) == Duration::zero()) Do(11, gait, speed);
      world_.Step();
    }
  }

 private:
  World& world_;
  std::int8_t life_count_ = 0;
};

inline void Pass(World& world, Duration time) {
  for (Duration done{}; done < time; done += kStep) world.Step();
}

}  // namespace musher::world
