#pragma once
// Writes an MCAP file (https://mcap.dev/spec), version 1: messages in compressed chunks, each
// followed by its message index, then a summary. What Flush() has written can be read after a
// crash.
//
// Threads: one at a time; calls wait for the disk. After an error every call returns that error,
// and the file holds what was written before it.

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"

namespace musher::mcap {

enum class Compression { kNone, kLz4, kZstd };

struct WriterOptions {
  Compression compression = Compression::kLz4;
  std::size_t chunk_bytes = 1 << 20;  // before compression
  bool crc = true;
  std::string library = "musher";
};

class Writer {
 public:
  // Fails if the file exists already.
  static Result<std::unique_ptr<Writer>> Open(const std::string& path, WriterOptions options);
  // Without Close() the file has no summary.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  std::uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view data);
  // Schema 0: none.
  std::uint16_t AddChannel(std::uint16_t schema, std::string_view topic, std::string_view encoding,
                           const std::map<std::string, std::string>& metadata);
  Result<> Write(std::uint16_t channel, std::uint32_t sequence, std::int64_t log_time_ns,
                 std::int64_t publish_time_ns, std::span<const std::byte> data);
  // Ends the chunk and gives it to the kernel: it survives the end of this process, not a power
  // cut.
  Result<> Flush();
  Result<> Close();

  std::uint64_t bytes_written() const;

 private:
  struct File;
  explicit Writer(std::unique_ptr<File> file);

  std::unique_ptr<File> file_;
};

}  // namespace musher::mcap
