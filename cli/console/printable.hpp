#pragma once
// Messages that are safe to print on a terminal: names and states, too, come from the network.

#include <ranges>
#include <string>
#include <tuple>
#include <type_traits>

#include "musher/cli/console/console.hpp"
#include "musher/messages/cdr.hpp"

namespace musher::cli {

template <class T>
void MakePrintable(T& value) {
  if constexpr (std::is_same_v<T, std::string>) {
    value = Printable(value);
  } else if constexpr (msg::Fielded<T>) {
    std::apply([](auto&... field) { (MakePrintable(field), ...); }, T::Fields(value));
  } else if constexpr (std::ranges::range<T>) {
    for (auto& item : value) MakePrintable(item);
  }
}

// A copy of the message in which every text is Printable().
template <msg::Fielded M>
M Printable(M message) {
  MakePrintable(message);
  return message;
}

}  // namespace musher::cli
