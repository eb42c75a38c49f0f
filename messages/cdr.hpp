#pragma once
// Messages as bytes: XCDR version 1, as ROS 2 on Cyclone DDS encodes them.
//
// A message is a plain struct that names its fields once, in wire order:
//
//   struct String {
//     static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::String_";
//     std::string data;
//     template <class Self> static auto Fields(Self& m) { return std::tie(m.data); }
//   };
//
// Field types: bool, integers, float, double, std::string, std::vector and std::array of any of
// these, and other messages. The IDL in messages/idl is the contract; test/contract proves that the
// structs and the IDL say the same.
//
// Decoding trusts nothing: lengths are checked against the bytes at hand before anything is
// allocated, and a malformed sample gives nullopt. Reentrant, no global state.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

namespace musher::msg {

using Bytes = std::vector<std::byte>;

template <class T>
concept Message = requires(T& m) {
  { T::kTypeName } -> std::convertible_to<std::string_view>;
  T::Fields(m);
};

// A struct inside a message: fields, but no type name of its own is needed.
template <class T>
concept Fielded = requires(T& m) {
  T::Fields(m);
};

class CdrWriter {
 public:
  // Starts with the encapsulation header of little-endian CDR.
  CdrWriter() {
    bytes_.reserve(kUsualSize);
    bytes_ = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  }

  template <class T>
  requires(std::is_arithmetic_v<T>) void Put(T value) {
    if constexpr (std::is_same_v<T, bool>) {
      Put(static_cast<std::uint8_t>(value ? 1 : 0));
    } else {
      static_assert(std::endian::native == std::endian::little,
                    "big-endian hosts are not supported");
      Align(sizeof(T));
      Append(&value, sizeof(T));
    }
  }
  void Put(const std::string& text) {
    const std::size_t size = text.size() + 1;  // with its terminating zero
    Put(static_cast<std::uint32_t>(size));
    Append(text.c_str(), size);
  }
  template <class T>
  void Put(const std::vector<T>& items) {
    Put(static_cast<std::uint32_t>(items.size()));
    for (const auto& item : items) Put(static_cast<const T&>(item));
  }
  template <class T, std::size_t N>
  void Put(const std::array<T, N>& items) {
    for (const T& item : items) Put(item);
  }
  template <Fielded T>
  void Put(const T& message) {
    std::apply([this](const auto&... field) { (Put(field), ...); }, T::Fields(message));
  }

  Bytes Take() && { return std::move(bytes_); }

 private:
  void Align(std::size_t size) {
    const std::size_t offset = bytes_.size() - kHeaderSize;
    bytes_.resize(bytes_.size() + (size - offset % size) % size);
  }

  void Append(const void* data, std::size_t size) {
    const auto* begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }

  static constexpr std::size_t kHeaderSize = 4;
  static constexpr std::size_t kUsualSize = 256;  // of what is reserved at once
  Bytes bytes_;
};

class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> bytes) : bytes_(bytes) {
    // 0x0000 is big-endian and 0x0001 little-endian plain CDR; the two bytes after are options.
    if (bytes_.size() < kHeaderSize || bytes_[0] != std::byte{0} || bytes_[1] > std::byte{1}) {
      ok_ = false;
      return;
    }
    swap_ = bytes_[1] == std::byte{0};
    at_ = kHeaderSize;
  }

  bool ok() const { return ok_; }

  template <class T>
  requires(std::is_arithmetic_v<T>) void Get(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      Get(byte);
      if (byte > 1) ok_ = false;
      value = byte == 1;
    } else {
      const std::size_t offset = at_ - kHeaderSize;
      const std::size_t start = at_ + (sizeof(T) - offset % sizeof(T)) % sizeof(T);
      if (!ok_ || start > bytes_.size() || bytes_.size() - start < sizeof(T)) {
        ok_ = false;
        return;
      }
      std::array<std::byte, sizeof(T)> raw;
      std::memcpy(raw.data(), bytes_.data() + start, sizeof(T));
      if (swap_) {
        for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(raw[i], raw[sizeof(T) - 1 - i]);
      }
      std::memcpy(&value, raw.data(), sizeof(T));
      at_ = start + sizeof(T);
    }
  }
  void Get(std::string& text) {
    std::uint32_t size = 0;
    Get(size);
    if (!ok_ || size == 0 || size > Left() || bytes_[at_ + size - 1] != std::byte{0}) {
      ok_ = false;
      return;
    }
    text.assign(reinterpret_cast<const char*>(bytes_.data() + at_), size - 1);
    at_ += size;
  }
  template <class T>
  void Get(std::vector<T>& items) {
    std::uint32_t count = 0;
    Get(count);
    if (!ok_ || count > Left()) {  // every item takes at least one byte
      ok_ = false;
      return;
    }
    items.clear();
    for (std::uint32_t i = 0; ok_ && i < count; ++i) {
      T item{};
      Get(item);
      items.push_back(std::move(item));
    }
  }
  template <class T, std::size_t N>
  void Get(std::array<T, N>& items) {
    for (T& item : items) Get(item);
  }
  template <Fielded T>
  void Get(T& message) {
    std::apply([this](auto&... field) { (Get(field), ...); }, T::Fields(message));
  }

 private:
  std::size_t Left() const { return bytes_.size() - at_; }

  static constexpr std::size_t kHeaderSize = 4;
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool swap_ = false;
  bool ok_ = true;
};

// The bytes of a message, encapsulation header included.
template <Fielded T>
Bytes Encode(const T& message) {
  CdrWriter writer;
  writer.Put(message);
  return std::move(writer).Take();
}

// The message in `bytes`; nullopt when they are not one.
template <Fielded T>
std::optional<T> Decode(std::span<const std::byte> bytes) {
  CdrReader reader(bytes);
  T message{};
  reader.Get(message);
  if (!reader.ok()) return std::nullopt;
  return message;
}

// A service as ROS 2 maps it: two topics whose samples start with this header.
struct RequestId {
  std::uint64_t client = 0;   // chosen by the client, unique in the domain
  std::int64_t sequence = 0;  // grows with each request of that client

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.client, m.sequence);
  }
  friend bool operator==(const RequestId&, const RequestId&) = default;
};

// A service type: request and response bodies and the name the DDS types derive from,
// e.g. "std_srvs::srv::dds_::Trigger_" gives "…Trigger_Request_" and "…Trigger_Response_".
template <class S>
concept Service = requires {
  typename S::Request;
  typename S::Response;
  { S::kTypeName } -> std::convertible_to<std::string_view>;
}
&&Fielded<typename S::Request>&& Fielded<typename S::Response>;

// A ROS 2 message without fields carries one unused byte.
struct Empty {
  std::uint8_t structure_needs_at_least_one_member = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.structure_needs_at_least_one_member);
  }
  friend bool operator==(const Empty&, const Empty&) = default;
};

}  // namespace musher::msg
