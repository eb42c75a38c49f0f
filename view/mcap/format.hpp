#pragma once
// What writer and reader of MCAP share: the opcodes, and little-endian fields.

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace musher::mcap {

enum class Op : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kSummaryOffset = 14,
  kDataEnd = 15
};

inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);

// Appends fields to a buffer.
class Fields {
 public:
  template <class Number>
  Fields& Put(Number value) {
    char bytes[sizeof(Number)];
    std::memcpy(bytes, &value, sizeof(Number));
    data_.append(bytes, sizeof(Number));
    return *this;
  }
  Fields& Raw(std::string_view bytes) {
    data_ += bytes;
    return *this;
  }
  Fields& Text(std::string_view text) {
    return Put(static_cast<std::uint32_t>(text.size())).Raw(text);
  }
  Fields& Map(const std::map<std::string, std::string>& map) {
    Fields all;
    for (const auto& [key, value] : map) all.Text(key).Text(value);
    return Text(all.data_);
  }
  const std::string& data() const { return data_; }
  std::string& data() { return data_; }

 private:
  std::string data_;
};

// Takes fields from the beginning of a buffer; a missing one is zero or empty, and ok() false.
class Parser {
 public:
  explicit Parser(std::string_view data) : rest_(data) {}

  template <class Number>
  Number Get() {
    Number value{};
    const std::string_view bytes = Raw(sizeof(Number));
    if (bytes.size() == sizeof(Number)) std::memcpy(&value, bytes.data(), sizeof(Number));
    return value;
  }
  std::string_view Raw(std::uint64_t size) {
    if (size > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }
  std::string_view Text() { return Raw(Get<std::uint32_t>()); }
  std::map<std::string, std::string> Map() {
    Parser all(Text());
    std::map<std::string, std::string> map;
    while (all.ok() && !all.rest().empty()) {
      const std::string key(all.Text());
      map[key] = std::string(all.Text());
    }
    ok_ = ok_ && all.ok();
    return map;
  }
  std::string_view rest() const { return rest_; }
  bool ok() const { return ok_; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

// `name` is that of the file format: "", "lz4", "zstd".
std::string Compress(const std::string& name, std::string_view data);
// nullopt: damaged, or not of that size.
std::optional<std::string> Decompress(std::string_view name, std::string_view data,
                                      std::uint64_t size);
std::uint32_t Crc(std::string_view data, std::uint32_t before = 0);

}  // namespace musher::mcap
