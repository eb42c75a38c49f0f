#include "musher/modules/skills/robot/look_feeds.hpp"

#include <algorithm>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/skills/robot/conversions.hpp"

namespace musher::skills {
namespace {

constexpr Duration kPictureCounts = std::chrono::seconds(1);
constexpr Duration kLooksAfterCall = std::chrono::seconds(5);
constexpr Duration kPictureClockSet =
    std::chrono::seconds(1);                       // a larger step is none of a late picture
constexpr std::int64_t kPictureClockDrift = 5000;  // of a clock, one part in so many

}  // namespace

LookFeeds::LookFeeds(transport::Node& node, transport::Clock& clock, std::string name_space,
                     const SkillsConfig& config, PlaceOnBody on_body)
    : node_(node),
      clock_(clock),
      name_space_(std::move(name_space)),
      config_(config),
      on_body_(std::move(on_body)) {
  feeds_.resize(config.detectors.size() + (config.names.detections.empty() ? 0 : 1));
  for (std::size_t i = 0; i < config.detectors.size(); ++i) feeds_[i].view = &config.detectors[i];
}

bool LookFeeds::Take(Feed& feed, Duration stamp) const {
  const Time now = clock_.Now();
  Duration age{};
  if (stamp != Duration::zero()) {
    const Duration step = feed.stamp ? stamp - *feed.stamp : Duration(1);
    const bool set = step < -kPictureClockSet || step > now - feed.came + kPictureClockSet;
    if (step <= Duration::zero() && !set) return false;
    const Duration here = now.time_since_epoch() - stamp;
    if (feed.stamp && set) return BeginClock(feed, stamp, here);
    feed.offset =
        feed.offset ? std::min(here, *feed.offset + (now - feed.came) / kPictureClockDrift) : here;
    age = here - *feed.offset;
    feed.stamp = stamp;
  }
  feed.came = now;
  feed.taken = now - age;
  feed.things.clear();
  return true;
}

// The clock of the pictures was set, or a second program publishes, such as a bridge that repeats
// old pictures. This one does not count, the next one by the same clock does; of two programs in
// turn, none.
bool LookFeeds::BeginClock(Feed& feed, Duration stamp, Duration here) const {
  feed.stamp = stamp;
  feed.offset = here;
  feed.came = clock_.Now();
  feed.taken.reset();
  feed.things.clear();
  return false;
}

void LookFeeds::OnDetections(Feed& feed, const msg::ObjectStates& found) {
  const auto frame = on_body_(found.header.frame_id);
  refused_ = frame ? "" : frame.error().message;
  if (!frame || !Take(feed, msg::FromStamp(found.header.stamp))) return;
  for (const SeenObject& object : ToObjects(found, frame.value())) {
    feed.things.push_back({object.name, object.category, object.pose.at});
  }
}

void LookFeeds::Subscribe(Feed& feed) {
  const auto keep = [&feed](auto subscription) {
    if (subscription) feed.subscription = std::move(subscription).value();
  };
  if (feed.view == nullptr) {
    return keep(transport::MakeSubscription<msg::ObjectStates>(
        node_, transport::ResolveName(name_space_, config_.names.detections),
        [this, &feed](const msg::ObjectStates& found, const transport::SampleInfo&) {
          OnDetections(feed, found);
        },
        transport::kSensorDataQos));
  }
  keep(transport::MakeSubscription<msg::Sighting>(
      node_, transport::ResolveName(name_space_, feed.view->topic),
      [this, &feed](const msg::Sighting& sighting, const transport::SampleInfo&) {
        if (!Take(feed, msg::FromStamp(sighting.header.stamp))) return;
        if (const auto object = ToObject(sighting, *feed.view, {})) {
          feed.things.push_back({object->name, object->category, object->pose.at});
        }
      }));
}

std::optional<Look> LookFeeds::LookFor(const std::string& target) {
  const Time now = clock_.Now();
  asked_ = now;
  std::optional<Look> look;
  for (Feed& feed : feeds_) {
    if (!feed.subscription) Subscribe(feed);
    if (!feed.taken || now < *feed.taken || now - *feed.taken > kPictureCounts) continue;
    std::vector<navigation::Point> seen;
    for (const Thing& thing : feed.things) {
      if (thing.name == target || thing.category == target) seen.push_back(thing.at);
    }
    // The picture of a detector that sees the target counts before those of others.
    const bool first = !look || (look->seen.empty() && !seen.empty());
    const bool counts = look && look->seen.empty() == seen.empty();
    if (first) {
      look = Look{*feed.taken, std::move(seen)};
    } else if (counts) {
      look->at = std::max(look->at, *feed.taken);
      look->seen.insert(look->seen.end(), seen.begin(), seen.end());
    }
  }
  return look;
}

std::string LookFeeds::WhyNone() const {
  if (feeds_.empty()) {
    return config_.robot + " has no detector: its file names no topics.detections";
  }
  if (!refused_.empty()) {
    return "no detections with a place on the body (" + config_.names.detections + ": " + refused_ +
           ")";
  }
  return "no detections on " +
         (feeds_.back().view == nullptr ? config_.names.detections : feeds_.back().view->topic);
}

void LookFeeds::Update() {
  const Time now = clock_.Now();
  if (!asked_ || (now >= *asked_ && now - *asked_ < kLooksAfterCall)) return;
  asked_.reset();
  refused_.clear();
  for (Feed& feed : feeds_) {
    const DetectorView* const view = feed.view;
    feed = {};
    feed.view = view;
  }
}

}  // namespace musher::skills
