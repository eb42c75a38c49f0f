#pragma once
// Where a camera's frames come from. A source delivers from when it is opened until it is
// destroyed.
//
// Threads: created, destroyed and called back on the loop. A source that blocks has a thread of
// its own, which the loop does not wait for (see CaptureThreads).

#include <functional>
#include <memory>

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/camera/camera_config.hpp"
#include "musher/modules/camera/capture_threads.hpp"
#include "musher/transport/node.hpp"

namespace musher::camera {

// After on_failed and on_ended no more callbacks. None of them runs inside Open…().
struct SourceEvents {
  std::function<void(msg::Image)> on_frame;  // without a stamp if its source has none
  std::function<void(const msg::CameraInfo&)> on_info;
  std::function<void(const Error&)> on_failed;
  std::function<void()> on_ended;
};

class Source {
 public:
  virtual ~Source() = default;
};

using SourceOpener =
    std::function<Result<std::unique_ptr<Source>>(const CameraConfig&, SourceEvents)>;

// A topic; its CameraInfo is subscribed to beside it, on <topic>/info. `topic` as on the wire.
Result<std::unique_ptr<Source>> OpenTopic(transport::Node& node, const std::string& topic,
                                          SourceEvents events);

// A video, a device or a folder, on a thread of its own. A frame that the loop has not taken when
// the next one arrives is dropped.
std::unique_ptr<Source> OpenCapture(transport::EventLoop& loop, CaptureThreads& threads,
                                    const CameraConfig& camera, SourceEvents events);

}  // namespace musher::camera
