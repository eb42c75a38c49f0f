#pragma once
// Texts as values: how a port of type T reads "1.5" or "1;2;3" from XML. A type of a robot adds
//
//   template <>
//   struct musher::tree::Convert<Pose> {
//     static constexpr std::string_view kName = "Pose";  // in messages
//     static musher::Result<Pose> FromText(std::string_view text);
//   };
//
// beside the type. A type without it passes between nodes, but has no text. A type may also have
// JSON, by FromJson and ToJson, which json/json_fields.hpp makes: then "json:{...}" is a value.
//
// A pointer to a derived class is read by ports of its base class with
//
//   template <>
//   struct musher::tree::Convert<std::shared_ptr<Gripper>> : musher::tree::PointerWithBase<Tool>
//   {};

#include <charconv>
#include <concepts>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/tree/status.hpp"

namespace musher::tree {

template <class T>
struct Convert {};  // has no text

template <class T>
concept HasText = requires(std::string_view text) {
  { Convert<T>::FromText(text) } -> std::same_as<Result<T>>;
};

template <class T>
concept HasJson = requires(std::string_view json, const T& value) {
  { Convert<T>::FromJson(json) } -> std::same_as<Result<T>>;
  { Convert<T>::ToJson(value) } -> std::same_as<std::string>;
};

// Base for Convert of a pointer to a class that derives from Class.
template <class Class>
struct PointerWithBase {
  using Base = std::shared_ptr<Class>;
};

template <class T>
concept HasBase = std::convertible_to<const T&, typename Convert<T>::Base>;

// The text behind "json:"; nothing: it has no such beginning.
std::optional<std::string_view> JsonIn(std::string_view text);

template <class T>
concept Numeric = std::is_arithmetic_v<T> || std::is_enum_v<T>;

// A queue that loops share and take values from.
template <class T>
using SharedQueue = std::shared_ptr<std::deque<T>>;

// Without spaces around it.
std::string_view Trimmed(std::string_view text);
// "a;b;c" at the semicolons; nothing for an empty text.
std::vector<std::string_view> Split(std::string_view text);
Error NoValue(std::string_view text, std::string_view expected);

template <>
struct Convert<std::string> {
  static constexpr std::string_view kName = "text";
  static Result<std::string> FromText(std::string_view text) { return std::string(text); }
};

template <>
struct Convert<bool> {
  static constexpr std::string_view kName = "bool";
  static Result<bool> FromText(std::string_view text);
};

template <>
struct Convert<Status> {
  static constexpr std::string_view kName = "a node status";
  static Result<Status> FromText(std::string_view text);
};

template <class T>
requires(std::integral<T> && !std::same_as<T, bool>) struct Convert<T> {
  static constexpr std::string_view kName = std::is_signed_v<T> ? "integer" : "integer from 0";
  static Result<T> FromText(std::string_view text) {
    const std::string_view number = Trimmed(text);
    T value{};
    const auto [end, code] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (code != std::errc() || end != number.data() + number.size()) return NoValue(text, kName);
    return value;
  }
};

template <std::floating_point T>
struct Convert<T> {
  static constexpr std::string_view kName = "number";
  static Result<T> FromText(std::string_view text) {
    std::string_view number = Trimmed(text);
    if (number.starts_with('+')) number.remove_prefix(1);
    T value{};
    const auto [end, code] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (code != std::errc() || end != number.data() + number.size()) return NoValue(text, kName);
    return value;
  }
};

template <HasText T>
struct Convert<std::vector<T>> {
  static constexpr std::string_view kName = "list, with ';' between its values";
  static Result<std::vector<T>> FromText(std::string_view text) {
    std::vector<T> values;
    for (const std::string_view part : Split(text)) {
      Result<T> value = Convert<T>::FromText(part);
      if (!value) return value.error();
      values.push_back(std::move(value).value());
    }
    return values;
  }
};

template <HasText T>
struct Convert<SharedQueue<T>> {
  static constexpr std::string_view kName = "queue, with ';' between its values";
  static Result<SharedQueue<T>> FromText(std::string_view text) {
    const auto values = Convert<std::vector<T>>::FromText(text);
    if (!values) return values.error();
    return std::make_shared<std::deque<T>>(values.value().begin(), values.value().end());
  }
};

}  // namespace musher::tree
