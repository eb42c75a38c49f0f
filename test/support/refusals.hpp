#pragma once
// What a test expects of a refusal, a Refusal or an ApplicationRefusal: its id, which stands for
// its code and its sentence. A test of a house rule finds the ids that no test has.

#include <gmock/gmock.h>

#include <ostream>
#include <string_view>

#include "musher/application/refusal.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {

// For the output of a test that fails.
inline void PrintTo(Refusal why, std::ostream* out) {
  *out << FormOf(why).code << ": " << FormOf(why).sentence;
}
inline void PrintTo(ApplicationRefusal why, std::ostream* out) {
  *out << FormOf(why).code << ": " << FormOf(why).sentence;
}

namespace testing {

// Whether `text` has the sentence of `why` with any values in its places: as a whole, or with other
// text around it.
template <class Why>
bool HasSentence(std::string_view text, Why why, bool whole) {
  std::string_view form = FormOf(why).sentence;
  bool anywhere = !whole;  // the next words of the sentence
  while (true) {
    const std::size_t place = form.find('{');
    const std::string_view words = form.substr(0, place);
    const bool last = place == std::string_view::npos;
    const std::size_t at = last && whole && anywhere ? text.rfind(words) : text.find(words);
    if (at == std::string_view::npos || (at != 0 && !anywhere)) return false;
    text.remove_prefix(at + words.size());
    if (last) return !whole || text.empty();
    form.remove_prefix(form.find('}') + 1);
    anywhere = true;
  }
}

template <class Answer>
std::string_view ReasonOf(const Answer& answer) {
  if constexpr (requires { answer.message; }) {
    return answer.message;
  } else {
    return answer.reason;
  }
}

// Of an Error, a SwitchResult, the answer of an actuator or the response of a service:
//   EXPECT_THAT(result, IsRefused(Refusal::kNotSetUp));
MATCHER_P(IsRefused, why, (negation ? "is not " : "is ") + ::testing::PrintToString(why)) {
  return arg.code == FormOf(why).code && HasSentence(ReasonOf(arg), why, true);
}
// Of the output of a program, or of a log.
MATCHER_P(HasRefusal, why, (negation ? "has not " : "has ") + ::testing::PrintToString(why)) {
  return HasSentence(arg, why, false);
}

}  // namespace testing
}  // namespace musher
