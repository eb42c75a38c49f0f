// A scene file of musher-world, and a run in it: after a zero byte come commands for the body, or
// for a humanoid's pose and gaze, eight bytes each.

#include <algorithm>
#include <cmath>

#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/modules/world/simulation/world.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::world {
namespace {

using fuzz::Require;

constexpr std::size_t kCommandSize = 8;
constexpr int kStepsOfACommand = 25;
constexpr const char* kPath = "/scenes/yard.toml";

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

void RequireValid(const World& world) {
  const Body& body = world.body();
  Require(IsFree(world.scene(), body.pose().position_m), "no body is inside an obstacle");
  const double percent = world.battery().percent();
  Require(percent >= 0 && percent <= 100, "a battery is within 0 and 100 %");
  Require(body.progress_percent() >= 0 && body.progress_percent() <= 100,
          "progress is within 0 and 100 %");
  Require(body.speed().allFinite() && body.turn_rate().allFinite() &&
              body.acceleration().allFinite() && std::isfinite(body.pose().yaw_rad) &&
              body.odometry().position_m.allFinite() && std::isfinite(body.motor_temperature_c(0)),
          "a body reports finite numbers");
  const double apart_m = world.scene().body.radius_m + kGuestRadiusM - 1e-6;
  for (const Guest& guest : world.guests()) {
    Require(!guest.here || (guest.position_m - body.pose().position_m).norm() >= apart_m,
            "no guest is in the robot's place");
  }
  if (!world.humanoid()) return;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Joint& joint = JointTable()[i];
    const Axis& axis = world.humanoid()->joints()[i];
    const MotionLimits& limits =
        world.scene().humanoid->limits[static_cast<std::size_t>(joint.group)];
    Require(axis.position_rad >= joint.least_rad - 1e-6 &&
                axis.position_rad <= joint.most_rad + 1e-6 &&
                std::abs(axis.speed_rad_s) <= limits.speed_rad_s + 1e-6,
            "joints stay within their limits");
  }
}

void RunCommands(const Scene& scene, std::string_view commands) {
  World world(scene);
  while (commands.size() >= kCommandSize) {
    static_cast<void>(world.Command(CommandIn(commands)));
    const char extra = commands[7];
    if (extra == 1) world.Plug(true);
    if (extra == 2) world.SetMotorPower(false);
    if (extra == 3) world.SetMotorPower(true);
    if (extra == 4) static_cast<void>(world.SetBattery(Speed(commands[3]) * 50));
    if (extra == 5) static_cast<void>(world.LookAt({Speed(commands[3]), Speed(commands[4])}));
    if (extra == 6) static_cast<void>(world.SetPose(std::string(commands.substr(0, 7))));
    for (int i = 0; i < kStepsOfACommand; ++i) {
      world.Step();
      RequireValid(world);
    }
    commands.remove_prefix(kCommandSize);
  }
}

void CheckScene(std::string_view text, std::string_view commands) {
  const SceneReading reading = ReadSceneText(text, kPath);
  const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    const bool of_poses = diagnostic.file != kPath;  // poses have a file of their own
    Require(diagnostic.line >= 0 && (of_poses || diagnostic.line <= lines),
            "a diagnostic is inside the file");
  }
  Require(reading.scene.has_value() != HasError(reading.diagnostics), "either a scene or an error");
  if (reading.scene) RunCommands(*reading.scene, commands);
}

}  // namespace
}  // namespace musher::world

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  musher::world::CheckScene(bytes.substr(0, end), bytes.substr(std::min(end + 1, bytes.size())));
  return 0;
}
