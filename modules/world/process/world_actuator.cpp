#include "musher/modules/world/process/world_actuator.hpp"

#include <filesystem>
#include <optional>
#include <utility>

#include "musher/modules/world/picture/picture.hpp"
#include "musher/modules/world/scene/variation.hpp"

namespace musher::world {

WorldActuator::WorldActuator(const std::string& actuator_name, Scene scene)
    : MachineActuator(actuator_name), scene_(std::move(scene)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

WorldActuator::~WorldActuator() {
  if (node_) node_->RunOnLoop([this] { host_.reset(); });
  if (drawer_.joinable()) drawer_.join();
}

Result<> WorldActuator::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kTearDown) return TearDown();
  return Ok();
}

Result<> WorldActuator::SetUp() {
  node_ = node();
  HostOptions options;
  options.name_space = machine_config().name_space;
  options.picture_path = PicturePath();
  options.log = [this](const std::string& line) { Log(line); };
  // Only one at a time: the one before has posted its end.
  options.in_background = [this](std::function<void()> work) {
    if (drawer_.joinable()) drawer_.join();
    drawer_ = std::thread(std::move(work));
  };
  options.shooter = &shooter_;
  Result<> started;
  node_->RunOnLoop([&] {
    if (host_) return;
    auto host = WorldHost::Start(node_->node(), scene_, std::move(options));
    if (!host) {
      started = host.error();
    } else {
      host_ = std::move(host).value();
    }
  });
  if (started && !scene_.sampled.empty()) Log(SampledText(scene_));
  return started;
}

Result<> WorldActuator::TearDown() {
  if (!scene_.picture.at_teardown || !host_) return Ok();
  std::optional<World> world;
  node_->RunOnLoop([&] { world = host_->world(); });
  const std::string path = PicturePath();
  if (const Result<> drawn = Draw(*world, path); !drawn) {
    Log(drawn.error().message);  // no reason to fail TearDown
    return Ok();
  }
  Log("drawn: " + path);
  return Ok();
}

std::string WorldActuator::PicturePath() const {
  return (std::filesystem::path(machine_config().state_dir) / scene_.picture.file).string();
}

}  // namespace musher::world
