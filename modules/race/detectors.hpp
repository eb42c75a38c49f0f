#pragma once
// The subscriptions to the detectors of a course. They exist only while they are needed: a detector
// without a subscriber does not run.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/race/course.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/publisher_turns.hpp"

namespace musher::race {

class Detectors {
 public:
  struct Handlers {
    std::function<void(Index detector, const msg::Sighting&)> on_sighting;
    std::function<void(Index detector, const msg::YellowLines&)> on_lines;
    std::function<void(Index detector, const std::string& text)> on_text;
    // Why a picture of a detector of sightings says nothing.
    std::function<void(Index detector, const std::string& why)> on_doubt;
    // Samples of two publishers are received alternately.
    std::function<void(Index detector)> on_two_publishers;
    std::function<void(const std::string&)> log;
  };

  // `node` and `course` outlive it.
  Detectors(transport::Node& node, std::string name_space, const Course& course, Handlers handlers);

  // Opens and closes subscriptions; by the course's detectors. Not inside of a handler.
  void Watch(const std::vector<bool>& wanted);
  // Also opens all, until the end of a self-check.
  void OpenAll(bool open);

  // The topics that are open and have no publisher.
  std::vector<std::string> Missing() const;
  // Those with more than one.
  std::vector<std::string> Doubled() const;

 private:
  struct Open {
    std::unique_ptr<transport::Endpoints> endpoints;
    transport::Subscription* subscription = nullptr;
    transport::PublisherTurns publishers;
  };

  void Update();
  void Subscribe(Index detector);
  template <msg::Message M>
  void Subscribe(Index detector, std::function<void(const M&)> handler);
  std::vector<std::string> TopicsWith(const std::function<bool(int publishers)>& fits) const;

  transport::Node& node_;
  const std::string name_space_;
  const Course& course_;
  const Handlers handlers_;
  std::vector<bool> wanted_;
  bool all_ = false;
  std::vector<Open> open_;  // by detector
};

}  // namespace musher::race
