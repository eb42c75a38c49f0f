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
// these, and other messages. Messages of the IDL are generated (messages/README.md); test/contract
// proves that they are encoded as idlc's.
//
// A message that has grown says by `static constexpr std::size_t kAppended` how many of its last
// fields an older peer does not send; they keep their default then, and an older peer does not read
// them. It grows at its end only, and only where nothing follows it in another message.
//
// Decoding trusts nothing: lengths are checked against the bytes at hand before anything is
// allocated, and a malformed sample gives nullopt. Reentrant, no global state.

#include <algorithm>
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

// Numbers that lie in memory as they do on the wire: sequences of them are copied as one block, for
// a picture is one. (A bool may be neither 0 nor 1 on the wire.)
template <class T>
concept Plain = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

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
    if constexpr (Plain<T>) {
      if (!items.empty()) PutBlock(std::span<const T>(items));
    } else {
      for (const auto& item : items) Put(static_cast<const T&>(item));
    }
  }
  template <class T, std::size_t N>
  void Put(const std::array<T, N>& items) {
    if constexpr (Plain<T>) {
      PutBlock(std::span<const T>(items));
    } else {
      for (const T& item : items) Put(item);
    }
  }
  template <Fielded T>
  void Put(const T& message) {
    std::apply([&](const auto&... field) { (Put(field), ...); }, T::Fields(message));
  }

  Bytes Take() && { return std::move(bytes_); }

 private:
  template <class T>
  void PutBlock(std::span<const T> items) {
    Align(sizeof(T));
    // All that follows in a picture, and what a transport may add to the end.
    if (items.size_bytes() > bytes_.capacity()) {
      bytes_.reserve(bytes_.size() + items.size_bytes() + kUsualSize);
    }
    Append(items.data(), items.size_bytes());
  }

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
      const std::byte* raw = Block(sizeof(T), 1);
      if (raw != nullptr) Copy(raw, std::span<T>(&value, 1));
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
    if constexpr (Plain<T>) {
      const std::byte* raw = count == 0 ? nullptr : Block(sizeof(T), count);
      if (raw == nullptr) return;
      if constexpr (sizeof(T) == 1) {  // straight into place: a picture is large
        items.assign(reinterpret_cast<const T*>(raw), reinterpret_cast<const T*>(raw) + count);
      } else {
        items.resize(count);
        Copy(raw, std::span<T>(items));
      }
    } else {
      for (std::uint32_t i = 0; ok_ && i < count; ++i) {
        T item{};
        Get(item);
        items.push_back(std::move(item));
      }
    }
  }
  template <class T, std::size_t N>
  void Get(std::array<T, N>& items) {
    if constexpr (Plain<T>) {
      const std::byte* raw = Block(sizeof(T), N);
      if (raw != nullptr) Copy(raw, std::span<T>(items));
    } else {
      for (T& item : items) Get(item);
    }
  }
  template <Fielded T>
  void Get(T& message) {
    constexpr std::size_t kFields = std::tuple_size_v<decltype(T::Fields(message))>;
    [[maybe_unused]] std::size_t i = 0;
    std::apply([&](auto&... field) { (GetOr<T>(field, i++, kFields), ...); }, T::Fields(message));
  }

 private:
  // One field of a T, or nothing where an older peer has not sent it.
  template <class T, class F>
  void GetOr(F& field, std::size_t i, std::size_t fields) {
    if constexpr (requires { T::kAppended; }) {
      if (i >= fields - T::kAppended && AtEnd<F>()) return;
    }
    Get(field);
  }

  // Whether nothing is left of a field of type F; padding is nothing.
  template <class F>
  bool AtEnd() const {
    constexpr std::size_t kLeast = std::is_arithmetic_v<F> ? sizeof(F) : sizeof(std::uint32_t);
    const std::size_t offset = at_ - kHeaderSize;
    return ok_ && Left() < (kLeast - offset % kLeast) % kLeast + kLeast;
  }

  std::size_t Left() const { return bytes_.size() - at_; }

  // The next `count` numbers of `size` bytes, which are then behind us; null (and not ok) when
  // there are not as many.
  const std::byte* Block(std::size_t size, std::size_t count) {
    const std::size_t offset = at_ - kHeaderSize;
    const std::size_t start = at_ + (size - offset % size) % size;
    if (!ok_ || start > bytes_.size() || (bytes_.size() - start) / size < count) {
      ok_ = false;
      return nullptr;
    }
    at_ = start + size * count;
    return bytes_.data() + start;
  }

  template <class T>
  void Copy(const std::byte* raw, std::span<T> items) const {
    std::memcpy(items.data(), raw, items.size_bytes());
    if (!swap_) return;
    for (T& item : items) {
      auto* bytes = reinterpret_cast<std::byte*>(&item);
      std::reverse(bytes, bytes + sizeof(T));
    }
  }

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
