#include "musher/modules/race/command_words.hpp"

#include <algorithm>
#include <optional>

namespace musher::race {
namespace {

// The rest of `typed` behind `prefix`.
std::optional<std::string> Behind(std::string_view typed, std::string_view prefix) {
  if (!SameWord(typed.substr(0, prefix.size()), prefix)) return std::nullopt;
  return std::string(typed.substr(prefix.size()));
}

std::string Of(const std::vector<std::string>& names, std::string typed) {
  const auto name = std::ranges::find_if(names, [&](const auto& n) { return SameWord(n, typed); });
  return name == names.end() ? typed : *name;
}

std::vector<std::string> StateNames(const Course& course) {
  std::vector<std::string> names;
  names.reserve(course.states.size());
  for (const StateRule& state : course.states) names.push_back(state.name);
  return names;
}

// SET_QR_A:<value> and SET_QR_A_DEFAULT.
std::optional<std::string> OfResult(const ResultRule& result, std::string_view typed) {
  if (result.command.empty()) return std::nullopt;
  const auto rest = Behind(typed, result.command);
  if (!rest) return std::nullopt;
  if (SameWord(*rest, "_DEFAULT")) return result.command + "_DEFAULT";
  if (!rest->starts_with(":")) return std::nullopt;
  const std::size_t begin = rest->find_first_not_of(" \t", 1);
  if (begin == std::string::npos) return std::nullopt;
  return result.command + ":" + Of(result.values, rest->substr(begin));
}

Result<std::string> OfValue(const Course& course, std::string_view typed) {
  std::optional<std::string> found;
  for (const ResultRule& result : course.results) {
    if (result.command.empty()) continue;
    const auto value =
        std::ranges::find_if(result.values, [&](const auto& v) { return SameWord(v, typed); });
    if (value == result.values.end()) continue;
    std::string command = result.command + ":" + *value;
    if (found) {
      return Error{kCodeFailed, "'" + std::string(typed) + "' is a value of two results: send " +
                                    *found + " or " + command};
    }
    found = std::move(command);
  }
  return found.value_or(std::string(typed));
}

}  // namespace

Result<std::string> CommandOf(const Course& course, std::string_view typed) {
  for (const std::string_view command : {"START", "STOP", "RESET"}) {
    if (SameWord(command, typed)) return std::string(command);
  }
  for (const CourseCommand& own : course.commands) {
    if (SameWord(own.name, typed)) return own.name;
  }
  const std::vector<std::string> states = StateNames(course);
  if (const auto target = Behind(typed, "START:")) {
    const std::size_t begin = std::min(target->find_first_not_of(" \t"), target->size());
    return "START:" + Of(states, target->substr(begin));
  }
  for (const ResultRule& result : course.results) {
    if (auto command = OfResult(result, typed)) return *command;
  }
  const std::string state = Of(states, std::string(typed));
  if (std::ranges::find(states, state) != states.end()) return "START:" + state;
  return OfValue(course, typed);
}

}  // namespace musher::race
