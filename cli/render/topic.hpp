#pragma once
// The output of `musher topic`: text for people and JSON documents. Keys are a contract, as in
// json.hpp.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/cli/machine/sample_rate.hpp"
#include "musher/transport/dds/topic_watch.hpp"
#include "musher/view/topics/topic_table.hpp"

namespace musher::cli {

std::string TopicsText(const std::vector<view::ListedTopic>& topics, bool colour);
std::string TopicsJson(const std::vector<view::ListedTopic>& topics);

// A writer or reader of a topic, with its process.
struct TopicEnd {
  transport::DiscoveredEndpoint endpoint;
  std::string node;
  std::int32_t pid = 0;  // 0: not known
  std::string host;
};
std::string TopicInfoText(const std::string& topic, const std::vector<TopicEnd>& ends, bool colour);
std::string TopicInfoJson(const std::string& topic, const std::vector<TopicEnd>& ends);
// Why a reader gets nothing of a writer; empty: their QoS match.
std::string QosMismatch(const transport::DiscoveredEndpoint& writer,
                        const transport::DiscoveredEndpoint& reader);

// A sample as MessageJson gives it, in the form of YAML:
//
//   header:
//     stamp: {sec: 3, nanosec: 0}
//   ranges: [1.5, 2, ... 360 in all]
//
// `whole`: all elements of a list.
std::string SampleText(std::string_view message_json, bool whole);
std::string SampleJson(const std::string& topic, const std::string& type, std::int64_t wall_ns,
                       std::string_view message_json);

// "10.0 Hz, between two samples 99.1 to 101.2 ms, standard deviation 0.5 ms (120 samples)"
std::string RateText(const SampleRate& rate);
std::string RateJson(const std::string& topic, const SampleRate& rate);

}  // namespace musher::cli
