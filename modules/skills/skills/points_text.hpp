#pragma once
// Lists of places as a parameter of a skill, which is a text: "[[0, 0], [20, 0, 1.5]]", metres in
// the map. The height may be left out, then it is 0. Pure; any thread.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::skills {

using Points = std::vector<navigation::Point>;

// At most 10,000 places in all. The error has the parameter's name, the character at which the
// text is not as expected, and what was expected there. An empty text has none.
Result<Points> ParsePoints(const std::string& name, std::string_view text);
// Several lists: "[[[0, 0], [1, 0], [1, 1]], [[5, 5], [6, 5], [6, 6]]]".
Result<std::vector<Points>> ParseLists(const std::string& name, std::string_view text);
// Whether the text begins as several lists do.
bool HasLists(std::string_view text);
// Several lists, to a centimetre and without heights, as ParseLists() reads them.
std::string ListsText(const std::vector<Points>& lists);

}  // namespace musher::skills
