#pragma once
// A number that names something, of a type of its own: two kinds cannot be swapped.
//
//   using Epoch = StrongNumber<struct EpochKind>;
//
// Threads: values, from any thread.

#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <string>

namespace musher {

// The type of a literal. A std::uint64_t is none: numbers of messages and of files have this type.
template <typename T>
concept LiteralNumber =
    std::integral<T> && !std::same_as<T, bool> && !std::same_as<T, std::uint64_t>;

// A number that converts to no other kind, and to no plain number: value() is the way back.
template <typename Kind>
class StrongNumber {
 public:
  constexpr StrongNumber() = default;
  // A literal converts by itself, `Epoch epoch = 0;`: its value is known to the compiler. Where a
  // template passes it on, it no longer is; there the kind has to be named.
  template <LiteralNumber T>
  consteval StrongNumber(T literal)  // NOLINT(google-explicit-constructor)
      : value_(static_cast<std::uint64_t>(literal)) {}
  // Any other number becomes one by name, `Epoch(message.epoch)`.
  constexpr explicit StrongNumber(std::uint64_t value) : value_(value) {}

  constexpr std::uint64_t value() const { return value_; }

  constexpr StrongNumber& operator++() {
    ++value_;
    return *this;
  }
  constexpr StrongNumber operator++(int) { return StrongNumber(value_++); }
  friend constexpr StrongNumber operator+(StrongNumber number, std::uint64_t more) {
    return StrongNumber(number.value_ + more);
  }
  friend constexpr StrongNumber operator-(StrongNumber number, std::uint64_t less) {
    return StrongNumber(number.value_ - less);
  }
  constexpr StrongNumber& operator+=(std::uint64_t more) { return *this = *this + more; }
  constexpr StrongNumber& operator-=(std::uint64_t less) { return *this = *this - less; }
  friend constexpr bool operator==(StrongNumber, StrongNumber) = default;
  friend constexpr auto operator<=>(StrongNumber, StrongNumber) = default;  // NOLINT(*-nullptr)
  friend std::ostream& operator<<(std::ostream& out, StrongNumber number) {
    return out << number.value_;
  }

 private:
  std::uint64_t value_ = 0;
};

template <typename Kind>
std::string ToString(StrongNumber<Kind> number) {
  return std::to_string(number.value());
}

}  // namespace musher

template <typename Kind>
struct std::hash<musher::StrongNumber<Kind>> {
  std::size_t operator()(musher::StrongNumber<Kind> number) const {
    return std::hash<std::uint64_t>()(number.value());
  }
};
