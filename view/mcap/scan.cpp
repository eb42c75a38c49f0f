#include "musher/view/mcap/scan.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "musher/base/words.hpp"
#include "musher/view/mcap/format.hpp"

namespace musher::mcap {
namespace {

constexpr std::uint64_t kRecordHead = 9;  // opcode and length
constexpr std::uint64_t kMessageHead = 22;
constexpr std::uint64_t kMostInMemory = std::uint64_t{1} << 31;

Error Why(const std::string& path, const std::string& what) {
  return {kCodeParametersInvalid, path + ": " + what};
}

}  // namespace

std::string LibraryOf(const std::string& path) {
  const UniqueFd fd(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  std::string head(512, '\0');
  const ssize_t size = fd.valid() ? pread(fd.get(), head.data(), head.size(), 0) : 0;
  head.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  Parser fields(head);
  const bool is_mcap = fields.Raw(kMagic.size()) == kMagic &&
                       fields.Get<std::uint8_t>() == static_cast<std::uint8_t>(Op::kHeader);
  if (!is_mcap) return "";
  fields.Get<std::uint64_t>();  // the length
  fields.Text();                // the profile
  return std::string(fields.Text());
}

Result<std::unique_ptr<Scan>> Scan::Open(const std::string& path) {
  UniqueFd fd(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (fd.get() < 0 || fstat(fd.get(), &status) != 0) {
    return Why(path, std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
  }
  if (!S_ISREG(status.st_mode)) return Why(path, "it is not a file; expected an MCAP file");
  std::unique_ptr<Scan> scan(
      new Scan(path, std::move(fd), static_cast<std::uint64_t>(status.st_size)));
  if (auto indexed = scan->Index(); !indexed) return indexed.error();
  return scan;
}

Result<> Scan::Index() {
  const auto magic = ReadAt(0, std::min<std::uint64_t>(size_, kMagic.size()));
  if (!magic) return magic.error();
  if (magic.value() != kMagic) return Why(path_, "it is not an MCAP file");
  std::uint64_t at = kMagic.size();
  for (bool more = true; more;) {
    if (size_ - at < kRecordHead) {
      Damaged(at, "the file has no end: its writer was stopped");
      break;
    }
    const auto head = ReadAt(at, kRecordHead);
    if (!head) return head.error();
    Parser fields(head.value());
    const auto op = fields.Get<std::uint8_t>();
    const auto length = fields.Get<std::uint64_t>();
    if (length > size_ - at - kRecordHead) {
      Damaged(at, "a record is cut off");
      break;
    }
    if (op == static_cast<std::uint8_t>(Op::kDataEnd)) break;
    more = IndexRecord(op, at + kRecordHead, length);
    at += kRecordHead + length;
  }
  std::stable_sort(messages_.begin(), messages_.end(),
                   [](const auto& a, const auto& b) { return a.log_ns < b.log_ns; });
  return Ok();
}

bool Scan::IndexRecord(std::uint8_t op, std::uint64_t at, std::uint64_t length) {
  if (op == static_cast<std::uint8_t>(Op::kChunk)) return IndexChunk(at, length);
  const bool wanted = op == static_cast<std::uint8_t>(Op::kSchema) ||
                      op == static_cast<std::uint8_t>(Op::kChannel) ||
                      op == static_cast<std::uint8_t>(Op::kMessage);
  if (!wanted) return true;
  if (length > kMostInMemory) return Damaged(at, "a record is too large");
  const auto content = ReadAt(at, length);
  if (!content) return Damaged(at, content.error().message);
  if (op != static_cast<std::uint8_t>(Op::kMessage)) {
    return Define(op, content.value()) || Damaged(at, "a definition is damaged");
  }
  chunks_.push_back({at, 0, length, "", 0});
  return Message(content.value(), static_cast<std::uint32_t>(chunks_.size() - 1), kMessageHead) ||
         Damaged(at, "a message is damaged");
}

bool Scan::IndexChunk(std::uint64_t at, std::uint64_t length) {
  const auto head = ReadAt(at, std::min<std::uint64_t>(length, 64));
  if (!head) return Damaged(at, head.error().message);
  Parser fields(head.value());
  fields.Raw(16);  // its times
  Chunk chunk;
  chunk.size = fields.Get<std::uint64_t>();
  chunk.crc = fields.Get<std::uint32_t>();
  chunk.compression = std::string(fields.Text());
  chunk.length = fields.Get<std::uint64_t>();
  const std::uint64_t taken = head.value().size() - fields.rest().size();
  chunk.at = at + taken;
  if (!fields.ok() || chunk.length > length - taken || chunk.size > kMostInMemory) {
    return Damaged(at, "a chunk is damaged");
  }
  const auto records = Uncompressed(chunk);
  if (!records) return Damaged(at, records.error().message);
  chunks_.push_back(chunk);
  return Records(records.value(), static_cast<std::uint32_t>(chunks_.size() - 1), at);
}

bool Scan::Records(std::string_view records, std::uint32_t chunk, std::uint64_t at) {
  Parser rest(records);
  while (!rest.rest().empty()) {
    const auto op = rest.Get<std::uint8_t>();
    const auto length = rest.Get<std::uint64_t>();
    const std::uint64_t begin = records.size() - rest.rest().size();
    const std::string_view content = rest.Raw(length);
    bool good = rest.ok();
    if (good && op == static_cast<std::uint8_t>(Op::kMessage)) {
      good = Message(content, chunk, begin + kMessageHead);
    } else if (good) {
      good = Define(op, content);
    }
    if (!good) return Damaged(at, "a record in a chunk is damaged");
  }
  return true;
}

bool Scan::Define(std::uint8_t op, std::string_view content) {
  Parser fields(content);
  const auto id = fields.Get<std::uint16_t>();
  if (op == static_cast<std::uint8_t>(Op::kSchema)) {
    ScannedSchema schema;
    schema.name = std::string(fields.Text());
    schema.encoding = std::string(fields.Text());
    schema.data = std::string(fields.Text());
    if (fields.ok()) schemas_[id] = std::move(schema);
  } else if (op == static_cast<std::uint8_t>(Op::kChannel)) {
    ScannedChannel channel;
    channel.schema = fields.Get<std::uint16_t>();
    channel.topic = std::string(fields.Text());
    channel.encoding = std::string(fields.Text());
    channel.metadata = fields.Map();
    if (fields.ok()) channels_[id] = std::move(channel);
  }
  return fields.ok();
}

bool Scan::Message(std::string_view content, std::uint32_t chunk, std::uint64_t offset) {
  Parser fields(content);
  ScannedMessage message;
  message.channel = fields.Get<std::uint16_t>();
  message.sequence = fields.Get<std::uint32_t>();
  message.log_ns = static_cast<std::int64_t>(fields.Get<std::uint64_t>());
  message.publish_ns = static_cast<std::int64_t>(fields.Get<std::uint64_t>());
  message.chunk = chunk;
  message.offset = offset;
  message.size = fields.rest().size();
  if (!fields.ok() || !channels_.contains(message.channel)) return false;
  messages_.push_back(message);
  return true;
}

Result<std::string> Scan::ReadAt(std::uint64_t at, std::uint64_t length) const {
  std::string data(length, '\0');
  std::size_t done = 0;
  while (done < data.size()) {
    const ssize_t taken =
        pread(fd_.get(), data.data() + done, data.size() - done, static_cast<off_t>(at + done));
    if (taken < 0 && errno == EINTR) continue;
    if (taken < 0) return Why(path_, std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
    if (taken == 0) return Why(path_, "the file became shorter while it was read");
    done += static_cast<std::size_t>(taken);
  }
  return data;
}

Result<std::string> Scan::Uncompressed(const Chunk& chunk) const {
  auto data = ReadAt(chunk.at, chunk.length == 0 ? chunk.size : chunk.length);
  if (!data || chunk.length == 0) return data;
  auto records = Decompress(chunk.compression, data.value(), chunk.size);
  if (!records) return Error{kCodeFailed, "a chunk cannot be decompressed"};
  if (chunk.crc != 0 && Crc(*records) != chunk.crc) {
    return Error{kCodeFailed, "the checksum of a chunk is wrong"};
  }
  return std::move(*records);
}

bool Scan::Damaged(std::uint64_t at, const std::string& what) {
  damage_ = path_ + ": at byte " + std::to_string(at) + ": " + what + "; " +
            Counted(messages_.size(), "message") + " could be read before it";
  return false;
}

Result<std::vector<std::byte>> Scan::Read(const ScannedMessage& message) {
  if (cached_ != message.chunk + 1) {
    auto records = Uncompressed(chunks_.at(message.chunk));
    if (!records) return records.error();
    cache_ = std::move(records).value();
    cached_ = message.chunk + 1;
  }
  if (message.offset + message.size > cache_.size()) return Why(path_, "a chunk has changed");
  const auto* begin = reinterpret_cast<const std::byte*>(cache_.data() + message.offset);
  return std::vector<std::byte>(begin, begin + message.size);
}

}  // namespace musher::mcap
