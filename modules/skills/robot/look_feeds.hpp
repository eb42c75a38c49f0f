#pragma once
// What the detectors of a robot have found in their last pictures, in the frame of its body: those
// of the config, and the topic of its detections. It subscribes to them only while skills ask.
//
// A picture counts from the moment when it was taken: how late it came is the age of its stamp
// beyond that of the fastest one, so that clocks may differ. One that is repeated, by its stamp, or
// older than the last one, does not count.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/modules/skills/config/skills_config.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::skills {

class LookFeeds {
 public:
  // Where the frame of a message is on the body. Fails with the reason.
  using PlaceOnBody = std::function<Result<navigation::Pose>(const std::string& frame)>;

  // The node, the clock and the config must outlive it.
  LookFeeds(transport::Node& node, transport::Clock& clock, std::string name_space,
            const SkillsConfig& config, PlaceOnBody on_body);

  // Of a thing by its name or category. Nullopt: no picture of the last second.
  std::optional<Look> LookFor(const std::string& target);
  std::string WhyNone() const;
  // Each step.
  void Update();

 private:
  struct Thing {
    std::string name;
    std::string category;
    navigation::Point at;
  };
  struct Feed {
    const DetectorView* view = nullptr;  // null: the topic of the detections
    std::vector<Thing> things;           // of the last picture
    std::optional<Time> taken;           // nullopt: no picture came
    Time came;
    std::optional<Duration> stamp;   // of the last picture with one
    std::optional<Duration> offset;  // from a stamp to our time, of the fastest picture
    std::unique_ptr<transport::Subscription> subscription;
  };

  void Subscribe(Feed& feed);
  // False: the picture does not count.
  bool Take(Feed& feed, Duration stamp) const;
  bool BeginClock(Feed& feed, Duration stamp, Duration here) const;
  void OnDetections(Feed& feed, const msg::ObjectStates& found);

  transport::Node& node_;
  transport::Clock& clock_;
  const std::string name_space_;
  const SkillsConfig& config_;
  const PlaceOnBody on_body_;
  std::vector<Feed> feeds_;
  std::string refused_;        // why the last detections have no place on the body; empty: they do
  std::optional<Time> asked_;  // nullopt: it does not look
};

}  // namespace musher::skills
