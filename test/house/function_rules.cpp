#include "musher/test/house/function_rules.hpp"

#include <map>
#include <regex>

namespace musher::house {
namespace {

constexpr int kMostLines = 69;

// What ends the raw string that begins in `text` and goes on behind it; empty: there is none.
std::string EndOfRawString(const std::string& text) {
  const std::size_t begin = text.find("R\"");
  if (begin == std::string::npos) return "";
  const std::size_t delimiter = begin + 2;
  const std::size_t open =
      text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_", delimiter);
  if (open == std::string::npos || text[open] != '(') return "";
  const std::string end = ")" + text.substr(delimiter, open - delimiter) + "\"";
  return text.find(end, open) == std::string::npos ? end : "";
}

// The lines whose indentation is that of code: without empty ones, comments, directives of the
// preprocessor and the text of raw strings.
std::vector<Line> IndentedLines(const SourceFile& file) {
  std::vector<Line> code;
  std::string end_of_raw_string;
  for (const Line& line : Lines(file.text)) {
    if (!end_of_raw_string.empty()) {
      if (line.text.find(end_of_raw_string) != std::string::npos) end_of_raw_string.clear();
      continue;
    }
    end_of_raw_string = EndOfRawString(line.text);
    const std::size_t indent = line.text.find_first_not_of(' ');
    if (indent == std::string::npos || line.text[indent] == '#') continue;
    if (line.text.compare(indent, 2, "//") != 0) code.push_back(line);
  }
  return code;
}

bool BeginsFunction(const std::string& head) {
  static const std::regex block(
      R"(^([{}]|(if|for|while|switch|do|else|try|namespace|class|struct|enum|union)\b))");
  return head.find('(') != std::string::npos && !std::regex_search(head, block);
}

// Whether the code of a line is a closing brace, that of a namespace excepted.
bool IsClosingBrace(const std::string& code) {
  static const std::regex brace(R"(^\}\s*(//(?! namespace\b).*)?$)");
  return code.starts_with('}') && std::regex_search(code, brace);
}

}  // namespace

std::vector<std::string> LongFunctions(const SourceFile& file) {
  std::vector<std::string> violations;
  std::map<std::size_t, Line> last;  // the last line of each indentation
  for (const Line& line : IndentedLines(file)) {
    const std::size_t indent = line.text.find_first_not_of(' ');
    const auto opened = last.find(indent);
    if (opened != last.end() && IsClosingBrace(line.text.substr(indent))) {
      const int lines = line.number - opened->second.number + 1;
      const std::string head = opened->second.text.substr(indent);
      if (lines > kMostLines && BeginsFunction(head)) {
        violations.push_back(At(file, opened->second.number,
                                "has " + std::to_string(lines) + " lines, of at most " +
                                    std::to_string(kMostLines) + ": " + head));
      }
    }
    last.erase(last.upper_bound(indent), last.end());
    last.insert_or_assign(indent, line);
  }
  return violations;
}

}  // namespace musher::house
