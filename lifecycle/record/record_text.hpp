#pragma once
// What a record says: an id and arguments for programs, and the sentence that is made of them.
// texts.hpp has all of them. Values; from any thread.

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/ids.hpp"

namespace musher {

// A value in a sentence, by name. Names are read by programs: one that was released is not renamed.
struct Argument {
  std::string_view name;  // a literal; with its unit: "within_ms"
  std::variant<std::string, bool, std::int64_t, std::uint64_t> value;  // "": not known

  Argument(const char* its_name, const std::string& text) : name(its_name), value(text) {}
  Argument(const char* its_name, std::same_as<bool> auto flag) : name(its_name), value(flag) {}
  Argument(const char* its_name, std::signed_integral auto number)
      : name(its_name), value(std::int64_t{number}) {}
  Argument(const char* its_name, std::size_t number) : name(its_name), value(number) {}
  template <typename Kind>
  Argument(const char* its_name, StrongNumber<Kind> number) : Argument(its_name, number.value()) {}
  Argument(const char* its_name, std::optional<int> number) : name(its_name) {
    if (number) value = std::int64_t{*number};
  }

  friend bool operator==(const Argument&, const Argument&) = default;
};

struct RecordText {
  EventName event = EventName::kNone;
  std::string message;  // the sentence
  std::vector<Argument> arguments = {};

  friend bool operator==(const RecordText&, const RecordText&) = default;
};

// The text with the sentence `form`, in which each {name} stands for the argument of that name:
// "{actuator} is present in {state}". A name without an argument is a fault of Musher. Arguments
// that are not known are left out.
RecordText MakeText(EventName event, std::string_view form, std::vector<Argument> arguments);

// The argument of that name; null: there is none.
const Argument* FindArgument(const std::vector<Argument>& arguments, std::string_view name);
// The same as a text, empty for none.
std::string ArgumentOf(const std::vector<Argument>& arguments, std::string_view name);

}  // namespace musher
