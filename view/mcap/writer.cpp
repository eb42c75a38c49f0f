#include "musher/view/mcap/writer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/base/words.hpp"
#include "musher/view/mcap/format.hpp"

namespace musher::mcap {
namespace {

struct IndexedMessage {
  std::uint64_t log_time;
  std::uint64_t offset;  // in the uncompressed chunk
};

std::string Record(Op op, const std::string& content) {
  Fields record;
  record.Put(static_cast<std::uint8_t>(op))
      .Put(static_cast<std::uint64_t>(content.size()))
      .Raw(content);
  return std::move(record.data());
}

const char* NameOf(Compression compression) {
  return compression == Compression::kLz4 ? "lz4" : compression == Compression::kZstd ? "zstd" : "";
}

}  // namespace

struct Writer::File {
  std::string path;
  WriterOptions options;
  UniqueFd fd;
  std::uint64_t at = 0;  // bytes in the file
  std::optional<Error> error;
  bool closed = false;
  std::vector<std::string> definitions;  // records of schemas and channels
  std::uint16_t schemas = 0;
  std::uint16_t channels = 0;
  std::string chunk;
  std::map<std::uint16_t, std::vector<IndexedMessage>> index;  // of the chunk
  std::uint64_t first = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t last = 0;  // of the chunk, as first
  std::string chunk_indexes;
  std::uint64_t messages = 0;
  std::uint32_t chunks = 0;
  std::uint64_t begin = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t end = 0;
  std::map<std::uint16_t, std::uint64_t> counts;

  Result<> Append(std::string_view bytes) {
    if (error) return *error;
    const std::uint64_t before = at;
    while (!bytes.empty()) {
      const ssize_t written = write(fd.get(), bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) {
        const std::string why = std::strerror(errno);  // NOLINT(concurrency-mt-unsafe)
        error =
            Error{kCodeFailed, path + ": " + why + "; " +
                                   Counted(messages, "message was", "messages were") + " recorded"};
        // The file ends with a whole record.
        static_cast<void>(ftruncate(fd.get(), static_cast<off_t>(before)) == 0);
        at = before;
        return *error;
      }
      at += static_cast<std::uint64_t>(written);
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return Ok();
  }

  Result<> EndChunk() {
    if (error) return *error;
    if (chunk.empty()) return Ok();
    const std::string name = NameOf(options.compression);
    Fields content;
    content.Put(index.empty() ? std::uint64_t{0} : first)
        .Put(last)
        .Put(std::uint64_t{chunk.size()});
    content.Put(options.crc ? Crc(chunk) : 0U).Text(name);
    const std::string compressed = Compress(name, chunk);
    content.Put(std::uint64_t{compressed.size()}).Raw(compressed);
    std::string all = Record(Op::kChunk, content.data());
    const std::uint64_t length = all.size();
    Fields offsets;
    for (const auto& [channel, entries] : index) {
      offsets.Put(channel).Put(at + all.size());
      Fields list;
      for (const IndexedMessage& entry : entries) list.Put(entry.log_time).Put(entry.offset);
      Fields record;
      record.Put(channel).Text(list.data());
      all += Record(Op::kMessageIndex, record.data());
    }
    Fields chunk_index;
    chunk_index.Put(index.empty() ? std::uint64_t{0} : first).Put(last).Put(at).Put(length);
    chunk_index.Text(offsets.data()).Put(std::uint64_t{all.size() - length}).Text(name);
    chunk_index.Put(std::uint64_t{compressed.size()}).Put(std::uint64_t{chunk.size()});
    if (auto written = Append(all); !written) return written;
    chunk_indexes += Record(Op::kChunkIndex, chunk_index.data());
    ++chunks;
    for (const auto& [channel, entries] : index) {
      messages += entries.size();
      counts[channel] += entries.size();
    }
    if (!index.empty()) {
      begin = std::min(begin, first);
      end = std::max(end, last);
    }
    chunk.clear();
    index.clear();
    first = std::numeric_limits<std::uint64_t>::max();
    last = 0;
    return Ok();
  }

  std::string Statistics() const {
    Fields list;
    for (const auto& [channel, count] : counts) list.Put(channel).Put(count);
    Fields content;
    content.Put(messages).Put(schemas).Put(std::uint32_t{channels}).Put(std::uint32_t{0});
    content.Put(std::uint32_t{0}).Put(chunks);
    content.Put(messages == 0 ? std::uint64_t{0} : begin).Put(end).Text(list.data());
    return Record(Op::kStatistics, content.data());
  }

  Result<> Finish() {
    if (auto ended = EndChunk(); !ended) return ended;
    const std::string data_end = Record(Op::kDataEnd, Fields().Put(std::uint32_t{0}).data());
    std::string summary;
    Fields offsets;
    const std::uint64_t start = at + data_end.size();
    const auto group = [&](Op op, const std::string& records) {
      if (records.empty()) return;
      Fields offset;
      offset.Put(static_cast<std::uint8_t>(op)).Put(start + summary.size());
      offset.Put(std::uint64_t{records.size()});
      offsets.Raw(Record(Op::kSummaryOffset, offset.data()));
      summary += records;
    };
    std::string all_schemas;
    std::string all_channels;
    for (const std::string& record : definitions) {
      (record[0] == static_cast<char>(Op::kSchema) ? all_schemas : all_channels) += record;
    }
    group(Op::kSchema, all_schemas);
    group(Op::kChannel, all_channels);
    group(Op::kStatistics, Statistics());
    group(Op::kChunkIndex, chunk_indexes);
    Fields footer;  // its CRC covers the summary and the footer up to itself
    footer.Put(static_cast<std::uint8_t>(Op::kFooter)).Put(std::uint64_t{20}).Put(start);
    footer.Put(start + summary.size());
    const std::string covered = summary + offsets.data() + footer.data();
    footer.Put(options.crc ? Crc(covered) : 0U);
    return Append(data_end + summary + offsets.data() + footer.data() + std::string(kMagic));
  }
};

Writer::Writer(std::unique_ptr<File> file) : file_(std::move(file)) {}
Writer::~Writer() = default;

Result<std::unique_ptr<Writer>> Writer::Open(const std::string& path, WriterOptions options) {
  auto file = std::make_unique<File>();
  file->path = path;
  file->options = std::move(options);
  file->fd = UniqueFd(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (file->fd.get() < 0) {
    const std::string why = std::strerror(errno);  // NOLINT(concurrency-mt-unsafe)
    return Error{kCodeParametersInvalid, path + " cannot be created: " + why};
  }
  const std::string header =
      Record(Op::kHeader, Fields().Text("ros2").Text(file->options.library).data());
  if (auto written = file->Append(std::string(kMagic) + header); !written) {
    unlink(path.c_str());
    return written.error();
  }
  return std::unique_ptr<Writer>(new Writer(std::move(file)));
}

std::uint16_t Writer::AddSchema(std::string_view name, std::string_view encoding,
                                std::string_view data) {
  const std::uint16_t id = ++file_->schemas;
  file_->definitions.push_back(
      Record(Op::kSchema, Fields().Put(id).Text(name).Text(encoding).Text(data).data()));
  file_->chunk += file_->definitions.back();
  return id;
}

std::uint16_t Writer::AddChannel(std::uint16_t schema, std::string_view topic,
                                 std::string_view encoding,
                                 const std::map<std::string, std::string>& metadata) {
  const std::uint16_t id = ++file_->channels;
  file_->definitions.push_back(Record(
      Op::kChannel, Fields().Put(id).Put(schema).Text(topic).Text(encoding).Map(metadata).data()));
  file_->chunk += file_->definitions.back();
  return id;
}

Result<> Writer::Write(std::uint16_t channel, std::uint32_t sequence, std::int64_t log_time_ns,
                       std::int64_t publish_time_ns, std::span<const std::byte> data) {
  if (file_->error) return *file_->error;
  const auto log = static_cast<std::uint64_t>(std::max<std::int64_t>(log_time_ns, 0));
  file_->index[channel].push_back({log, file_->chunk.size()});
  file_->first = std::min(file_->first, log);
  file_->last = std::max(file_->last, log);
  Fields head;
  head.Put(static_cast<std::uint8_t>(Op::kMessage)).Put(std::uint64_t{22 + data.size()});
  head.Put(channel).Put(sequence).Put(log);
  head.Put(static_cast<std::uint64_t>(std::max<std::int64_t>(publish_time_ns, 0)));
  file_->chunk += head.data();
  file_->chunk.append(reinterpret_cast<const char*>(data.data()), data.size());
  return file_->chunk.size() >= file_->options.chunk_bytes ? file_->EndChunk() : Ok();
}

Result<> Writer::Flush() {
  return file_->EndChunk();
}

Result<> Writer::Close() {
  if (file_->error) return *file_->error;
  if (std::exchange(file_->closed, true)) return Ok();
  return file_->Finish();
}

std::uint64_t Writer::bytes_written() const {
  return file_->at;
}

}  // namespace musher::mcap
