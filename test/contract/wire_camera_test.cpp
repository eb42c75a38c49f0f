// The cameras' messages: as the IDL says.

#include "musher/test/contract/wire_exchange.hpp"
#include "musher/test/contract/wire_fields_camera.hpp"

namespace musher::transport::wire_camera_test {

MESSAGE(sensor_msgs, Image)
MESSAGE(sensor_msgs, CompressedImage)
MESSAGE(sensor_msgs, RegionOfInterest)
MESSAGE(sensor_msgs, CameraInfo)
SERVICE(protocol, CameraService)

}  // namespace musher::transport::wire_camera_test
