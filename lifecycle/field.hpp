#pragma once
// The fields of a struct and the names of an enumeration's values, listed once at the end of its
// header, for all that goes through them: messages to people, the journal, its replay, and the
// search that distinguishes states. A missing field is a compile error (MemberCount).
//
// Names of fields, of values and of events are a file format: they never change, even if the C++
// name does. Times and durations are in nanoseconds.

#include <array>
#include <cstddef>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "musher/base/result.hpp"

namespace musher::fields {

template <class T, class M>
struct Field {
  const char* name;
  M T::*member;
};
template <class T, class M>
Field(const char*, M T::*) -> Field<T, M>;

// A member whose fields are recorded as fields of the struct around it.
template <class T, class M>
struct Part {
  M T::*member;
};
template <class T, class M>
Part(M T::*) -> Part<T, M>;

// A base whose fields are recorded as fields of the struct.
template <class B>
struct Base {};

// The fields of a struct, as a tuple of Field, Part and Base.
template <class T>
inline constexpr auto kFields = nullptr;
template <class T>
concept Struct = !std::is_same_v<decltype(kFields<T>), const std::nullptr_t>;

// The names of an enumeration's values, by value. A value without a name is recorded as its number.
template <class T>
inline constexpr std::array<std::string_view, 0> kValueNames{};

// The name of an event.
template <class E>
inline constexpr std::string_view kEventName{};

// The number of members of an aggregate.
struct AnyMember {
  template <class T>
  operator T() const;  // NOLINT(google-explicit-constructor): declared only, for MemberCount
};
template <class T, class... Members>
constexpr std::size_t MemberCount() {
  if constexpr (requires { T{std::declval<Members>()..., std::declval<AnyMember&>()}; }) {
    return MemberCount<T, Members..., AnyMember&>();
  } else {
    return sizeof...(Members);
  }
}
template <Struct T>
inline constexpr bool kIsComplete = std::tuple_size_v<std::remove_const_t<decltype(kFields<T>)>> ==
                                    MemberCount<T>();

// The name of a value.
template <class T>
constexpr std::string_view NameOf(T value) {
  return kValueNames<T>[static_cast<std::size_t>(value)];
}
// Whether `last` has the last name: so no value before it is missing.
template <class T>
constexpr bool EndsWith(T last) {
  return static_cast<std::size_t>(last) + 1 == kValueNames<T>.size();
}

template <>
inline constexpr std::tuple kFields<Error> = {Field{"code", &Error::code},
                                              Field{"message", &Error::message}};

}  // namespace musher::fields
