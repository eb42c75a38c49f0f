#pragma once
// Shared by the fuzzers. Each is one file with LLVMFuzzerTestOneInput(): libFuzzer calls it in the
// `fuzz` preset, replay_corpus.cpp in every other build.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace musher::fuzz {

// Aborts the process unless `holds`, also in builds without asserts.
inline void Require(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "violated: %s\n", what.c_str());
  std::abort();
}

// Reads values from bytes; past their end, zeros.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

  bool empty() const { return rest_.empty(); }

  template <class T>
  T Take() {
    static_assert(std::is_integral_v<T>);
    T value{};
    const std::size_t size = std::min(sizeof value, rest_.size());
    if (size > 0) std::memcpy(&value, rest_.data(), size);
    rest_ = rest_.subspan(size);
    return value;
  }
  std::uint8_t Byte() { return Take<std::uint8_t>(); }
  bool Bool() { return (Byte() & 1) != 0; }
  std::size_t Below(std::size_t n) { return Byte() % n; }

  // At most `longest` bytes, as many as the next byte says.
  std::string_view Text(std::size_t longest = 255) {
    return Bytes(std::min<std::size_t>(Byte(), longest));
  }
  std::string_view Rest() { return Bytes(rest_.size()); }

  // A boundary value, or any other number.
  std::uint64_t Number(std::uint64_t near, std::uint64_t last) {
    switch (Below(8)) {
      case 0:
        return 0;
      case 1:
        return near - 1;
      case 2:
        return near;
      case 3:
        return near + 1;
      case 4:
        return last;
      case 5:
        return last + 1;
      case 6:
        return UINT64_MAX - Byte();
      default:
        return Take<std::uint64_t>();
    }
  }

 private:
  std::string_view Bytes(std::size_t size) {
    size = std::min(size, rest_.size());
    const std::string_view taken(reinterpret_cast<const char*>(rest_.data()), size);
    rest_ = rest_.subspan(size);
    return taken;
  }

  std::span<const std::uint8_t> rest_;
};

}  // namespace musher::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
