// musher-record info and recover: files without a robot.

#include <fmt/format.h>

#include "musher/base/date_text.hpp"
#include "musher/view/mcap/scan.hpp"
#include "musher/view/record/commands.hpp"
#include "musher/view/record/merge.hpp"

namespace musher::view {
namespace {

struct TopicInfo {
  std::string type;
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
};

std::map<std::string, TopicInfo> TopicsOf(const mcap::Scan& scan) {
  std::map<std::string, TopicInfo> topics;
  for (const auto& [id, channel] : scan.channels()) {
    const auto schema = scan.schemas().find(channel.schema);
    topics[channel.topic].type = schema == scan.schemas().end() ? "-" : schema->second.name;
  }
  for (const mcap::ScannedMessage& message : scan.messages()) {
    TopicInfo& topic = topics[scan.channels().at(message.channel).topic];
    ++topic.messages;
    topic.bytes += message.size;
  }
  return topics;
}

}  // namespace

int RunInfo(const std::string& file) {
  const auto scan = mcap::Scan::Open(file);
  if (!scan) return Fail(scan.error());
  const auto& messages = scan.value()->messages();
  fmt::print("file      {} ({} bytes)\nmessages  {}\n", file, scan.value()->file_bytes(),
             messages.size());
  if (!messages.empty()) {
    const std::int64_t first = messages.front().log_ns;
    const std::int64_t last = messages.back().log_ns;
    fmt::print("from      {}\nto        {}\nduration  {:.3f} s\n", FormatUtc(WholeSeconds(first)),
               FormatUtc(WholeSeconds(last)), static_cast<double>(last - first) / 1e9);
  }
  fmt::print("{:>10} {:>14}  {:<40} TYPE\n", "MESSAGES", "BYTES", "TOPIC");
  for (const auto& [name, topic] : TopicsOf(*scan.value())) {
    fmt::print("{:>10} {:>14}  {:<40} {}\n", topic.messages, topic.bytes, name, topic.type);
  }
  std::fflush(stdout);
  if (scan.value()->damage().empty()) return 0;
  Print(scan.value()->damage() + "; musher-record recover writes a whole file");
  return 1;
}

int RunRecover(const std::string& damaged, const std::string& out) {
  const auto recovered = Recover(damaged, out, mcap::Compression::kLz4);
  if (!recovered) return Fail(recovered.error());
  fmt::print("{}\n", recovered.value());
  return 0;
}

}  // namespace musher::view
