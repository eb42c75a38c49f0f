#include "musher/test/house/field_rules.hpp"

#include <algorithm>
#include <cctype>
#include <regex>
#include <set>

namespace musher::house {
namespace {

using Words = std::set<std::string>;

// Fields that ROS 2 adds to structs whose names end so; "" is every struct.
struct AddedFields {
  const char* end_of_struct;
  std::vector<const char*> fields;
};
const std::vector<AddedFields>& Added() {
  static const std::vector<AddedFields> added = {
      {"", {"client_id", "sequence_number", "structure_needs_at_least_one_member"}},
      {"_SendGoal_Request", {"goal_id", "goal"}},
      {"_SendGoal_Response", {"accepted", "stamp"}},
      {"_GetResult_Request", {"goal_id"}},
      {"_GetResult_Response", {"result"}},
      {"_FeedbackMessage", {"goal_id", "feedback"}},
  };
  return added;
}

bool IsAdded(const std::string& of_struct, const std::string& field) {
  return std::any_of(Added().begin(), Added().end(), [&](const AddedFields& added) {
    return of_struct.ends_with(added.end_of_struct) &&
           std::find(added.fields.begin(), added.fields.end(), field) != added.fields.end();
  });
}

// In lower case; anything but letters, digits and bytes of other characters separates them.
Words WordsOf(const std::string& text) {
  constexpr unsigned char kAscii = 0x80;
  Words words;
  std::string word;
  for (const char c : text + ' ') {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || byte >= kAscii) {
      word += static_cast<char>(std::tolower(byte));
    } else if (!word.empty()) {
      words.insert(std::move(word));
      word.clear();
    }
  }
  return words;
}

bool IsEmpty(const std::string& comment) {
  return comment.find_first_not_of(' ') == std::string::npos;
}

bool Repeats(const std::string& comment, const std::string& field) {
  Words words = WordsOf(comment);
  if (words.empty()) return false;  // "%"
  for (const char* article : {"a", "an", "the"}) words.erase(article);
  const Words name = WordsOf(field);
  return std::includes(name.begin(), name.end(), words.begin(), words.end());
}

}  // namespace

std::vector<std::string> UncommentedFields(const SourceFile& idl) {
  static const std::regex structure(R"(\bstruct (\w+)_ \{)");
  static const std::regex field(R"(^.*?(\w+)(?:\[\d+\])?;\s*(?://(.*))?$)");
  static const std::regex end_of_struct(R"(^\s*\})");
  static const std::regex comment_line(R"(^\s*//(.*)$)");
  std::vector<std::string> violations;
  std::string of_struct;  // empty: outside of one
  std::string comment;    // above the next field
  for (const Line& line : Lines(idl.text)) {
    std::smatch match;
    if (std::regex_match(line.text, match, comment_line)) {
      comment += match[1].str() + ' ';
      continue;
    }
    if (std::regex_search(line.text, match, structure)) {
      of_struct = match[1];
    } else if (std::regex_search(line.text, end_of_struct)) {
      of_struct.clear();
    } else if (!of_struct.empty() && std::regex_match(line.text, match, field)) {
      const std::string name = match[1];
      comment += match[2];
      const std::string which = of_struct + "." + name;
      const bool needs_one = !IsAdded(of_struct, name);
      if (needs_one && IsEmpty(comment)) {
        violations.push_back(At(idl, line.number, which + " has no comment behind or above it"));
      } else if (needs_one && Repeats(comment, name)) {
        violations.push_back(
            At(idl, line.number, which + " has a comment that only repeats its name"));
      }
    }
    comment.clear();
  }
  return violations;
}

}  // namespace musher::house
