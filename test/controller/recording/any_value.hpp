#pragma once
// Arbitrary values of all that a recording holds, made from the same list of fields.

#include <rapidcheck.h>

#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/step/event.hpp"

namespace musher::recording {

using fields::Base;
using fields::Field;
using fields::kFields;
using fields::kValueNames;
using fields::Part;
using fields::Struct;

// Small values that differ from defaults often; texts of any bytes.
inline void MakeAny(bool& value) {
  value = *rc::gen::arbitrary<bool>();
}
template <class T>
requires(std::is_integral_v<T>) void MakeAny(T& value) {
  value = *rc::gen::arbitrary<T>();
  if (*rc::gen::arbitrary<bool>()) value = std::numeric_limits<T>::max();
}
inline void MakeAny(std::string& text) {
  text = *rc::gen::arbitrary<std::string>();
}
template <class T>
requires(std::is_enum_v<T>) void MakeAny(T& value) {
  value = static_cast<T>(*rc::gen::inRange<std::size_t>(0, kValueNames<T>.size()));
}
inline void MakeAny(Duration& value) {
  value = Duration(*rc::gen::inRange(-kFarthestNs, kFarthestNs + 1));
}
inline void MakeAny(Time& value) {
  Duration since{};
  MakeAny(since);
  value = Time(since);
}
template <typename Kind>
void MakeAny(StrongNumber<Kind>& number) {
  number = StrongNumber<Kind>(*rc::gen::arbitrary<std::uint64_t>());
}
inline void MakeAny(State& state) {
  std::string name;
  MakeAny(name);
  state = State(std::move(name));
}
template <Struct T>
void MakeAny(T& value);
template <class Items>
void MakeItems(Items& items) {
  for (int n = *rc::gen::inRange(0, 4); n > 0; --n) {
    typename Items::value_type item{};
    MakeAny(item);
    items.push_back(std::move(item));
  }
}
template <class T>
void MakeAny(std::vector<T>& items) {
  MakeItems(items);
}
template <class T>
void MakeAny(PerActuator<T>& items) {
  MakeItems(items);
}
template <class T>
void MakeAny(std::optional<T>& value) {
  if (*rc::gen::arbitrary<bool>()) MakeAny(value.emplace());
}
template <class T, class AnyField>
void MakeAnyOf(T& value, const AnyField& field) {
  MakeAny(value.*field.member);
}
template <class T, class B>
void MakeAnyOf(T& value, const Base<B>& /*base*/) {
  MakeAny(static_cast<B&>(value));
}
template <Struct T>
void MakeAny(T& value) {
  std::apply([&](const auto&... fields) { (MakeAnyOf(value, fields), ...); }, kFields<T>);
}

// An event of any kind.
template <std::size_t I = 0>
Event AnyEvent(std::size_t kind) {
  if constexpr (I + 1 < std::variant_size_v<Event>) {
    if (kind != I) return AnyEvent<I + 1>(kind);
  }
  std::variant_alternative_t<I, Event> event;
  MakeAny(event);
  return event;
}
inline Event AnyEvent() {
  return AnyEvent(*rc::gen::inRange<std::size_t>(0, std::variant_size_v<Event>));
}
inline Machine AnyMachine() {
  Machine machine;
  MakeAny(machine);
  return machine;
}

}  // namespace musher::recording
