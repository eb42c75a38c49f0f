#include "musher/test/modules/vision/labelled/labelled_course.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRadPerDeg = M_PI / 180;

Vector2d Along(double yaw_rad) {
  return {std::cos(yaw_rad), std::sin(yaw_rad)};
}

class Sampler {
 public:
  explicit Sampler(std::uint64_t seed) : random_(seed) {}
  double Between(double least, double most) {
    return least + (most - least) * static_cast<double>(random_.Next() >> 11) * 0x1p-53;
  }
  double Sign() { return random_.Bernoulli(0.5) ? 1 : -1; }
  std::uint64_t Next() { return random_.Next(); }

 private:
  transport::sim::Random random_;
};

template <class Things>
auto& Named(Things& things, const std::string& name) {
  const auto found = std::find_if(things.begin(), things.end(),
                                  [&](const auto& thing) { return thing.name == name; });
  if (found == things.end()) throw std::runtime_error("the course has no " + name);
  return *found;
}

world::Scene SceneIn(const LabelledSettings& settings, int light) {
  const std::uint64_t seed = settings.seed * 1000 + static_cast<std::uint64_t>(light);
  const auto reading = world::ReadSceneFile(SourceDir() + "/config/scenes/course.toml",
                                            {.seed = seed, .chosen = {}});
  if (!reading.scene) throw std::runtime_error(FormatDiagnostic(reading.diagnostics.front()));
  world::Scene scene = *reading.scene;
  Sampler sampler(seed);
  scene.ground.finest_per_m = settings.texels_per_m;
  scene.light.brightness *= sampler.Between(0.7, 1.15);
  scene.light.temperature_k += sampler.Between(-300, 300);  // beside those of the scene
  scene.light.yaw_rad = sampler.Between(-M_PI, M_PI);
  scene.light.ambient = sampler.Between(0.45, 0.85);
  scene.light.gradient = sampler.Between(0, 0.3);
  return scene;
}

// The course without the thing, and in half of the lights with something alike.
void Remove(CourseKind kind, bool alike, world::Scene& scene) {
  using Kind = world::Sign::Kind;
  switch (kind) {
    case CourseKind::kQr:
      for (const char* name : {"board A", "board B"}) {
        world::Sign& sign = Named(scene.boards, name).sign;
        sign.kind = alike ? Kind::kQr : Kind::kPlain;
        sign.content = "P-7";
      }
      return;
    case CourseKind::kArrow: {
      world::Board& board = Named(scene.boards, "arrow");
      board.sign.kind = Kind::kPlain;
      if (alike) board.color = {40, 150, 60};
      return;
    }
    case CourseKind::kBarrier: {
      const world::Box bar = Named(scene.boxes, "height bar");
      std::erase_if(scene.boxes, [](const auto& box) { return box.name == "height bar"; });
      world::Circle post{"", bar.center_m, 0.1, 0.6, 0, bar.color};
      if (alike) scene.circles.push_back(post);
      return;
    }
    case CourseKind::kMarker: {
      world::Board& board = Named(scene.boards, "yellow marker");
      if (alike) {
        board.color = {60, 110, 200};
      } else {
        std::erase_if(scene.boards, [](const auto& each) { return each.name == "yellow marker"; });
      }
      return;
    }
    case CourseKind::kLight: {
      world::Ball& ball = Named(scene.balls, "yellow light");
      ball.shown = alike;
      ball.color = {235, 235, 240};
      return;
    }
    case CourseKind::kAruco:  // the course has none
    case CourseKind::kNet:
      return;
    case CourseKind::kLines:
      if (!alike) scene.lines.clear();
      for (world::Line& line : scene.lines) line.color = {240, 240, 238};
      return;
  }
}

// A thing that is seen: its middle, what its front faces, and points on its outline.
struct Target {
  Vector3d center_m;
  double front_rad = 0;
  std::vector<Vector3d> outline_m;
  std::string text;
};

Target TargetOf(const world::Board& board, double size_share) {
  Target target{{0, 0, board.bottom_m + board.height_m / 2}, board.yaw_rad, {}, board.sign.content};
  target.center_m.head<2>() = board.center_m;
  const Vector2d aside = Along(board.yaw_rad + M_PI / 2) * board.width_m / 2 * size_share;
  for (const double x : {-1.0, 1.0}) {
    for (const double z : {-1.0, 1.0}) {
      Vector3d corner = target.center_m;
      corner.head<2>() += x * aside;
      corner.z() += z * board.height_m / 2 * size_share;
      target.outline_m.push_back(corner);
    }
  }
  return target;
}

Target TargetOf(const world::Box& bar) {
  Target target{{0, 0, bar.bottom_m + bar.height_m / 2}, M_PI, {}, ""};
  target.center_m.head<2>() = bar.center_m;
  for (const double z : {bar.bottom_m, bar.bottom_m + bar.height_m}) {
    for (const double y : {-1.0, 1.0}) {
      target.outline_m.emplace_back(bar.center_m.x() - bar.half_m.x(),
                                    bar.center_m.y() + y * bar.half_m.y(), z);
    }
  }
  return target;
}

Target TargetOf(const world::Ball& ball) {
  Target target{ball.center_m, 0, {}, ""};
  for (int i = 0; i < 16; ++i) {
    for (const double turn : {0.0, M_PI / 2}) {
      const double at = i * M_PI / 8;
      target.outline_m.push_back(
          ball.center_m + ball.radius_m * Vector3d(std::cos(at) * std::cos(turn),
                                                   std::cos(at) * std::sin(turn), std::sin(at)));
    }
  }
  return target;
}

Target TargetOf(CourseKind kind, const world::Scene& scene, Sampler& sampler) {
  constexpr double kCodeShare = 21.0 / 29;  // the code on its board, without the white rim
  switch (kind) {
    case CourseKind::kQr:
      return TargetOf(Named(scene.boards, sampler.Sign() > 0 ? "board A" : "board B"), kCodeShare);
    case CourseKind::kArrow:
      return TargetOf(Named(scene.boards, "arrow"), 1);
    case CourseKind::kBarrier:
      return TargetOf(Named(scene.boxes, "height bar"));
    case CourseKind::kMarker:
      return TargetOf(Named(scene.boards, "yellow marker"), 1);
    default:
      return TargetOf(Named(scene.balls, "yellow light"));
  }
}

bool IsInside(const world::Scene& scene, const Vector2d& at_m) {
  constexpr double kMarginM = 0.1;
  return (at_m.array() > scene.least_m.array() + kMarginM).all() &&
         (at_m.array() < scene.most_m.array() - kMarginM).all();
}

// Of the robot whose front camera has the target at that distance and angle.
world::Pose2 PoseBefore(const Target& target, CourseKind kind, const Cell& cell,
                        const world::Scene& scene, Sampler& sampler) {
  constexpr double kMostBesideDeg = 8;
  const double camera_m = scene.cameras.cameras[0].position_m.x();
  world::Pose2 pose;
  Vector2d camera;
  do {
    const bool all_round = kind == CourseKind::kLight;  // it looks the same from all sides
    const double towards = all_round
                               ? sampler.Between(-M_PI, M_PI)
                               : target.front_rad + sampler.Sign() * cell.angle_deg * kRadPerDeg;
    camera = target.center_m.head<2>() + cell.distance_m * Along(towards);
    const double beside = all_round ? sampler.Sign() * cell.angle_deg
                                    : sampler.Between(-kMostBesideDeg, kMostBesideDeg);
    pose.yaw_rad = towards + M_PI + beside * kRadPerDeg;
    pose.position_m = camera - camera_m * Along(pose.yaw_rad);
  } while (!IsInside(scene, camera));
  return pose;
}

// On the S lane, the lane L1 or the lane START, beside its middle and turned off its direction.
world::Pose2 PoseOnLane(const Cell& cell, Sampler& sampler) {
  const double at = sampler.Between(0, 5);
  world::Pose2 pose;
  if (at < 1) {  // the lane START
    pose.position_m = {-0.9 + at * 0.5, 0};
  } else if (at < 2) {  // the lane L1
    pose.position_m = {7.2 + (at - 1) * 3, 2.043};
  } else if (at < 3.5) {  // the first arc of the S
    const double turned = (at - 2) / 1.5 * 50 * kRadPerDeg;
    pose = {Vector2d(1.7, 1.2) + 1.6 * Along(turned - M_PI / 2), turned};
  } else {  // the second one, which turns back
    const double turned = (5 - at) / 1.5 * 50 * kRadPerDeg;
    pose = {Vector2d(4.1513, -0.857) + 1.6 * Along(turned + M_PI / 2), turned};
  }
  pose.position_m -= cell.distance_m * Along(pose.yaw_rad + M_PI / 2);
  pose.yaw_rad += sampler.Sign() * cell.angle_deg * kRadPerDeg;
  return pose;
}

struct Viewpoint {
  world::View view;
  world::CameraSpec spec;
};

Viewpoint ViewpointFrom(const world::Pose2& pose, const world::Scene& scene, std::size_t camera,
                        Sampler& sampler) {
  Viewpoint viewpoint{{}, scene.cameras.cameras[camera]};
  viewpoint.view.body = pose;
  viewpoint.view.attitude.height_m = scene.body.stand_height_m;
  viewpoint.view.attitude.roll_rad = sampler.Between(-1, 1) * kRadPerDeg;
  viewpoint.view.attitude.pitch_rad = sampler.Between(-1, 1) * kRadPerDeg;
  viewpoint.view.seed = sampler.Next();
  viewpoint.spec.noise = sampler.Between(1, 4);
  viewpoint.spec.exposure *= sampler.Between(0.8, 1.15);
  return viewpoint;
}

std::vector<std::size_t> HiddenBalls(const world::Scene& scene) {
  std::vector<std::size_t> hidden;
  for (std::size_t i = 0; i < scene.balls.size(); ++i) {
    if (!scene.balls[i].shown) hidden.push_back(i);
  }
  return hidden;
}

// A course in one light, prepared for drawing.
struct Place {
  Place(world::Scene of, bool lit) : scene(std::move(of)), lines(std::make_shared<LineMap>(scene)) {
    if (lit) Named(scene.balls, "yellow light").shown = true;
    auto made = world::Scenery::Make(scene);
    if (!made) throw std::runtime_error(made.error().message);
    scenery = std::move(made).value();
  }

  world::Scene scene;
  std::shared_ptr<const LineMap> lines;
  std::unique_ptr<world::Scenery> scenery;
};

void Draw(const Place& place, Viewpoint viewpoint, LabelledPicture& picture) {
  viewpoint.view.hidden_balls = HiddenBalls(place.scene);
  const world::Camera camera(viewpoint.spec);
  const world::Image image = camera.Shoot(*place.scenery, viewpoint.view);
  picture.bgr.create(image.height, image.width, CV_8UC3);
  std::copy(image.bgr.begin(), image.bgr.end(), picture.bgr.data);
  picture.intrinsics = camera.intrinsics();
  picture.lens.fisheye = picture.intrinsics.model == world::CameraModel::kFisheye;
  picture.lens.focal_x = picture.intrinsics.focal_px / image.width;
  picture.lens.focal_y = picture.intrinsics.focal_px / image.height;
  picture.X_WC = world::CameraInPlace(viewpoint.spec, viewpoint.view.body, viewpoint.view.attitude);
  picture.body_m = viewpoint.view.body.position_m;
}

// False when the picture does not show all of it.
bool Label(const Target& target, const Viewpoint& viewpoint, LabelledPicture& picture) {
  const world::Intrinsics intrinsics = world::IntrinsicsOf(viewpoint.spec);
  const Eigen::Isometry3d X_CW =
      world::CameraInPlace(viewpoint.spec, viewpoint.view.body, viewpoint.view.attitude).inverse();
  Vector2d least(1e9, 1e9), most = -least;
  for (const Vector3d& point : target.outline_m) {
    const auto pixel = Project(intrinsics, X_CW * point);
    if (!pixel) return false;
    least = least.cwiseMin(*pixel);
    most = most.cwiseMax(*pixel);
  }
  constexpr double kRimPx = 3;
  // A bar may be wider than the picture.
  const bool may_be_wide = picture.kind == CourseKind::kBarrier;
  if (may_be_wide) {
    least.x() = std::clamp(least.x(), kRimPx, intrinsics.width_px - 1 - kRimPx);
    most.x() = std::clamp(most.x(), kRimPx, intrinsics.width_px - 1 - kRimPx);
  }
  picture.box = {least.x(), least.y(), most.x() - least.x(), most.y() - least.y()};
  picture.distance_m = (X_CW * target.center_m).z();
  picture.text = target.text;
  return least.minCoeff() >= kRimPx && most.x() <= intrinsics.width_px - 1 - kRimPx &&
         most.y() <= intrinsics.height_px - 1 - kRimPx;
}

}  // namespace

std::optional<Vector2d> LabelledPicture::GroundAt(const Vector2d& pixel) const {
  const Vector3d ray_C = RayOf(intrinsics, pixel);
  const Vector3d ray = X_WC.linear() * ray_C;
  if (ray.z() >= 0 || std::acos(ray_C.z()) > intrinsics.farthest_rad) return std::nullopt;
  const Vector3d from = X_WC.translation();
  return (from - ray * (from.z() / ray.z())).head<2>();
}

std::vector<Cell> CellsOf(CourseKind kind) {
  std::vector<double> distances{0.5, 1.0, 1.5, 2.0, 2.5, 3.0}, angles{0, 15, 30, 45};
  if (kind == CourseKind::kQr) distances[0] = 0.7;
  if (kind == CourseKind::kLight) {
    distances = {0.6, 0.7, 1.0, 1.5, 2.0, 2.5};
    angles = {0, 15, 30};
  }
  if (kind == CourseKind::kBarrier) angles.pop_back();
  if (kind == CourseKind::kLines) {
    distances = {-0.2, -0.1, 0, 0.1, 0.2};
    angles = {0, 15, 30};
  }
  std::vector<Cell> cells;
  for (const double distance : distances) {
    for (const double angle : angles) cells.push_back({distance, angle});
  }
  return cells;
}

namespace {

// The picture of each cell, as `there` says.
void SeeCells(const LabelledSettings& settings, int light, CourseKind kind, bool there,
              const Place& with, const std::function<void(const LabelledPicture&)>& see) {
  std::optional<Place> without;
  if (!there) {
    world::Scene scene = SceneIn(settings, light);
    Remove(kind, light % 4 == 0, scene);
    without.emplace(std::move(scene), false);
  }
  const Place& place = there ? with : *without;
  std::uint64_t number = 0;
  for (const Cell& cell : CellsOf(kind)) {
    ++number;
    if (kind != CourseKind::kLines && cell.distance_m > settings.most_distance_m) continue;
    if (cell.angle_deg > settings.most_angle_deg) continue;
    // Cameras in turns; the same with and without the thing.
    Sampler sampler((settings.seed << 20) + (std::uint64_t(light) << 12) +
                    (std::uint64_t(kind) << 8) + number);
    LabelledPicture picture;
    picture.kind = kind;
    picture.cell = cell;
    picture.there = there;
    picture.lines = with.lines;
    Viewpoint viewpoint;
    if (kind == CourseKind::kLines) {
      picture.camera = (number + std::uint64_t(light)) % world::kCameras;
      viewpoint = ViewpointFrom(PoseOnLane(cell, sampler), with.scene, picture.camera, sampler);
    } else {
      const Target target = TargetOf(kind, with.scene, sampler);
      viewpoint = ViewpointFrom(PoseBefore(target, kind, cell, with.scene, sampler), with.scene, 0,
                                sampler);
      if (!Label(target, viewpoint, picture)) continue;
    }
    Draw(place, viewpoint, picture);
    see(picture);
  }
}

}  // namespace

void SeeLabelledPictures(const LabelledSettings& settings, const std::vector<CourseKind>& kinds,
                         const std::function<void(const LabelledPicture&)>& see) {
  for (int light = 0; light < settings.lights; ++light) {
    const Place dark(SceneIn(settings, light), false);
    for (const CourseKind kind : kinds) {
      std::optional<Place> lit;
      if (kind == CourseKind::kLight) lit.emplace(SceneIn(settings, light), true);
      const Place& with = lit ? *lit : dark;
      SeeCells(settings, light, kind, true, with, see);
      if (light % 2 == 0) SeeCells(settings, light, kind, false, with, see);
    }
  }
}

}  // namespace musher::vision
