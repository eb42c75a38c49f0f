#pragma once
// The cameras of a robot: a camera is subscribed to while a picture of it is wanted, since many
// publish only then.
//
// Threads: the loop's.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/skills/robot/robot.hpp"
#include "musher/transport/node.hpp"

namespace musher::skills {

class CameraFeeds {
 public:
  // `topics`: of each camera, resolved. The node must outlive it.
  CameraFeeds(transport::Node& node, std::map<std::string, std::string> topics)
      : node_(node), topics_(std::move(topics)) {}

  // The next picture. Fails for an unknown camera, with those that there are, and for a picture
  // that cannot be read.
  skill::Future<Picture> Take(const std::string& camera);
  // At each step: unsubscribes from the cameras of which no picture is wanted.
  void Update();

 private:
  struct Feed {
    std::vector<skill::Source<Picture>> wanted;
    std::unique_ptr<transport::Subscription> subscription;  // last: its callback uses the rest
  };

  transport::Node& node_;
  const std::map<std::string, std::string> topics_;
  std::map<std::string, std::unique_ptr<Feed>> feeds_;
};

}  // namespace musher::skills
