// Reads the lighting and the cameras of a scene.

#include <cmath>
#include <utility>

#include "musher/modules/world/scene_file/scene_keys.hpp"
#include "musher/modules/world/scene_file/scene_things.hpp"

namespace musher::world {
namespace {

using config_toml::Findings;
using config_toml::TableReader;
using keys::Set;

constexpr int kLeastPx = 16;
constexpr int kMostPx = 4096;
constexpr double kLeastViewHz = 0.1;
constexpr double kMostViewHz = 50;  // a shot in each step of the world
constexpr double kWidestPinholeDeg = 150;
constexpr double kWidestFisheyeDeg = 220;

void ReadGround(TableReader& reader, const std::string& folder, Findings& findings,
                Ground& ground) {
  using Texture = Ground::Texture;
  Set(ground.texture, reader.Choice<Texture>("texture", {{"plain", Texture::kPlain},
                                                         {"checker", Texture::kChecker},
                                                         {"grass", Texture::kGrass},
                                                         {"picture", Texture::kPicture}}));
  if (ground.texture == Texture::kGrass) {
    ground.color = {98, 134, 60};
    ground.other_color = {64, 98, 40};
  }
  Set(ground.color, keys::ReadColor(reader, "color", findings));
  Set(ground.other_color, keys::ReadColor(reader, "other_color", findings));
  Set(ground.tile_m, keys::Length(reader, "tile_m"));
  Set(ground.finest_per_m, reader.Number("texels_per_m", 1, 2000));
  const bool picture = ground.texture == Texture::kPicture;
  if (picture) reader.Require("file", "a picture, relative to the scene");
  Set(ground.file, keys::PictureFile(reader, "file", folder));
  const auto x = keys::Range(reader, "x_m", keys::kSmallestM);
  const auto y = keys::Range(reader, "y_m", keys::kSmallestM);
  ground.once = x && y;
  if (reader.Has("x_m") != reader.Has("y_m")) {
    reader.Fault(reader.At(reader.Has("x_m") ? "x_m" : "y_m"), reader.Has("x_m") ? "x_m" : "y_m",
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

void ReadLight(TableReader& reader, Findings& findings, Lighting& light) {
  Set(light.brightness, reader.Number("brightness", 0, 10));
  Set(light.temperature_k, reader.Number("temperature_k", 1500, 20'000));
  Set(light.yaw_rad, keys::Angle(reader, "yaw_deg"));
  Set(light.height_rad, keys::Angle(reader, "height_deg", 5, 90));
  Set(light.ambient, keys::Share(reader, "ambient"));
  Set(light.gradient, keys::Share(reader, "gradient"));
  Set(light.gradient_yaw_rad, keys::Angle(reader, "gradient_yaw_deg"));
  Set(light.shadows, reader.Bool("shadows"));
  Set(light.sky, keys::ReadColor(reader, "sky", findings));
}

void ReadFieldOfView(TableReader& reader, CameraSpec& camera) {
  const auto degrees = reader.Number("hfov_deg", 5, kWidestFisheyeDeg);
  if (degrees) camera.hfov_rad = *degrees * M_PI / 180;
  if (camera.model == CameraModel::kFisheye) return;
  if (camera.hfov_rad <= kWidestPinholeDeg * M_PI / 180) return;
  reader.Fault(reader.At("hfov_deg"), "hfov_deg",
               "expected at most 150 of a pinhole; a fisheye may have 220");
}

void ReadMount(TableReader& reader, bool has_head, bool is_front, CameraSpec& camera) {
  constexpr double kFarthestOnBodyM = 2;
  Set(camera.on, reader.Choice<CameraMount>("on", {{"body", CameraMount::kBody},
                                                   {"head", CameraMount::kHead},
                                                   {"place", CameraMount::kPlace}}));
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
  Set(camera.position_m.x(), reader.Number("x_m", -farthest_m, farthest_m));
  Set(camera.position_m.y(), reader.Number("y_m", -farthest_m, farthest_m));
  Set(camera.position_m.z(), reader.Number("z_m", lowest_m, farthest_m));
  Set(camera.yaw_rad, keys::Angle(reader, "yaw_deg"));
  Set(camera.pitch_rad, keys::Angle(reader, "pitch_deg", -90, 90));
  Set(camera.roll_rad, keys::Angle(reader, "roll_deg"));
}

void ReadCamera(TableReader& reader, bool has_head, bool is_front, CameraSpec& camera) {
  Set(camera.enabled, reader.Bool("enabled"));
  ReadMount(reader, has_head, is_front, camera);
  Set(camera.model, reader.Choice<CameraModel>("model", {{"pinhole", CameraModel::kPinhole},
                                                         {"fisheye", CameraModel::kFisheye}}));
  const auto pixels = [&](const char* key, int& field) {
    const auto count = reader.Integer(key, kLeastPx, kMostPx);
    if (count) field = static_cast<int>(*count);
  };
  pixels("width_px", camera.width_px);
  pixels("height_px", camera.height_px);
  ReadFieldOfView(reader, camera);
  Set(camera.rate_hz, reader.Number("rate_hz", kLeastViewHz, kMostViewHz));
  Set(camera.noise, reader.Number("noise", 0, 64));
  Set(camera.exposure, reader.Number("exposure", 0, 10));
  Set(camera.vignette, keys::Share(reader, "vignette"));
}

}  // namespace

void ReadRobotCamera(TableReader& reader, CameraSpec& camera) {
  ReadCamera(reader, false, true, camera);
}

void ReadViews(TableReader& root, const std::string& folder, Findings& findings, Scene& scene) {
  keys::Section(root, "ground", findings,
                [&](TableReader& reader) { ReadGround(reader, folder, findings, scene.ground); });
  keys::Section(root, "light", findings,
                [&](TableReader& reader) { ReadLight(reader, findings, scene.light); });
  using Late = CameraSet::Late;
  keys::Section(root, "cameras", findings, [&](TableReader& reader) {
    Set(scene.cameras.late,
        reader.Choice<Late>("late", {{"skip", Late::kSkip}, {"wait", Late::kWait}}));
  });
  keys::Section(root, "camera", findings, [&](TableReader& reader) {
    for (std::size_t i = 0; i < kCameras; ++i) {
      keys::Section(reader, kCameraNames[i], findings, [&](TableReader& camera) {
        ReadCamera(camera, scene.humanoid.has_value(), i == 0, scene.cameras.cameras[i]);
      });
    }
  });
}

}  // namespace musher::world
