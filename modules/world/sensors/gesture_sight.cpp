#include "musher/modules/world/sensors/gesture_sight.hpp"

#include "musher/modules/world/sensors/ranging.hpp"

namespace musher::world {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFrontCamera = 0;

bool IsInPicture(const Intrinsics& intrinsics, const Vector3d& point_camera_m) {
  const auto pixel = Project(intrinsics, point_camera_m);
  return pixel && pixel->minCoeff() >= 0 && pixel->x() <= intrinsics.width_px - 1 &&
         pixel->y() <= intrinsics.height_px - 1;
}

}  // namespace

Gesture SeenGesture(const World& world) {
  const Scene& scene = world.scene();
  const CameraSpec& camera = scene.cameras.cameras[kFrontCamera];
  if (!camera.enabled || world.IsSilent("camera front")) return Gesture::kNone;
  const Intrinsics intrinsics = IntrinsicsOf(camera);
  const Eigen::Isometry3d camera_in_place = world.CameraPose(kFrontCamera);
  const Vector3d from_m = camera_in_place.translation();
  Gesture seen = Gesture::kNone;
  double nearest_m = kFarthestGestureM;
  for (std::size_t i = 0; i < world.guests().size(); ++i) {
    const Guest& guest = world.guests()[i];
    if (!guest.here || !guest.looks_at_robot || guest.gesture == Gesture::kNone) continue;
    const Vector3d head_m = HeadOf(scene.guests[i], guest);
    const double far_m = (head_m - from_m).norm();
    if (far_m > nearest_m || !IsInPicture(intrinsics, camera_in_place.inverse() * head_m)) continue;
    if (DistanceAlong(scene, from_m, (head_m - from_m) / far_m, far_m) < far_m) continue;
    seen = guest.gesture;
    nearest_m = far_m;
  }
  return seen;
}

}  // namespace musher::world
