#include <string>
#include <utility>

#include "musher/modules/camera/source.hpp"

namespace musher::camera {
namespace {

class TopicSource : public Source {
 public:
  explicit TopicSource(SourceEvents events) : events_(std::move(events)) {}

  Result<> Connect(transport::Node& node, const std::string& topic) {
    auto infos = transport::MakeSubscription<msg::CameraInfo>(
        node, topic + "/info",
        [this](const msg::CameraInfo& info, const auto&) { events_.on_info(info); },
        transport::kLatchedQos);
    if (!infos) return infos.error();
    infos_ = std::move(infos).value();
    auto pictures = transport::MakeSubscription<msg::Image>(
        node, topic,
        [this](msg::Image&& picture, const auto&) { events_.on_frame(std::move(picture)); },
        transport::kSensorDataQos);
    if (!pictures) return pictures.error();
    pictures_ = std::move(pictures).value();
    return Ok();
  }

 private:
  const SourceEvents events_;
  std::unique_ptr<transport::Subscription> infos_;
  std::unique_ptr<transport::Subscription> pictures_;
};

}  // namespace

Result<std::unique_ptr<Source>> OpenTopic(transport::Node& node, const std::string& topic,
                                          SourceEvents events) {
  auto source = std::make_unique<TopicSource>(std::move(events));
  if (Result<> connected = source->Connect(node, topic); !connected) return connected.error();
  return std::unique_ptr<Source>(std::move(source));
}

}  // namespace musher::camera
