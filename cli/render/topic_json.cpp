// The JSON documents of `musher topic`.

#include <nlohmann/json.hpp>

#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/topic.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::cli {
namespace {

std::string RosTypeName(const std::string& dds_type) {
  const std::string ros = view::RosType(dds_type);
  return ros.empty() ? dds_type : ros;
}

}  // namespace

std::string TopicsJson(const std::vector<view::ListedTopic>& topics) {
  OrderedJson list = OrderedJson::array();
  for (const view::ListedTopic& topic : topics) {
    list.push_back({{"topic", topic.name},
                    {"type", topic.type},
                    {"writers", topic.publishers},
                    {"readers", topic.subscribers}});
  }
  return JsonLine({{"topics", list}});
}

std::string TopicInfoJson(const std::string& topic, const std::vector<TopicEnd>& ends) {
  OrderedJson writers = OrderedJson::array();
  OrderedJson readers = OrderedJson::array();
  for (const TopicEnd& end : ends) {
    const bool reliable = end.endpoint.reliability == transport::Qos::Reliability::kReliable;
    const bool latched = end.endpoint.durability == transport::Qos::Durability::kTransientLocal;
    (end.endpoint.writer ? writers : readers)
        .push_back({{"node", Known(end.node)},
                    {"pid", Known(end.pid)},
                    {"host", Known(end.host)},
                    {"type", RosTypeName(end.endpoint.type)},
                    {"reliability", reliable ? "reliable" : "best_effort"},
                    {"durability", latched ? "transient_local" : "volatile"},
                    {"partition", Known(end.endpoint.partition)}});
  }
  return JsonLine({{"topic", topic}, {"writers", writers}, {"readers", readers}});
}

std::string SampleJson(const std::string& topic, const std::string& type, std::int64_t wall_ns,
                       std::string_view message_json) {
  return JsonLine({{"time", UtcText(wall_ns)},
                   {"topic", topic},
                   {"type", RosTypeName(type)},
                   {"sample", OrderedJson::parse(message_json, nullptr, false)}});
}

std::string RateJson(const std::string& topic, const SampleRate& rate) {
  OrderedJson json = {{"topic", topic},   {"samples", rate.all()}, {"rate_hz", nullptr},
                      {"min_s", nullptr}, {"max_s", nullptr},      {"stddev_s", nullptr},
                      {"window", nullptr}};
  if (const auto report = rate.Now()) {
    json["rate_hz"] = report->rate_hz;
    json["min_s"] = report->min_s;
    json["max_s"] = report->max_s;
    json["stddev_s"] = report->stddev_s;
    json["window"] = report->samples;
  }
  return JsonLine(json);
}

}  // namespace musher::cli
