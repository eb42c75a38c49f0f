#include "musher/modules/wedding/second_generation.hpp"

#include <cmath>
#include <utility>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/std_msgs/basic.hpp"

namespace musher::wedding {

void SecondGeneration::Open(transport::Endpoints& topics, Show& show,
                            const std::function<Time()>& now) {
  set_pose_ = topics.Advertise<msg::String>(topic::kSetPose);
  set_motion_ = topics.Advertise<msg::String>(topic::kSetMotion);
  target_face_id_ = topics.Advertise<msg::String>(topic::kTargetFaceId);
  debug_log_ = topics.Advertise<msg::String>(topic::kDebugLog);
  topics.Subscribe<msg::Bool>(
      topic::kReady, [this](const auto& ready) { ready_ = ready.data; }, transport::kLatchedQos);
  topics.Subscribe<msg::PointStamped>(topic::kSetLookAt, [&show, now](const auto& look) {
    show.OnLookAt({look.point.x, look.point.y}, now());
  });
  topics.Subscribe<msg::CameraInfo>(
      topic::kCameraInfo,
      [&show, now](const auto& camera) {
        show.OnCamera(camera.width, camera.height, camera.k[0], now());
      },
      transport::kSensorDataQos);
}

}  // namespace musher::wedding
