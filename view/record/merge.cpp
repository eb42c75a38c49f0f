#include "musher/view/record/merge.hpp"

#include <cstdio>
#include <map>
#include <utility>

#include "musher/base/words.hpp"
#include "musher/view/mcap/scan.hpp"
#include "musher/view/record/recording_file.hpp"

namespace musher::view {
namespace {

// Copies channels of several files into one writer.
class Copy {
 public:
  explicit Copy(mcap::Writer& writer) : writer_(writer) {}

  Result<> Message(mcap::Scan& scan, const mcap::ScannedMessage& message) {
    auto data = scan.Read(message);
    if (!data) return data.error();
    const std::uint16_t channel = ChannelOf(scan, scan.channels().at(message.channel));
    return writer_.Write(channel, message.sequence, message.log_ns, message.publish_ns,
                         data.value());
  }

 private:
  std::uint16_t ChannelOf(const mcap::Scan& scan, const mcap::ScannedChannel& channel) {
    const auto schema = scan.schemas().find(channel.schema);
    const bool has_schema = channel.schema != 0 && schema != scan.schemas().end();
    const std::string type = has_schema ? schema->second.name : "";
    const auto [known, is_new] = channels_.try_emplace({channel.topic, type}, 0);
    if (!is_new) return known->second;
    std::uint16_t id = 0;
    if (has_schema) {
      std::uint16_t& of_type = schemas_[type];
      if (of_type == 0) {
        const mcap::ScannedSchema& one = schema->second;
        of_type = writer_.AddSchema(one.name, one.encoding, one.data);
      }
      id = of_type;
    }
    return known->second =
               writer_.AddChannel(id, channel.topic, channel.encoding, channel.metadata);
  }

  mcap::Writer& writer_;
  std::map<std::pair<std::string, std::string>, std::uint16_t> channels_;
  std::map<std::string, std::uint16_t> schemas_;
};

}  // namespace

Result<> MergeSegments(const std::vector<std::string>& segments, const std::string& out,
                       mcap::Compression compression) {
  const std::string part = out + ".part";
  std::remove(part.c_str());
  mcap::WriterOptions options;
  options.compression = compression;
  options.library = MusherLibrary();
  auto writer = mcap::Writer::Open(part, options);
  if (!writer) {
    std::remove(part.c_str());
    return writer.error();
  }
  Copy copy(*writer.value());
  bool first = true;
  for (const std::string& segment : segments) {
    const auto scan = mcap::Scan::Open(segment);
    if (!scan) continue;
    for (const mcap::ScannedMessage& message : scan.value()->messages()) {
      const bool repeated = message.publish_ns < message.log_ns;
      if (repeated && !first) continue;
      if (auto copied = copy.Message(*scan.value(), message); !copied) {
        std::remove(part.c_str());
        return copied;
      }
    }
    first = false;
  }
  auto closed = writer.value()->Close();
  if (closed && first) closed = Error{kCodeFailed, "no segment can be read"};
  if (closed && std::rename(part.c_str(), out.c_str()) != 0) {
    closed = Error{kCodeFailed, out + " cannot be created"};
  }
  if (!closed) std::remove(part.c_str());
  return closed;
}

Result<std::string> Recover(const std::string& damaged, const std::string& out,
                            mcap::Compression compression) {
  auto scan = mcap::Scan::Open(damaged);
  if (!scan) return scan.error();
  auto writer = mcap::Writer::Open(out, {compression});
  if (!writer) return writer.error();
  Copy copy(*writer.value());
  for (const mcap::ScannedMessage& message : scan.value()->messages()) {
    if (auto copied = copy.Message(*scan.value(), message); !copied) return copied.error();
  }
  if (auto closed = writer.value()->Close(); !closed) return closed.error();
  const std::string& damage = scan.value()->damage();
  return out + ": " + Counted(scan.value()->messages().size(), "message") +
         (damage.empty() ? "; " + damaged + " is whole" : "; " + damage);
}

}  // namespace musher::view
