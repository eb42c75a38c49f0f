#pragma once
// Which topics are recorded or played. Topics have ROS 2's names ("/dog1/chat"). In a pattern `*`
// stands for any characters, also '/', and `?` for one. Pure.

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::view {

bool Matches(std::string_view pattern, std::string_view topic);

// "/chat" of the DDS topic "rt/chat"; "" for the requests and replies of services and for DDS's
// own.
std::string RosTopic(std::string_view dds_topic);

class TopicChoice {
 public:
  // No `wanted`: all topics. A pattern without a leading '/' is below the namespace ("" or "dog1").
  // Fails if a pattern has a character that no topic has.
  static Result<TopicChoice> Of(const std::vector<std::string>& wanted,
                                const std::vector<std::string>& excluded,
                                const std::string& name_space);

  // Whether the topic is chosen; remembers which patterns have matched.
  bool Takes(const std::string& topic);

  // The patterns that no topic has matched so far.
  std::vector<std::string> Unmatched() const;

 private:
  std::vector<std::string> wanted_;
  std::vector<std::string> excluded_;
  std::set<std::string> matched_;
};

}  // namespace musher::view
