#pragma once
// Fills every field of a message with a value that no other field has. Truth values have only two,
// so a message is filled several times, each `round` with another bit of its number.

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <vector>

#include "musher/messages/cdr.hpp"

namespace musher::msg {

inline constexpr unsigned kFillRounds = 6;

// The bound of the sequences that have these items; specialized by what is made from the IDL.
template <class T>
inline constexpr std::size_t kMostItems = 3;

class Filler {
 public:
  explicit Filler(unsigned round) : round_(round) {}

  void Fill(bool& value) { value = ((Next() >> round_) & 1u) != 0; }
  template <class T>
  requires(std::is_arithmetic_v<T>) void Fill(T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      value = -static_cast<T>(Next()) / 3;  // a double's third is not a float's
      return;
    }
    // Large enough that a field of another width or signedness would not keep it.
    constexpr double kLarge = sizeof(T) == 1 ? 100 : sizeof(T) == 2 ? 20'000 : 2e9;
    value = static_cast<T>(kLarge) + static_cast<T>(Next());
    if constexpr (std::is_signed_v<T>) value = static_cast<T>(-value);
    if constexpr (sizeof(T) == 8 && std::is_integral_v<T>)
      value = static_cast<T>(value * 4'000'000'000);
  }
  void Fill(std::string& value) { value = "text " + std::to_string(Next()); }
  template <class T>
  void Fill(std::vector<T>& items) {
    items.resize(std::min<std::size_t>(2 + round_ % 2, kMostItems<T>));
    for (T& item : items) Fill(item);
  }
  void Fill(std::vector<bool>& items) {
    items.resize(2 + round_ % 2);
    for (auto&& item : items) {
      bool value = false;
      Fill(value);
      item = value;
    }
  }
  template <class T, std::size_t N>
  void Fill(std::array<T, N>& items) {
    for (T& item : items) Fill(item);
  }
  template <Fielded T>
  void Fill(T& message) {
    std::apply([this](auto&... field) { (Fill(field), ...); }, T::Fields(message));
  }

 private:
  unsigned Next() { return ++last_; }

  unsigned round_;
  unsigned last_ = 0;
};

template <Fielded T>
T Filled(unsigned round = 0) {
  T message{};
  Filler(round).Fill(message);
  return message;
}

}  // namespace musher::msg
