#pragma once
// An MCAP file of recorded channels, with the schemas that Musher knows.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/view/mcap/writer.hpp"
#include "musher/view/record/sink.hpp"

namespace musher::view {

// In the metadata of a channel without a schema: its type, so that it can be played.
inline constexpr const char* kTypeOfUnknown = "musher_type";

// What the header of each file of ours names as its writer: "musher 1.0.0"; and whether a file has
// it.
std::string MusherLibrary();
bool IsByMusher(const std::string& path);

class RecordingFile {
 public:
  static Result<std::unique_ptr<RecordingFile>> Open(const std::string& path,
                                                     mcap::Compression compression);

  // `channel` is the sink's; it is declared in the file with its first message. A sample from
  // before the file begins, repeated because it is still true, has a `publish_ns` before `log_ns`.
  Result<> Write(const RecordedChannel& declared, std::size_t channel, std::int64_t log_ns,
                 std::int64_t publish_ns, const msg::Bytes& data);
  Result<> Flush() { return writer_->Flush(); }
  Result<> Close() { return writer_->Close(); }
  std::uint64_t bytes() const { return writer_->bytes_written(); }

 private:
  explicit RecordingFile(std::unique_ptr<mcap::Writer> writer) : writer_(std::move(writer)) {}

  struct Channel {
    std::uint16_t id = 0;
    std::uint32_t sequence = 0;
  };

  std::uint16_t SchemaOf(const std::string& type);

  std::unique_ptr<mcap::Writer> writer_;
  std::map<std::size_t, Channel> channels_;
  std::map<std::string, std::uint16_t> schemas_;
};

}  // namespace musher::view
