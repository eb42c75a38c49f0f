#pragma once
// What the detectors of the vision module have seen. It subscribes to them only while skills ask:
// a detector without a subscriber takes no CPU time.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/skills/config/skills_config.hpp"
#include "musher/modules/skills/robot/recent_value.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::skills {

class DetectorFeeds {
 public:
  // The pose of the robot in the map; nullopt: not known.
  using Body = std::function<std::optional<navigation::Pose>()>;

  // The node, the clock and the views must outlive it.
  DetectorFeeds(transport::Node& node, transport::Clock& clock, std::string name_space,
                const std::vector<DetectorView>& views, Body body);

  // What they have seen within the last second, from where the robot was at that time. Nullopt: not
  // all of them have looked. It looks for 5 s after each call.
  std::optional<std::vector<SeenObject>> Look();
  // Each step.
  void Update();

 private:
  struct Feed {
    const DetectorView& view;
    RecentValue<std::optional<SeenObject>> seen;  // nullopt: it has looked, and seen nothing
    std::unique_ptr<transport::Subscription> subscription;
    Duration stamp{};  // of the last picture
  };

  void Subscribe(Feed& feed);

  transport::Node& node_;
  transport::Clock& clock_;
  const std::string name_space_;
  const Body body_;
  std::vector<Feed> feeds_;
  std::optional<Time> asked_;  // nullopt: it does not look
};

}  // namespace musher::skills
