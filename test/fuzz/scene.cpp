// A scene file of musher-world, and a life in it: what comes after a zero byte are commands for the
// body, eight bytes each.

#include <algorithm>
#include <cmath>

#include "musher/modules/world/place.hpp"
#include "musher/modules/world/scene_toml.hpp"
#include "musher/modules/world/world.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::world {
namespace {

using fuzz::Require;

constexpr std::size_t kCommandSize = 8;
constexpr int kStepsOfACommand = 25;

double Speed(char byte) {
  return byte / 50.0;
}

BoardCommand CommandIn(std::string_view bytes) {
  BoardCommand command;
  command.mode = bytes[0];
  command.gait = bytes[1];
  command.life_count = static_cast<std::int8_t>(bytes[2]);
  command.speed = {Speed(bytes[3]), Speed(bytes[4]), Speed(bytes[5])};
  command.attitude = command.speed;
  command.duration = Milliseconds(100) * static_cast<std::uint8_t>(bytes[6]);
  return command;
}

void RequireSense(const World& world) {
  const Body& body = world.body();
  Require(IsFree(world.scene(), body.pose().position_m), "no body is inside an obstacle");
  const double percent = world.battery().percent();
  Require(percent >= 0 && percent <= 100, "a battery is within 0 and 100 %");
  Require(body.progress_percent() >= 0 && body.progress_percent() <= 100, "progress is in %");
  Require(body.speed().allFinite() && body.turn_rate().allFinite() &&
              body.acceleration().allFinite() && std::isfinite(body.pose().yaw_rad) &&
              body.odometry().position_m.allFinite() && std::isfinite(body.motor_temperature_c(0)),
          "what a body reports are numbers");
}

void Live(const Scene& scene, std::string_view commands) {
  World world(scene);
  while (commands.size() >= kCommandSize) {
    static_cast<void>(world.Command(CommandIn(commands)));
    const char extra = commands[7];
    if (extra == 1) world.Plug(true);
    if (extra == 2) world.SetMotorPower(false);
    if (extra == 3) world.SetMotorPower(true);
    if (extra == 4) static_cast<void>(world.SetBattery(Speed(commands[3]) * 50));
    for (int i = 0; i < kStepsOfACommand; ++i) {
      world.Step();
      RequireSense(world);
    }
    commands.remove_prefix(kCommandSize);
  }
}

void Judge(std::string_view text, std::string_view commands) {
  const SceneReading reading = ReadSceneText(text, "/scenes/yard.toml");
  const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    Require(diagnostic.line >= 0 && diagnostic.line <= lines, "a diagnostic is inside the file");
  }
  Require(reading.scene.has_value() != HasError(reading.diagnostics),
          "there is a scene, or an error says why not");
  if (reading.scene) Live(*reading.scene, commands);
}

}  // namespace
}  // namespace musher::world

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  musher::world::Judge(bytes.substr(0, end), bytes.substr(std::min(end + 1, bytes.size())));
  return 0;
}
