#pragma once
// What a test expects of records and faults: an event, or a text of lifecycle/record/texts.hpp
// where the values in it matter. No test spells such a sentence: test/golden/record_texts.expected
// does.

#include <gmock/gmock.h>

#include <algorithm>
#include <optional>
#include <ostream>
#include <type_traits>
#include <vector>

#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/lifecycle/step/action.hpp"

namespace musher {

// For the output of a test that fails.
inline void PrintTo(EventName event, std::ostream* out) {
  *out << NameOf(event);
}
inline void PrintTo(const RecordText& text, std::ostream* out) {
  *out << NameOf(text.event) << " \"" << text.message << '"';
}
inline void PrintTo(const ActuatorFault& fault, std::ostream* out) {
  *out << NameOf(fault.event) << " \"" << fault.message << '"';
}
namespace action {
inline void PrintTo(const Record& record, std::ostream* out) {
  *out << NameOf(record.event) << " \"" << record.message << '"';
}
}  // namespace action

namespace testing {

// `said`: a record or a fault. `what`: an EventName or a RecordText.
template <class Said, class What>
bool Says(const Said& said, const What& what) {
  if constexpr (std::is_same_v<What, EventName>) {
    return said.event == what;
  } else if constexpr (requires { said.arguments; }) {
    return said.event == what.event && said.message == what.message &&
           said.arguments == what.arguments;
  } else {
    return said.event == what.event && said.message == what.message;
  }
}
template <class Said, class What>
bool Says(const std::optional<Said>& said, const What& what) {
  return said && Says(*said, what);
}

// EXPECT_THAT(t.RecordOf("b").fault, Is(EventName::kSetUpTimeout));
// EXPECT_THAT(t.records, Contains(Is(texts::ProcessStarted("b", 700))));
MATCHER_P(Is, what, (negation ? "is not " : "is ") + ::testing::PrintToString(what)) {
  return Says(arg, what);
}
// Of several records, one after the other.
template <class... What>
auto Are(const What&... what) {
  return ::testing::ElementsAre(Is(what)...);
}

using Records = std::vector<action::Record>;

template <class What>
bool IsRecorded(const Records& records, const What& what) {
  return std::ranges::any_of(records, [&](const auto& record) { return Says(record, what); });
}
// The first such record.
template <class What>
action::Record RecordWith(const Records& records, const What& what) {
  for (const action::Record& record : records) {
    if (Says(record, what)) return record;
  }
  ADD_FAILURE() << "no record of " << ::testing::PrintToString(what);
  return {};
}
// The last such record, its cause, and so on to the first cause. `all` of one controller.
template <class What>
Records Why(const Records& all, const What& what) {
  Records chain;
  const auto last = std::find_if(all.rbegin(), all.rend(),
                                 [&](const auto& record) { return Says(record, what); });
  if (last == all.rend()) return chain;
  chain.push_back(*last);
  for (RecordId cause = last->cause; cause != 0; cause = chain.back().cause) {
    EXPECT_LT(cause, chain.back().id) << "a cause comes first";
    chain.push_back(all.at(cause.value() - 1));
  }
  return chain;
}

}  // namespace testing
}  // namespace musher
