// Reads the lighting and the cameras of a scene.

#include <cmath>
#include <optional>

#include "musher/modules/world/scene_file/scene_keys.hpp"
#include "musher/modules/world/scene_file/scene_things.hpp"

namespace musher::world {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Rows;
using config_toml::TableReader;

constexpr int kLeastPx = 16;
constexpr int kMostPx = 4096;
constexpr double kLeastViewHz = 0.1;
constexpr double kMostViewHz = 50;  // a shot in each step of the world
constexpr double kWidestPinholeDeg = 150;
constexpr double kWidestFisheyeDeg = 220;

void TakeGrass(Ground& ground) {
  if (ground.texture != Ground::Texture::kGrass) return;
  ground.color = {98, 134, 60};
  ground.other_color = {64, 98, 40};
}

// The picture, and where it is laid out.
void ReadPicture(TableReader& reader, const std::string& folder, Ground& ground) {
  const bool picture = ground.texture == Ground::Texture::kPicture;
  std::optional<Eigen::Vector2d> x;
  std::optional<Eigen::Vector2d> y;
  if (picture) reader.Require("file", "a picture, relative to the scene");
  keys::ReadSome(
      reader, {keys::PictureFile("file", ground.file, folder),
               keys::Range("x_m", x, keys::kSmallestM), keys::Range("y_m", y, keys::kSmallestM)});
  ground.once = x && y;
  if (reader.Has("x_m") != reader.Has("y_m")) {
    const char* key = reader.Has("x_m") ? "x_m" : "y_m";
    reader.Fault(reader.At(key), key,
                 "expected x_m and y_m together: where the picture is laid out");
  }
  if (ground.once) {
    ground.least_m = {x->x(), y->x()};
    ground.most_m = {x->y(), y->y()};
  }
  for (const char* key : {"file", "x_m", "y_m"}) {
    if (reader.Has(key) && !picture) {
      reader.Fault(reader.At(key), key, "is of no use without texture = \"picture\"");
    }
  }
}

Rows GroundRows(const std::string& folder, Findings& findings, Ground& ground) {
  using Texture = Ground::Texture;
  return {
      row::Choice("texture", ground.texture,
                  {{"plain", Texture::kPlain},
                   {"checker", Texture::kChecker},
                   {"grass", Texture::kGrass},
                   {"picture", Texture::kPicture}}),
      [&](TableReader&) { TakeGrass(ground); },
      keys::Colour("color", ground.color, findings),
      keys::Colour("other_color", ground.other_color, findings),
      keys::Length("tile_m", ground.tile_m),
      row::Number("texels_per_m", ground.finest_per_m, 1, 2000),
      [&](TableReader& reader) { ReadPicture(reader, folder, ground); },
  };
}

Rows LightRows(Findings& findings, Lighting& light) {
  return {
      row::Number("brightness", light.brightness, 0, 10),
      row::Number("temperature_k", light.temperature_k, 1500, 20'000),
      keys::Angle("yaw_deg", light.yaw_rad),
      keys::Angle("height_deg", light.height_rad, 5, 90),
      keys::Share("ambient", light.ambient),
      keys::Share("gradient", light.gradient),
      keys::Angle("gradient_yaw_deg", light.gradient_yaw_rad),
      row::Bool("shadows", light.shadows),
      keys::Colour("sky", light.sky, findings),
  };
}

void ReadMount(TableReader& reader, bool has_head, bool is_front, CameraSpec& camera) {
  constexpr double kFarthestOnBodyM = 2;
  row::Choice(
      "on", camera.on,
      {{"body", CameraMount::kBody}, {"head", CameraMount::kHead}, {"place", CameraMount::kPlace}})(
      reader);
  const bool in_place = camera.on == CameraMount::kPlace;
  if (camera.on == CameraMount::kHead && !has_head) {
    reader.Fault(reader.At("on"), "on", "there is no head without [humanoid]");
  }
  if (in_place && is_front) {
    reader.Fault(reader.At("on"), "on", "the front camera is the robot's own: it sees with it");
  }
  if (in_place) {
    for (const char* key : {"x_m", "y_m", "z_m"}) reader.Require(key, "where in the place it is");
    camera = CameraSpec{.enabled = camera.enabled,
                        .on = camera.on};  // no defaults of a CyberDog's camera
  }
  const double farthest_m = in_place ? keys::kFarthestM : kFarthestOnBodyM;
  const double lowest_m = in_place ? keys::kSmallestM : -kFarthestOnBodyM;
  keys::ReadSome(reader, {row::Number("x_m", camera.position_m.x(), -farthest_m, farthest_m),
                          row::Number("y_m", camera.position_m.y(), -farthest_m, farthest_m),
                          row::Number("z_m", camera.position_m.z(), lowest_m, farthest_m),
                          keys::Angle("yaw_deg", camera.yaw_rad),
                          keys::Angle("pitch_deg", camera.pitch_rad, -90, 90),
                          keys::Angle("roll_deg", camera.roll_rad)});
}

Rows CameraRows(bool has_head, bool is_front, CameraSpec& camera) {
  return {
      row::Bool("enabled", camera.enabled),
      [=, &camera](TableReader& reader) { ReadMount(reader, has_head, is_front, camera); },
      row::Choice("model", camera.model,
                  {{"pinhole", CameraModel::kPinhole}, {"fisheye", CameraModel::kFisheye}}),
      row::Integer("width_px", camera.width_px, kLeastPx, kMostPx),
      row::Integer("height_px", camera.height_px, kLeastPx, kMostPx),
      row::Degrees("hfov_deg", camera.hfov_rad, 5, kWidestFisheyeDeg),
      row::Check(
          "hfov_deg",
          [&camera] {
            return camera.model == CameraModel::kFisheye ||
                   camera.hfov_rad <= kWidestPinholeDeg * M_PI / 180;
          },
          "expected at most 150 of a pinhole; a fisheye may have 220"),
      row::Number("rate_hz", camera.rate_hz, kLeastViewHz, kMostViewHz),
      row::Number("noise", camera.noise, 0, 64),
      row::Number("exposure", camera.exposure, 0, 10),
      keys::Share("vignette", camera.vignette),
  };
}

}  // namespace

Rows RobotCameraRows(CameraSpec& camera) {
  return CameraRows(false, true, camera);
}

void ReadViews(TableReader& root, const std::string& folder, Findings& findings, Scene& scene) {
  using Late = CameraSet::Late;
  Rows cameras;
  for (std::size_t i = 0; i < kCameras; ++i) {
    cameras.push_back(row::Sub(
        kCameraNames[i], CameraRows(scene.humanoid.has_value(), i == 0, scene.cameras.cameras[i])));
  }
  keys::ReadSome(
      root, {row::Sub("ground", GroundRows(folder, findings, scene.ground)),
             row::Sub("light", LightRows(findings, scene.light)),
             row::Sub("cameras", {row::Choice("late", scene.cameras.late,
                                              {{"skip", Late::kSkip}, {"wait", Late::kWait}})}),
             row::Sub("camera", cameras)});
}

}  // namespace musher::world
