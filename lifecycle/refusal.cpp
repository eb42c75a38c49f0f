#include "musher/lifecycle/refusal.hpp"

#include <utility>

#include "musher/base/check.hpp"

namespace musher {

Error MakeRefusal(std::int32_t code, std::string_view sentence,
                  std::initializer_list<RefusalValue> values) {
  std::string message;
  message.reserve(2 * sentence.size());
  std::string_view rest = sentence;
  for (const RefusalValue& value : values) {
    const std::size_t begin = rest.find('{');
    const std::size_t end = rest.find('}');
    MUSHER_CHECK(begin < end && end != std::string_view::npos, sentence);
    message += rest.substr(0, begin);
    message += value.text;
    rest.remove_prefix(end + 1);
  }
  message += rest;
  return {code, std::move(message)};
}

}  // namespace musher
