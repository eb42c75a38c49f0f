#include "musher/modules/world/scene/variation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "musher/transport/sim/random.hpp"

namespace musher::world {
namespace {

constexpr double kMostSlip = 0.9;
constexpr double kLeastK = 1500;
constexpr double kMostK = 20'000;
constexpr double kMostBrightness = 10;
constexpr double kMostNoise = 64;
constexpr double kRadInDeg = M_PI / 180;

std::string NumberAs(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

class Sampler {
 public:
  explicit Sampler(Scene& scene) : scene_(scene) {}

  // From -limit to limit.
  double Deviation(const std::string& name, double limit) const {
    constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
    const double share = static_cast<double>(SampleOf(scene_.seed, name) >> 11) * kUnit;
    return limit * (2 * share - 1);
  }

  void Add(const std::string& name, double limit, double least, double most, double& value) {
    if (limit == 0) return;
    value = std::clamp(value + Deviation(name, limit), least, most);
    Note(name, NumberAs("%.4g", value));
  }

  void AddAngle(const std::string& name, double limit_rad, double& value_rad) {
    if (limit_rad == 0) return;
    value_rad = std::remainder(value_rad + Deviation(name, limit_rad), 2 * M_PI);
    Note(name, NumberAs("%.1f", value_rad / kRadInDeg));
  }

  void Note(const std::string& name, const std::string& value) {
    scene_.sampled.push_back({name, value});
  }

 private:
  Scene& scene_;
};

}  // namespace

std::uint64_t SampleOf(std::uint64_t seed, std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char letter : name) hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3;
  transport::sim::Random of_scene(seed);
  return transport::sim::Random(of_scene.Next() ^ hash).Next();
}

void Vary(const Variation& by, Scene& scene) {
  Sampler sampler(scene);
  const double infinity = HUGE_VAL;
  sampler.Add("start_x_m", by.start_m, -infinity, infinity, scene.start.position_m.x());
  sampler.Add("start_y_m", by.start_m, -infinity, infinity, scene.start.position_m.y());
  sampler.AddAngle("start_yaw_deg", by.start_rad, scene.start.yaw_rad);
  for (std::size_t i = 0; i < scene.boards.size(); ++i) {
    const std::string& name = scene.boards[i].name;
    const std::string what = name.empty() ? "board[" + std::to_string(i + 1) + "]" : name;
    sampler.AddAngle(what + ".yaw_deg", by.board_rad, scene.boards[i].yaw_rad);
  }
  Lighting& light = scene.light;
  sampler.Add("brightness", by.brightness * light.brightness, 0, kMostBrightness, light.brightness);
  sampler.Add("temperature_k", by.temperature_k, kLeastK, kMostK, light.temperature_k);
  BodySpec& body = scene.body;
  double yaw_slip = body.yaw_slip.value_or(body.slip);
  sampler.Add("yaw_slip", by.yaw_slip, 0, kMostSlip, yaw_slip);
  if (by.yaw_slip != 0) body.yaw_slip = yaw_slip;
  sampler.Add("slip", by.slip, 0, kMostSlip, body.slip);
  sampler.Add("odometry_scale", by.odometry_scale, 0.5, 2, body.odometry_scale);
  if (by.odometry_yaw_drift_rad_per_m != 0) {
    const double limit = by.odometry_yaw_drift_rad_per_m;
    body.odometry_yaw_drift_rad_per_m += sampler.Deviation("odometry_yaw_drift_deg_per_m", limit);
    sampler.Note("odometry_yaw_drift_deg_per_m",
                 NumberAs("%.2f", body.odometry_yaw_drift_rad_per_m / kRadInDeg));
  }
  for (std::size_t i = 0; i < kCameras; ++i) {
    sampler.Add("camera." + std::string(kCameraNames[i]) + ".noise", by.camera_noise, 0, kMostNoise,
                scene.cameras.cameras[i].noise);
  }
}

std::string SampledText(const Scene& scene) {
  std::string text = "seed " + std::to_string(scene.seed);
  const char* before = ": ";
  for (const Sampled& sampled : scene.sampled) {
    text += before + sampled.name + " = " + sampled.value;
    before = ", ";
  }
  return text;
}

}  // namespace musher::world
