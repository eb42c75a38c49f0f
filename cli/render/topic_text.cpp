#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <set>

#include "musher/base/words.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/render/topic.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::cli {
namespace {

using transport::DiscoveredEndpoint;
using transport::Qos;

constexpr std::size_t kMostListed = 16;  // of a list on one line

const char* ReliabilityText(const DiscoveredEndpoint& endpoint) {
  return endpoint.reliability == Qos::Reliability::kReliable ? "reliable" : "best effort";
}

const char* DurabilityText(const DiscoveredEndpoint& endpoint) {
  return endpoint.durability == Qos::Durability::kTransientLocal ? "transient local" : "volatile";
}

std::string RosTypeText(const std::string& dds_type) {
  const std::string ros = view::RosType(dds_type);
  return Printable(ros.empty() ? dds_type : ros);
}

// "/dog1/lidar", "process 123"
std::string EndName(const TopicEnd& end) {
  if (!end.node.empty()) return Printable(end.node);
  return end.pid == 0 ? "an unnamed process" : fmt::format("process {}", end.pid);
}

std::string EndProcess(const TopicEnd& end) {
  if (end.pid == 0) return Printable(end.host);
  return fmt::format("{}{}", end.pid, end.host.empty() ? "" : " on " + Printable(end.host));
}

std::string YamlIndent(std::size_t depth) {
  return std::string(2 * depth, ' ');
}

// Whether YAML reads it as this text without quotes; or it is an integer that JSON has as a text.
bool IsPlainYaml(const std::string& text) {
  constexpr std::string_view kDigits = "0123456789";
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_/";
  static const std::set<std::string> words = {"true", "false", "null", "yes", "no", "on", "off"};
  std::string lower = text;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (text.empty() || words.contains(lower)) return false;
  const std::size_t first = text.front() == '-' ? 1 : 0;
  if (text.find_first_not_of(kDigits, first) == std::string::npos) return text.size() >= 16;
  const std::string ordinary = std::string(kLetters) + std::string(kDigits) + ".-+() ";
  return kLetters.find(text.front()) != std::string_view::npos && text.back() != ' ' &&
         text.find_first_not_of(ordinary) == std::string::npos;
}

// Texts that YAML would read as something else are in quotes.
std::string YamlScalar(const OrderedJson& value) {
  if (value.is_string() && IsPlainYaml(value.get_ref<const std::string&>())) {
    return value.get<std::string>();
  }
  return Printable(JsonLine(value));
}

bool IsFlatYaml(const OrderedJson& value) {
  return !value.is_structured() || value.empty();
}

// A list of scalars: on one line.
std::string YamlList(const OrderedJson& list, bool whole) {
  std::string text;
  std::size_t shown = 0;
  for (const OrderedJson& element : list) {
    if (!whole && shown == kMostListed) {
      text += fmt::format(", ... {} in all", list.size());
      break;
    }
    text += (shown++ == 0 ? "" : ", ") + YamlScalar(element);
  }
  return "[" + text + "]";
}

std::string YamlBlock(const OrderedJson& value, std::size_t depth, bool whole);

// Behind "name:", or behind the "-" of a list.
std::string YamlValue(const OrderedJson& value, std::size_t depth, bool whole) {
  if (IsFlatYaml(value)) return " " + YamlScalar(value) + "\n";
  const bool flat_list =
      value.is_array() &&
      std::all_of(value.begin(), value.end(), [](const OrderedJson& e) { return IsFlatYaml(e); });
  if (flat_list) return " " + YamlList(value, whole) + "\n";
  return "\n" + YamlBlock(value, depth, whole);
}

std::string YamlBlock(const OrderedJson& value, std::size_t depth, bool whole) {
  std::string text;
  if (value.is_object()) {
    for (const auto& [name, member] : value.items()) {
      text += YamlIndent(depth) + Printable(name) + ":" + YamlValue(member, depth + 1, whole);
    }
    return text;
  }
  std::size_t shown = 0;
  for (const OrderedJson& element : value) {
    if (!whole && shown++ == kMostListed) {
      return text + YamlIndent(depth) + fmt::format("... {} in all\n", value.size());
    }
    text += YamlIndent(depth) + "-" + YamlValue(element, depth + 1, whole);
  }
  return text;
}

}  // namespace

std::string TopicsText(const std::vector<view::ListedTopic>& topics, bool colour) {
  Table table({"TOPIC", "WRITERS", "READERS", "TYPE"});
  for (const view::ListedTopic& topic : topics) {
    table.Add({{Printable(topic.name)},
               {std::to_string(topic.publishers)},
               {std::to_string(topic.subscribers)},
               {Printable(topic.type)}});
  }
  return table.Text(colour);
}

std::string QosMismatch(const DiscoveredEndpoint& writer, const DiscoveredEndpoint& reader) {
  if (writer.type != reader.type) {
    return "it has the type " + RosTypeText(reader.type) + ", not " + RosTypeText(writer.type);
  }
  if (writer.reliability == Qos::Reliability::kBestEffort &&
      reader.reliability == Qos::Reliability::kReliable) {
    return "it requests reliable samples, which are offered as best effort";
  }
  if (writer.durability == Qos::Durability::kVolatile &&
      reader.durability == Qos::Durability::kTransientLocal) {
    return "it requests transient local samples, which are offered as volatile";
  }
  return {};
}

std::string TopicInfoText(const std::string& topic, const std::vector<TopicEnd>& ends,
                          bool colour) {
  std::vector<std::string> types;
  for (const TopicEnd& end : ends) {
    const std::string type = RosTypeText(end.endpoint.type);
    if (std::find(types.begin(), types.end(), type) == types.end()) types.push_back(type);
  }
  std::string text = Paint(Printable(topic), Style::kBold, colour);
  for (const std::string& type : types) text += (&type == types.data() ? "  " : ", ") + type;
  text += "\n";
  Table table({"", "NODE", "PROCESS", "RELIABILITY", "DURABILITY", "PARTITION"});
  std::string mismatches;
  for (const bool writers : {true, false}) {
    for (const TopicEnd& end : ends) {
      if (end.endpoint.writer != writers) continue;
      table.Add({{writers ? "writer" : "reader"},
                 {end.node.empty() ? "-" : Printable(end.node)},
                 {EndProcess(end)},
                 {ReliabilityText(end.endpoint)},
                 {DurabilityText(end.endpoint)},
                 {Printable(end.endpoint.partition)}});
      if (!writers) continue;
      for (const TopicEnd& reader : ends) {
        if (reader.endpoint.writer) continue;
        const std::string why = QosMismatch(end.endpoint, reader.endpoint);
        if (why.empty()) continue;
        mismatches +=
            Paint("reader " + EndName(reader) + " receives nothing of " + EndName(end) + ": " + why,
                  Style::kBad, colour) +
            "\n";
      }
    }
  }
  return text + table.Text(colour) + mismatches;
}

std::string SampleText(std::string_view message_json, bool whole) {
  const OrderedJson message = OrderedJson::parse(message_json, nullptr, false);
  return message.is_object() && !message.empty() ? YamlBlock(message, 0, whole) : "{}\n";
}

std::string RateText(const SampleRate& rate) {
  const auto report = rate.Now();
  if (!report) return Counted(rate.all(), "sample") + ", too few for a rate";
  return fmt::format(
      "{:.2f} Hz, between two samples {:.1f} to {:.1f} ms, standard deviation {:.2f} ms ({})",
      report->rate_hz, 1e3 * report->min_s, 1e3 * report->max_s, 1e3 * report->stddev_s,
      Counted(report->samples, "sample"));
}

}  // namespace musher::cli
