#include "musher/cli/nav2/params_file.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "musher/base/code.hpp"

namespace musher::cli {
namespace {

constexpr std::size_t kDeepest = 64;

struct Line {
  std::size_t number = 0;
  std::size_t indent = 0;
  std::string text;  // without indentation and comment
};

std::string Trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return "";
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
}

// Without a comment, which begins at a '#' after a space and outside of quotes.
std::string_view WithoutComment(std::string_view line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '#' && (i == 0 || line[i - 1] == ' ')) {
      return line.substr(0, i);
    }
  }
  return line;
}

std::string Unquoted(const std::string& word) {
  const bool quoted = word.size() >= 2 && (word.front() == '"' || word.front() == '\'') &&
                      word.back() == word.front();
  return quoted ? word.substr(1, word.size() - 2) : word;
}

std::vector<std::string> WordsIn(std::string_view list) {
  std::vector<std::string> words;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const std::string word = Unquoted(Trimmed(list.substr(0, comma)));
    if (!word.empty()) words.push_back(word);
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return words;
}

std::vector<Line> LinesOf(std::string_view text) {
  std::vector<Line> lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = WithoutComment(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    std::string words = Trimmed(line);
    if (words.empty() || words == "---" || words == "...") continue;
    lines.push_back({number, line.find_first_not_of(' '), std::move(words)});
  }
  return lines;
}

// The key of "key: value"; the value may be empty.
std::optional<std::pair<std::string, std::string>> KeyAndValue(const std::string& text) {
  std::size_t colon = text.find(": ");
  if (colon == std::string::npos && text.ends_with(':')) colon = text.size() - 1;
  if (colon == std::string::npos) return std::nullopt;
  return std::pair(Unquoted(Trimmed(text.substr(0, colon))), Trimmed(text.substr(colon + 1)));
}

class Parser {
 public:
  Parser(std::vector<Line> lines, const std::string& path)
      : lines_(std::move(lines)), path_(path) {}

  Result<ParamsNode> Read() {
    ParamsNode root;
    ReadMembers(root, 0, 0);
    if (!error_.empty()) return Error{kCodeParametersInvalid, error_};
    return root;
  }

 private:
  const Line* Next() const { return at_ < lines_.size() ? &lines_[at_] : nullptr; }
  void Fault(const Line& line, const std::string& what) {
    if (error_.empty()) error_ = path_ + ":" + std::to_string(line.number) + ": " + what;
    at_ = lines_.size();
  }

  void ReadMembers(ParamsNode& node, std::size_t indent, std::size_t depth) {
    while (const Line* line = Next()) {
      if (line->indent < indent) return;
      if (line->text.find('\t') == 0 || depth > kDeepest) {
        return Fault(*line, "expected a key, not deeper than " + std::to_string(kDeepest));
      }
      const auto member = KeyAndValue(line->text);
      if (!member) return Fault(*line, "expected 'key: value', found '" + line->text + "'");
      const std::size_t own = line->indent;
      ++at_;
      ParamsNode value;
      ReadValue(value, member->second, own, depth);
      node.members.push_back({member->first, std::move(value)});
      if (Next() != nullptr && Next()->indent > own) {
        return Fault(*Next(), "is indented, and the line above it has a value");
      }
    }
  }

  void ReadValue(ParamsNode& node, std::string value, std::size_t indent, std::size_t depth) {
    if (value.starts_with('[')) return ReadFlowList(node, std::move(value));
    if (value.starts_with('|') || value.starts_with('>')) {  // a text of several lines
      while (Next() != nullptr && Next()->indent > indent) ++at_;
      return;
    }
    if (!value.empty()) {
      node.text = Unquoted(value);
      return;
    }
    const Line* next = Next();
    if (next == nullptr || next->indent < indent) return;
    if (next->text.starts_with("- ") || next->text == "-") return ReadItems(node, next->indent);
    if (next->indent > indent) ReadMembers(node, next->indent, depth + 1);
  }

  // It may continue on the next lines.
  void ReadFlowList(ParamsNode& node, std::string value) {
    while (value.find(']') == std::string::npos && Next() != nullptr) {
      value += " " + Next()->text;
      ++at_;
    }
    const std::size_t end = std::min(value.find(']'), value.size());
    node.list = WordsIn(std::string_view(value).substr(1, end - 1));
  }

  // Items that are more than a scalar are skipped.
  void ReadItems(ParamsNode& node, std::size_t indent) {
    while (const Line* line = Next()) {
      const bool item = line->text.starts_with("- ") || line->text == "-";
      if (line->indent < indent || (line->indent == indent && !item)) return;
      if (line->indent == indent) node.list.push_back(Unquoted(Trimmed(line->text.substr(1))));
      ++at_;
    }
  }

  const std::vector<Line> lines_;
  const std::string& path_;
  std::size_t at_ = 0;
  std::string error_;
};

}  // namespace

const ParamsNode* ParamsNode::Find(std::string_view key) const {
  const auto found = std::ranges::find_if(members, [&](const auto& one) { return one.key == key; });
  return found == members.end() ? nullptr : &found->value;
}

Result<ParamsNode> ReadParams(std::string_view text, const std::string& path) {
  return Parser(LinesOf(text), path).Read();
}

}  // namespace musher::cli
