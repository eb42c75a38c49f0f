#pragma once
// The cameras' messages, field by field; see wire_fields_robot.hpp.

#include <protocol_camera.h>
#include <sensor_msgs_image.h>

#include "musher/messages/protocol/camera.hpp"
#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/sensor_msgs/compressed_image.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/test/contract/wire_fields_ros.hpp"

namespace musher::msg {

MUSHER_SAME(sensor_msgs_msg_dds__Image_, Image) {
  SAME(header);
  SAME(height);
  SAME(width);
  SAME(encoding);
  SAME(is_bigendian);
  SAME(step);
  SAME_ITEMS(data);
}

MUSHER_SAME(sensor_msgs_msg_dds__CompressedImage_, CompressedImage) {
  SAME(header);
  SAME(format);
  SAME_ITEMS(data);
}

MUSHER_SAME(sensor_msgs_msg_dds__RegionOfInterest_, RegionOfInterest) {
  SAME(x_offset);
  SAME(y_offset);
  SAME(height);
  SAME(width);
  SAME(do_rectify);
}

MUSHER_SAME(sensor_msgs_msg_dds__CameraInfo_, CameraInfo) {
  SAME(header);
  SAME(height);
  SAME(width);
  SAME(distortion_model);
  SAME_ITEMS(d);
  SAME(k);
  SAME(r);
  SAME(p);
  SAME(binning_x);
  SAME(binning_y);
  SAME(roi);
}

MUSHER_SAME(protocol_srv_dds__CameraService_Request_, CameraService::Request) {
  SAME(command);
  SAME(args);
  SAME(width);
  SAME(height);
  SAME(fps);
}

MUSHER_SAME(protocol_srv_dds__CameraService_Response_, CameraService::Response) {
  SAME(result);
  SAME(msg);
  SAME(code);
}

}  // namespace musher::msg
