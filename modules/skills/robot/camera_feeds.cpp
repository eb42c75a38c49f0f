#include "musher/modules/skills/robot/camera_feeds.hpp"

#include "musher/base/suggest.hpp"
#include "musher/modules/skills/robot/conversions.hpp"

namespace musher::skills {

skill::Future<Picture> CameraFeeds::Take(const std::string& camera) {
  skill::Source<Picture> source;
  skill::Future<Picture> future = source.future();
  const auto topic = topics_.find(camera);
  if (topic == topics_.end()) {
    std::vector<std::string> names;
    for (const auto& [name, unused] : topics_) names.push_back(name);
    source.Fail(NoSuch("camera", camera, names));
    return future;
  }
  std::unique_ptr<Feed>& feed = feeds_[camera];
  if (!feed) {
    feed = std::make_unique<Feed>();
    Feed& made = *feed;
    auto subscription = transport::MakeSubscription<msg::Image>(
        node_, topic->second,
        [&made](const msg::Image& image, const transport::SampleInfo&) {
          for (auto& wanted : std::exchange(made.wanted, {})) wanted.Set(ToPicture(image));
        },
        transport::kSensorDataQos);
    if (!subscription) {
      source.Set(subscription.error());
      feeds_.erase(camera);
      return future;
    }
    feed->subscription = std::move(subscription).value();
  }
  feed->wanted.push_back(std::move(source));
  return future;
}

void CameraFeeds::Update() {
  std::erase_if(feeds_, [](const auto& named) {
    Feed& feed = *named.second;
    std::erase_if(feed.wanted, [](const auto& source) { return !source.wanted(); });
    return feed.wanted.empty();
  });
}

}  // namespace musher::skills
