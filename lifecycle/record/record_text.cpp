#include "musher/lifecycle/record/record_text.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/check.hpp"

namespace musher {
namespace {

std::string TextOf(const Argument& argument) {
  if (const auto* text = std::get_if<std::string>(&argument.value)) return *text;
  if (const auto* flag = std::get_if<bool>(&argument.value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<std::int64_t>(&argument.value)) {
    return std::to_string(*number);
  }
  return std::to_string(std::get<std::uint64_t>(argument.value));
}

}  // namespace

const Argument* FindArgument(const std::vector<Argument>& arguments, std::string_view name) {
  const auto found = std::ranges::find(arguments, name, &Argument::name);
  return found == arguments.end() ? nullptr : &*found;
}

std::string ArgumentOf(const std::vector<Argument>& arguments, std::string_view name) {
  const Argument* argument = FindArgument(arguments, name);
  return argument == nullptr ? "" : TextOf(*argument);
}

RecordText MakeText(EventName event, std::string_view form, std::vector<Argument> arguments) {
  std::string message;
  message.reserve(2 * form.size());
  while (true) {
    const std::size_t begin = form.find('{');
    message += form.substr(0, begin);
    if (begin == std::string_view::npos) break;
    const std::size_t end = form.find('}', begin);
    MUSHER_CHECK(end != std::string_view::npos, form);
    const std::string_view name = form.substr(begin + 1, end - begin - 1);
    const Argument* argument = FindArgument(arguments, name);
    MUSHER_CHECK(argument != nullptr, name);
    message += TextOf(*argument);
    form.remove_prefix(end + 1);
  }
  std::erase_if(arguments, [](const Argument& argument) {
    const auto* text = std::get_if<std::string>(&argument.value);
    return text != nullptr && text->empty();
  });
  return {event, std::move(message), std::move(arguments)};
}

}  // namespace musher
