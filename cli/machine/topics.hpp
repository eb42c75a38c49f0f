#pragma once
// The topics of the domain, as discovery finds them, and the nodes that write and read them. Names
// are ROS 2's: "/dog1/scan".
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/cli/machine/link.hpp"
#include "musher/transport/dds/ros_nodes.hpp"
#include "musher/transport/dds/topic_watch.hpp"
#include "musher/view/topics/topic_table.hpp"

namespace musher::cli {

class Topics {
 public:
  struct Events {
    std::function<void(const transport::DiscoveredEndpoint&)> on_found;
    std::function<void(transport::EndpointId)> on_lost;
  };

  // The link must outlive it. `events` run for every endpoint, also for those of services.
  static Result<std::unique_ptr<Topics>> Begin(Link& link, Events events = {});

  // Runs the loop until no further endpoint is discovered for a while, at most `timeout`.
  void AwaitAll(Duration timeout);
  // Runs the loop until the topic is discovered. A Failure if it is not: no process writes or reads
  // it.
  std::optional<Failure> Await(const std::string& topic);
  // The failure of a domain without topics.
  static Failure NoTopics();

  const view::TopicTable& table() const { return table_; }

  // Where an endpoint is.
  struct Place {
    std::string node;  // "/dog1/lidar"; empty: the process names none, as the commands of musher
    std::int32_t pid = 0;
    std::string host;
  };
  std::vector<Place> PlacesOf(const std::vector<transport::DiscoveredEndpoint>& endpoints) const;

 private:
  Topics(Link& link, Events events)
      : link_(link), events_(std::move(events)), nodes_(link.node()) {}

  Link& link_;
  const Events events_;
  view::TopicTable table_;
  bool changed_ = false;
  transport::RosNodes nodes_;
  std::unique_ptr<transport::TopicWatch> watch_;
};

}  // namespace musher::cli
