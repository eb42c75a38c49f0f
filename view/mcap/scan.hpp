#pragma once
// Reads an MCAP file by scanning it, so that one without a summary (its writer was killed) is read
// as well as a whole one. Trusts nothing in the file: what is damaged ends the reading with a
// sentence, and everything before it is there.
//
// Threads: one. Calls wait for the disk. A chunk must fit into memory, the file need not.

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher::mcap {

struct ScannedSchema {
  std::string name;
  std::string encoding;
  std::string data;
};

struct ScannedChannel {
  std::string topic;
  std::string encoding;
  std::uint16_t schema = 0;  // 0: none
  std::map<std::string, std::string> metadata;
};

// Where a message is.
struct ScannedMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::int64_t log_ns = 0;
  std::int64_t publish_ns = 0;
  std::uint32_t chunk = 0;
  std::uint64_t offset = 0;  // of its data in the uncompressed chunk
  std::uint64_t size = 0;
};

// The program that wrote the file, as its header has it: "musher 1.0.0"; empty: the file is no MCAP
// file, or cannot be read.
std::string LibraryOf(const std::string& path);

class Scan {
 public:
  // Fails if the file cannot be read or is no MCAP file; not for damage further on.
  static Result<std::unique_ptr<Scan>> Open(const std::string& path);

  // Messages by time; with equal times in the order of the file.
  const std::vector<ScannedMessage>& messages() const { return messages_; }
  const std::map<std::uint16_t, ScannedChannel>& channels() const { return channels_; }
  const std::map<std::uint16_t, ScannedSchema>& schemas() const { return schemas_; }
  // Why the file could not be read to its end; "" if it could. A file without a summary is said
  // here, too.
  const std::string& damage() const { return damage_; }
  std::uint64_t file_bytes() const { return size_; }

  Result<std::vector<std::byte>> Read(const ScannedMessage& message);

 private:
  struct Chunk {
    std::uint64_t at = 0;      // of the compressed data in the file
    std::uint64_t length = 0;  // 0: not compressed and not a chunk
    std::uint64_t size = 0;    // uncompressed
    std::string compression;
    std::uint32_t crc = 0;
  };

  Scan(std::string path, UniqueFd fd, std::uint64_t size)
      : path_(std::move(path)), fd_(std::move(fd)), size_(size) {}

  Result<> Index();
  bool IndexRecord(std::uint8_t op, std::uint64_t at, std::uint64_t length);
  bool IndexChunk(std::uint64_t at, std::uint64_t length);
  bool Records(std::string_view records, std::uint32_t chunk, std::uint64_t at);
  bool Define(std::uint8_t op, std::string_view content);
  bool Message(std::string_view content, std::uint32_t chunk, std::uint64_t offset);
  Result<std::string> ReadAt(std::uint64_t at, std::uint64_t length) const;
  Result<std::string> Uncompressed(const Chunk& chunk) const;
  bool Damaged(std::uint64_t at, const std::string& what);

  std::string path_;
  UniqueFd fd_;
  std::uint64_t size_;
  std::string damage_;
  std::vector<Chunk> chunks_;
  std::map<std::uint16_t, ScannedSchema> schemas_;
  std::map<std::uint16_t, ScannedChannel> channels_;
  std::vector<ScannedMessage> messages_;
  std::uint32_t cached_ = 0;  // one more than the chunk in `cache_`
  std::string cache_;
};

}  // namespace musher::mcap
