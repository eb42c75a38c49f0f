#include "musher/modules/camera/tool/commands.hpp"

#include <chrono>
#include <cstdint>
#include <iostream>
#include <utility>

#include "musher/base/decimal.hpp"
#include "musher/base/words.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/modules/camera/fit.hpp"
#include "musher/modules/camera/media.hpp"

namespace musher::camera::tool {

ExitCode Fail(ExitCode exit, const Error& error) {
  std::cerr << "musher-camera: " << error.message << std::endl;
  return exit;
}

Result<std::unique_ptr<transport::Subscription>> SubscribeToPictures(
    program::ToolLink& link, const std::string& topic,
    std::function<void(msg::Image&&, const transport::SampleInfo&)> on_picture) {
  return transport::MakeSubscription<msg::Image>(link.node(), link.Name(topic),
                                                 std::move(on_picture), transport::kSensorDataQos);
}

Error NothingCame(const transport::Subscription& subscription, const std::string& topic,
                  const ToolOptions& global, double seconds) {
  if (subscription.MatchedWriters() == 0) {
    return {kCodeNetError, "no publisher of " + topic + " in " + NamespaceText(global.name_space) +
                               "; use --namespace and --domain, or --transport lan for other "
                               "hosts"};
  }
  return {kCodeTimeout, "no picture on " + topic + " within " + Decimal(seconds, 1) +
                            " s; is the camera on? (It is off in LowPower and OTA.)"};
}

Duration AgeOf(const msg::Image& picture, program::ToolLink& link, const ToolOptions& global) {
  const auto now = global.clock_topic ? link.clock().Now().time_since_epoch()
                                      : std::chrono::duration_cast<Duration>(
                                            std::chrono::system_clock::now().time_since_epoch());
  return now - msg::FromStamp(picture.header.stamp);
}

Result<> Save(msg::Image picture, const std::string& file) {
  auto ready = Fit(std::move(picture), {0, 0, "bgr8"});
  if (!ready) return ready.error();
  const Result<Media*> media = LoadMedia();
  if (!media) return media.error();
  return media.value()->Save(ready.value(), file);
}

Duration Seconds(double seconds) {
  return Duration(static_cast<std::int64_t>(seconds * 1e9));
}

}  // namespace musher::camera::tool
