#include <string>
#include <utility>

#include "musher/modules/camera/source.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::camera {
namespace {

class TopicSource : public Source {
 public:
  TopicSource(transport::Node& node, const std::string& topic, SourceEvents events)
      : events_(std::move(events)), endpoints_(node, "") {
    endpoints_.SubscribeResolved<msg::CameraInfo>(
        topic + "/info", [this](const msg::CameraInfo& info) { events_.on_info(info); },
        transport::kLatchedQos);
    endpoints_.SubscribeResolved<msg::Image>(
        topic, [this](msg::Image&& picture) { events_.on_frame(std::move(picture)); },
        transport::kSensorDataQos);
  }

  const Result<>& opened() const { return endpoints_.opened(); }

 private:
  const SourceEvents events_;
  transport::Endpoints endpoints_;
};

}  // namespace

Result<std::unique_ptr<Source>> OpenTopic(transport::Node& node, const std::string& topic,
                                          SourceEvents events) {
  auto source = std::make_unique<TopicSource>(node, topic, std::move(events));
  if (!source->opened()) return source->opened().error();
  return std::unique_ptr<Source>(std::move(source));
}

}  // namespace musher::camera
