#include "musher/modules/world/process/world_alone.hpp"

#include <pthread.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "musher/actuator/worker.hpp"
#include "musher/base/joined.hpp"
#include "musher/modules/world/picture/picture.hpp"
#include "musher/modules/world/process/world_host.hpp"
#include "musher/modules/world/render/shot.hpp"
#include "musher/modules/world/scene/variation.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/wire/node_services.hpp"

namespace musher::world {
namespace {

void Print(const std::string& line) {
  std::cerr << "world: " << line << std::endl;
}

int DrawTo(const World& world, const std::string& path) {
  const Result<> drawn = Draw(world, path);
  Print(drawn ? "drawn: " + path : drawn.error().message);
  return drawn ? 0 : 1;
}

World Played(const Scene& scene, Duration time) {
  if (!scene.sampled.empty()) Print(SampledText(scene));
  World world(scene);
  while (world.now() < time) {
    for (const std::string& line : world.Step().log) Print(line);
  }
  return world;
}

}  // namespace

int RunAlone(const Scene& scene, const std::string& name_space) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  transport::DdsOptions dds;
  dds.name_space = name_space;
  dds.node_name = "world";
  const auto node = transport::NodeThread::Start(dds);
  if (!node) {
    Print(node.error().message);
    return 1;
  }
  std::thread drawer;
  HostOptions options;
  options.name_space = name_space;
  options.picture_path = std::filesystem::absolute(scene.picture.file).string();
  options.log = Print;
  options.in_background = [&drawer](std::function<void()> work) {
    if (drawer.joinable()) drawer.join();
    drawer = std::thread(std::move(work));
  };
  WorkerThread shooter;
  options.shooter = &shooter;
  std::unique_ptr<WorldHost> host;
  std::optional<transport::NodeServices> services;
  std::string why_not;
  node.value()->RunOnLoop([&] {
    auto started = WorldHost::Start(node.value()->node(), scene, std::move(options));
    if (started) {
      host = std::move(started).value();
      services.emplace(node.value()->node(), transport::ResolveName(name_space, dds.node_name),
                       std::vector<transport::NodeParameter>());
    } else {
      why_not = started.error().message;
    }
  });
  if (!host) {
    Print(why_not);
    return 1;
  }
  Print("\"" + scene.name + "\" runs; " + SampledText(scene) + "; Ctrl+C ends it");
  int signal = 0;
  sigwait(&signals, &signal);
  std::optional<World> world;
  node.value()->RunOnLoop([&] {
    world = host->world();
    services.reset();
    host.reset();
  });
  if (drawer.joinable()) drawer.join();
  return scene.picture.at_teardown ? DrawTo(*world, scene.picture.file) : 0;
}

int DrawScene(const Scene& scene, Duration time, const std::string& path) {
  return DrawTo(Played(scene, time), path);
}

int ShootScene(const Scene& scene, Duration time, const std::string& camera,
               const std::string& path) {
  std::vector<std::string> names;
  for (const std::string_view name : kCameraNames) {
    if (scene.has_body) names.emplace_back(name);
  }
  const std::size_t robots_from = names.size();
  std::vector<std::size_t> robots;  // with a camera
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    if (!scene.robots[i].camera) continue;
    robots.push_back(i);
    names.push_back(scene.robots[i].name);
  }
  const auto named = std::find(names.begin(), names.end(), camera);
  if (named == names.end()) {
    Print("there is no camera \"" + camera + "\"; the cameras are " + Joined(names, "none"));
    return 2;
  }
  const auto index = static_cast<std::size_t>(named - names.begin());
  const World world = Played(scene, time);
  const auto image = index < robots_from ? TakeShot(world, index)
                                         : TakeShotOfRobot(world, robots.at(index - robots_from));
  const Result<> saved = image ? SaveImage(image.value(), path) : Result<>(image.error());
  Print(saved ? "drawn: " + path : saved.error().message);
  return saved ? 0 : 1;
}

}  // namespace musher::world
