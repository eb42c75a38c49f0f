#pragma once
// "Did you mean ...?": the known word that is nearest to a mistyped one.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace musher {

// The candidate nearest to `word` by edit distance, where swapped neighbours count as one edit and
// upper and lower case are the same. Empty when none is near: a third of the word's length is
// allowed to differ, at least one character and at most three. Of equally near ones the first wins;
// a candidate equal to `word` is never given, nor its opposite. Words over 64 bytes have none.
std::string Nearest(std::string_view word, const std::vector<std::string_view>& candidates);
template <typename Name>  // which converts to std::string_view
std::string Nearest(std::string_view word, const std::vector<Name>& candidates) {
  return Nearest(word, std::vector<std::string_view>(candidates.begin(), candidates.end()));
}

// "; did you mean 'legs'?": the end of a message that refuses `word`. Empty where no name is near.
// `quotes`: the opening and the closing one, as the message has them.
std::string DidYouMean(std::string_view word, const std::vector<std::string_view>& names,
                       std::string_view quotes = "''");
template <typename Names>  // a container of what converts to std::string_view
std::string DidYouMean(std::string_view word, const Names& names, std::string_view quotes = "''") {
  return DidYouMean(word, std::vector<std::string_view>(names.begin(), names.end()), quotes);
}
// The same for a name that the caller has found and quoted.
std::string DidYouMean(const std::string& quoted_name);

// What NoSuch() shows of a name at most.
inline constexpr std::size_t kLongestWord = 64;  // bytes

// "; did you mean 'legs'? There are arm, head and legs": how NoSuch() goes on after the name.
std::string KnownNames(std::string_view name, const std::vector<std::string>& names);

// "there is no actuator 'lags'; did you mean 'legs'? There are arm, head and legs": `what` is its
// kind, `names` the known names, of which the first are listed. Safe with any `name`: it is
// shortened.
std::string NoSuch(std::string_view what, std::string_view name,
                   const std::vector<std::string>& names);

}  // namespace musher
