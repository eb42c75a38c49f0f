#include "musher/modules/skills/robot/detector_feeds.hpp"

#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/skills/robot/conversions.hpp"

namespace musher::skills {
namespace {

constexpr Duration kRecent = std::chrono::seconds(1);  // a detector may take half of it
constexpr Duration kUnused = std::chrono::seconds(5);

}  // namespace

DetectorFeeds::DetectorFeeds(transport::Node& node, transport::Clock& clock, std::string name_space,
                             const std::vector<DetectorView>& views, Body body)
    : node_(node), clock_(clock), name_space_(std::move(name_space)), body_(std::move(body)) {
  for (const DetectorView& view : views) {
    feeds_.push_back(Feed{view, RecentValue<std::optional<SeenObject>>(kRecent), nullptr, {}});
  }
}

void DetectorFeeds::Subscribe(Feed& feed) {
  auto subscription = transport::MakeSubscription<msg::Sighting>(
      node_, transport::ResolveName(name_space_, feed.view.topic),
      [this, &feed](const msg::Sighting& sighting, const transport::SampleInfo&) {
        const auto body = body_();
        const Duration stamp = msg::FromStamp(sighting.header.stamp);
        const bool again = stamp == feed.stamp && stamp != Duration{};  // of a camera that stands
        if (!body || again) return;
        feed.stamp = stamp;
        feed.seen.Set(ToObject(sighting, feed.view, *body), clock_.Now());
      });
  if (subscription) feed.subscription = std::move(subscription).value();
}

std::optional<std::vector<SeenObject>> DetectorFeeds::Look() {
  const Time now = clock_.Now();
  asked_ = now;
  std::optional<std::vector<SeenObject>> all(std::in_place);
  for (Feed& feed : feeds_) {
    if (!feed.subscription) Subscribe(feed);
    const auto* const seen = feed.seen.At(now);
    if (seen == nullptr) {
      all.reset();
    } else if (all && *seen) {
      all->push_back(**seen);
    }
  }
  return all;
}

void DetectorFeeds::Update() {
  const Time now = clock_.Now();
  if (!asked_ || (now >= *asked_ && now - *asked_ < kUnused)) return;
  asked_.reset();
  for (Feed& feed : feeds_) {
    feed.subscription.reset();
    feed.seen.Clear();
  }
}

}  // namespace musher::skills
