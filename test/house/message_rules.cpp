#include "musher/test/house/message_rules.hpp"

#include <algorithm>
#include <cctype>
#include <regex>
#include <set>
#include <utility>

#include "musher/test/house/reference_rules.hpp"

namespace musher::house {
namespace {

constexpr std::string_view kAnything = "…";
constexpr std::size_t kShortestFragment = 8;  // of a sentence, to be looked up in the code

constexpr const char* kSectionsOfSentences[] = {
    "The command line and the start",
    "Logs, drawings and new projects",
    "Credentials",
    "Upgrades",
    "A module",
    "Skills, state machines and trees",
    "The page and recordings",
};

// Enums of codes that belong to a module, with the module's number; 0: they include it.
struct ModuleCodes {
  const char* path;
  const char* name;
  int number;
};
constexpr ModuleCodes kModuleCodes[] = {
    {"base/code.hpp", "KeyCode", 100},
    {"ota/fault.hpp", "Fault", 5700},
    {"modules/audio/audio_code.hpp", "AudioKey", 5000},
    {"modules/device/led.hpp", "LedKey", 1100},
    {"modules/motion/motion_code.hpp", "MotionKey", 3000},
    {"navigation/navigation_fault.hpp", "Fault", 0},
};

std::string TextOf(const std::vector<SourceFile>& tree, const std::string& path) {
  const auto found = std::find_if(tree.begin(), tree.end(),
                                  [&](const SourceFile& file) { return file.path == path; });
  return found == tree.end() ? std::string() : found->text;
}

std::vector<std::string_view> SplitAt(std::string_view text, std::string_view separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + separator.size());
  }
}

using Row = std::vector<std::string>;  // its cells

// The rows of the tables of a section, without heads; cells without spaces and backquotes around.
std::vector<Row> RowsOf(const SourceFile& page, const std::string& section) {
  std::vector<Row> rows;
  bool head = true;
  for (const Line& line : Lines(SectionOf(page, section))) {
    if (!line.text.starts_with("| ")) {
      if (!line.text.starts_with("|-")) head = true;
      continue;
    }
    if (std::exchange(head, false)) continue;
    Row row;
    const std::string text = line.text.substr(2);
    for (std::string_view cell : SplitAt(text, " |")) {
      while (cell.starts_with(' ')) cell.remove_prefix(1);
      if (cell.starts_with('`') && cell.ends_with('`') && cell.size() > 1) {
        cell = cell.substr(1, cell.size() - 2);
      }
      row.emplace_back(cell);
    }
    row.pop_back();  // behind the last '|'
    rows.push_back(std::move(row));
  }
  return rows;
}

bool IsComplete(const Row& row, std::size_t cells) {
  return row.size() == cells &&
         std::none_of(row.begin(), row.end(), [](const std::string& cell) { return cell.empty(); });
}

// C++ whose string literals that stand beside each other are one.
std::string WithJoinedLiterals(const std::string& code) {
  std::string joined;
  joined.reserve(code.size());
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] == '"' && (i == 0 || code[i - 1] != '\\')) {
      std::size_t next = i + 1;
      while (next < code.size() && std::isspace(static_cast<unsigned char>(code[next])) != 0)
        ++next;
      if (next > i + 1 && next < code.size() && code[next] == '"') {
        i = next;
        continue;
      }
    }
    joined += code[i];
  }
  return joined;
}

}  // namespace

bool FitsPattern(std::string_view text, std::string_view pattern) {
  const auto parts = SplitAt(pattern, kAnything);
  if (!text.starts_with(parts.front())) return false;
  if (parts.size() == 1) return text == pattern;
  text.remove_prefix(parts.front().size());
  for (std::size_t i = 1; i + 1 < parts.size(); ++i) {
    const std::size_t at = text.find(parts[i]);
    if (at == std::string_view::npos) return false;
    text.remove_prefix(at + parts[i].size());
  }
  return text.ends_with(parts.back());
}

std::vector<std::string> UnexplainedRecords(const SourceFile& page,
                                            const std::vector<SourceFile>& tree) {
  static const std::regex quoted(R"re(\n    "(\w+)",)re");
  std::set<std::string> events;
  const std::string names = TextOf(tree, "lifecycle/event_name.hpp");
  for (std::sregex_iterator i(names.begin(), names.end(), quoted), end; i != end; ++i) {
    events.insert((*i)[1]);
  }
  std::vector<std::string> wrong;
  const std::vector<Row> rows = RowsOf(page, "Records and faults");
  std::set<std::string> explained;
  for (const Row& row : rows) {
    if (!IsComplete(row, 4)) {
      wrong.push_back("not a sentence, an event, a cause and a cure: " + row.front());
    } else if (!events.contains(row[1])) {
      wrong.push_back("there is no event " + row[1]);
    } else {
      explained.insert(row[1]);
    }
  }
  for (const std::string& event : events) {
    if (!explained.contains(event)) wrong.push_back("no row explains the event " + event);
  }
  std::string event;
  for (const Line& line : Lines(TextOf(tree, "test/golden/record_texts.expected"))) {
    if (line.text.starts_with("    ")) continue;  // the arguments
    if (!line.text.starts_with("  ")) {
      event.clear();
    } else if (event.empty()) {
      event = line.text.substr(2);
    } else if (const std::string sentence = line.text.substr(2);
               std::none_of(rows.begin(), rows.end(), [&](const Row& row) {
                 return row.size() == 4 && row[1] == event && FitsPattern(sentence, row[0]);
               })) {
      wrong.push_back("no row of " + event + " explains: " + sentence);
    }
  }
  return wrong;
}

namespace {

// Those of the controller and of an actuator, and those of applications.
std::string RefusalForms(const std::vector<SourceFile>& tree) {
  return TextOf(tree, "lifecycle/refusal.hpp") + TextOf(tree, "application/refusal.hpp");
}

}  // namespace

std::vector<std::string> UnexplainedRefusals(const SourceFile& page,
                                             const std::vector<SourceFile>& tree) {
  static const std::regex form(
      R"re(\{(?:Application)?Refusal::(k\w+), \w+,\s*"((?:[^"\\]|\\.)*)"\})re");
  static const std::regex optional_place(R"(\{[^{}]*\?\})");
  static const std::regex place(R"(\{[^{}]*\})");
  static const std::regex quote(R"(\\")");
  const std::string forms = WithJoinedLiterals(RefusalForms(tree));
  const std::vector<Row> rows = RowsOf(page, "Refusals");
  std::vector<std::string> wrong;
  std::set<std::string> used;
  for (std::sregex_iterator i(forms.begin(), forms.end(), form), end; i != end; ++i) {
    std::string sentence = std::regex_replace((*i)[2].str(), optional_place, "");
    sentence = std::regex_replace(sentence, place, std::string(kAnything));
    sentence = std::regex_replace(sentence, quote, "\"");
    bool found = false;
    for (const Row& row : rows) {
      if (!FitsPattern(sentence, row[0])) continue;
      found = true;
      used.insert(row[0]);
    }
    if (!found) wrong.push_back("no row explains " + (*i)[1].str() + ": " + sentence);
  }
  for (const Row& row : rows) {
    if (!IsComplete(row, 3)) wrong.push_back("not a sentence, a cause and a cure: " + row.front());
    if (!used.contains(row[0])) wrong.push_back("nothing is refused with: " + row[0]);
  }
  return wrong;
}

std::vector<std::string> UntestedRefusals(const std::vector<SourceFile>& tree) {
  static const std::regex form(R"(\{(?:Application)?Refusal::(k\w+),)");
  static const std::string kept = "Refusal::";
  std::set<std::string> tested;
  for (const SourceFile& file : tree) {
    if (!file.In("test/") || file.In("test/house/") || !file.IsCpp()) continue;
    for (const std::string_view part : SplitAt(file.text, kept)) {
      const auto end = std::find_if(part.begin(), part.end(),
                                    [](unsigned char c) { return std::isalnum(c) == 0; });
      tested.emplace(part.begin(), end);
    }
  }
  const std::string forms = RefusalForms(tree);
  std::vector<std::string> untested;
  for (std::sregex_iterator i(forms.begin(), forms.end(), form), end; i != end; ++i) {
    if (!tested.contains((*i)[1])) untested.push_back("no test provokes Refusal::" + (*i)[1].str());
  }
  return untested;
}

std::vector<std::string> RefusalsElsewhere(const std::vector<SourceFile>& tree) {
  // Codes that only a refusal has: nothing else is forbidden, busy or unsupported.
  static const std::regex made(
      R"(Error\{\s*kCode(?:StateInvalid|PermissionDenied|TargetBusy|UnSupport|ProtectedError),)"
      R"([^}]*")");
  std::vector<std::string> wrong;
  for (const SourceFile& file : tree) {
    if (!file.In("lifecycle/") && !file.In("application/")) continue;
    if (std::regex_search(file.text, made)) wrong.push_back(file.path);
  }
  return wrong;
}

std::vector<std::string> UnexplainedFindings(const SourceFile& page,
                                             const std::vector<SourceFile>& tree) {
  static const std::regex finding(R"(^[^ ]+ (?:error|warning): (.*)$)");
  const std::vector<Row> rows = RowsOf(page, "Errors of a config");
  std::vector<std::string> wrong;
  std::set<std::string> used;
  for (const SourceFile& file : tree) {
    if (!file.In("test/golden/configs/") || !file.Is(".expected")) continue;
    for (const Line& line : Lines(file.text)) {
      std::smatch match;
      if (!std::regex_match(line.text, match, finding)) continue;
      const std::string whole = match[1];  // perhaps with the key in front
      const std::size_t key = whole.find(": ");
      const std::string sentence = key == std::string::npos ? whole : whole.substr(key + 2);
      bool found = false;
      for (const Row& row : rows) {
        if (!FitsPattern(whole, row[0]) && !FitsPattern(sentence, row[0])) continue;
        found = true;
        used.insert(row[0]);
      }
      if (!found) wrong.push_back("no row explains: " + whole);
    }
  }
  for (const Row& row : rows) {
    if (!IsComplete(row, 3)) wrong.push_back("not a sentence, a cause and a cure: " + row.front());
    if (!used.contains(row[0])) wrong.push_back("no example of a config has: " + row[0]);
  }
  return wrong;
}

std::vector<std::string> UnexplainedCodes(const SourceFile& page,
                                          const std::vector<SourceFile>& tree) {
  static const std::regex number(R"(\d{3,4})");
  static const std::regex enumerator(R"(\bk\w+ = (\d+),)");
  std::set<std::string> explained;
  for (const Row& row : RowsOf(page, "Codes")) {
    const std::string& cell = row.front();
    for (std::sregex_iterator i(cell.begin(), cell.end(), number), end; i != end; ++i) {
      explained.insert(i->str());
    }
  }
  std::vector<std::string> wrong;
  for (const ModuleCodes& codes : kModuleCodes) {
    const std::string text = TextOf(tree, codes.path);
    const std::size_t begin = text.find(std::string("enum class ") + codes.name);
    if (begin == std::string::npos) {
      wrong.push_back(std::string("there is no ") + codes.name + " in " + codes.path);
      continue;
    }
    const std::string body = text.substr(begin, text.find("};", begin) - begin);
    for (std::sregex_iterator i(body.begin(), body.end(), enumerator), end; i != end; ++i) {
      const int key = std::stoi((*i)[1]);
      const std::string code = std::to_string(codes.number + key);
      if (key != 0 && !explained.contains(code)) wrong.push_back("no row explains code " + code);
    }
  }
  // Codes that a module's page lists.
  for (const SourceFile& file : tree) {
    if (!file.In("modules/") || !file.Is("README.md")) continue;
    static const std::regex listed(R"(\n\| (\d{4}(?:, \d{4})*) \|)");
    for (std::sregex_iterator i(file.text.begin(), file.text.end(), listed), end; i != end; ++i) {
      const std::string codes = (*i)[1];
      for (const std::string_view code : SplitAt(codes, ", ")) {
        if (!explained.contains(std::string(code))) {
          wrong.push_back("no row explains code " + std::string(code) + " of " + file.path);
        }
      }
    }
  }
  return wrong;
}

std::vector<std::string> SentencesOfNoProgram(const SourceFile& page,
                                              const std::vector<SourceFile>& tree) {
  std::string code;
  for (const SourceFile& file : tree) {
    const bool product = !file.In("test/") && !file.In("examples/");
    if (product && (file.IsCpp() || file.In("python/"))) code += WithJoinedLiterals(file.text);
  }
  std::vector<std::string> wrong;
  for (const char* section : kSectionsOfSentences) {
    for (const Row& row : RowsOf(page, section)) {
      if (!IsComplete(row, 3))
        wrong.push_back("not a sentence, a cause and a cure: " + row.front());
      for (const std::string_view fragment : SplitAt(row.front(), kAnything)) {
        if (fragment.size() >= kShortestFragment && code.find(fragment) == std::string::npos) {
          wrong.push_back("no program prints '" + std::string(fragment) + "'");
        }
      }
    }
  }
  return wrong;
}

}  // namespace musher::house
