#include "musher/test/house/doc_rules.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <regex>
#include <set>

namespace musher::house {
namespace {

bool IsMarker(const std::string& line) {
  static const std::regex marker(R"(^\s*(//|#) \[\w+( end)?\]$)");
  return std::regex_match(line, marker);
}

std::size_t Indent(const std::vector<std::string>& lines) {
  std::size_t indent = std::string::npos;
  for (const std::string& line : lines) {
    if (!line.empty()) indent = std::min(indent, line.find_first_not_of(' '));
  }
  return indent;
}

// Without the first `indent` columns.
std::string Text(const std::vector<std::string>& lines, std::size_t indent) {
  std::string text;
  for (const std::string& line : lines) text += (line.empty() ? "" : line.substr(indent)) + "\n";
  return text;
}

// The lines of a region ("" for all), without markers; nothing where there is no such region.
// "Switches::Begin()": the function of C++ that is defined at the top of the file, with the comment
// above.
std::optional<std::string> Function(const SourceFile& file, const std::string& name) {
  const std::string call = " " + name.substr(0, name.size() - 1);
  std::vector<std::string> lines;
  bool inside = false;
  for (const Line& line : Lines(file.text)) {
    const bool comment = line.text.starts_with("// ") && !line.text.starts_with("// ---");
    const bool top = !line.text.empty() && line.text[0] != ' ';
    if (!inside && !comment) inside = top && line.text.find(call) != std::string::npos;
    if (!inside && !comment) lines.clear();
    if (inside || comment) lines.push_back(line.text);
    if (inside && line.text == "}") return Text(lines, 0);
  }
  return std::nullopt;
}

std::optional<std::string> Region(const SourceFile& file, const std::string& name, bool indented) {
  if (name.ends_with("()")) return Function(file, name);
  std::vector<std::string> lines;
  bool inside = name.empty();
  bool found = inside;
  for (const Line& line : Lines(file.text)) {
    if (IsMarker(line.text)) {
      if (line.text.ends_with(" [" + name + "]")) found = inside = true;
      if (line.text.ends_with(" [" + name + " end]")) inside = false;
    } else if (inside) {
      lines.push_back(line.text);
    }
  }
  if (!found) return std::nullopt;
  return Text(lines, indented ? 0 : Indent(lines));
}

const SourceFile* Find(const std::vector<SourceFile>& tree, const std::string& path) {
  const auto found = std::find_if(tree.begin(), tree.end(),
                                  [&](const SourceFile& file) { return file.path == path; });
  return found == tree.end() ? nullptr : &*found;
}

struct Snippet {
  int line = 0;
  std::string source;  // empty: none was named
  std::string region;
  bool typed = false;  // "+[region]"
  std::string text;

  std::string Name() const {
    return source + (region.empty() ? "" : (typed ? " +[" : " [") + region + "]");
  }
};

std::vector<Snippet> Snippets(const SourceFile& document) {
  static const std::regex origin(R"(^<!-- (\S+?)(?: (\+?)\[([\w:]+(?:\(\))?)\])? -->$)");
  static const std::regex code("^```(cpp|python|cmake|toml|xml)$");
  std::vector<Snippet> snippets;
  std::smatch from;
  std::string last;
  bool inside = false;
  for (const Line& line : Lines(document.text)) {
    if (inside && line.text == "```") {
      inside = false;
    } else if (inside) {
      snippets.back().text += line.text + "\n";
    } else if (std::regex_match(line.text, code)) {
      inside = true;
      snippets.emplace_back().line = line.number;
      if (std::regex_match(last, from, origin)) {
        snippets.back().source = from[1];
        snippets.back().typed = from[2] == "+";
        snippets.back().region = from[3];
      }
    }
    last = line.text;
  }
  return snippets;
}

}  // namespace

std::vector<std::string> StaleSnippets(const SourceFile& document,
                                       const std::vector<SourceFile>& tree) {
  std::vector<std::string> violations;
  for (const Snippet& snippet : Snippets(document)) {
    const auto report = [&](const std::string& violation) {
      violations.push_back(At(document, snippet.line, violation));
    };
    const SourceFile* source = Find(tree, snippet.source);
    if (snippet.source.empty()) {
      report("code without a source in a comment above");
    } else if (source == nullptr) {
      report("there is no " + snippet.source);
    } else if (const auto region = Region(*source, snippet.region, snippet.typed); !region) {
      report("there is no " + snippet.Name());
    } else if (*region != snippet.text) {
      report("differs from " + snippet.Name() + ", which is now:\n" + *region);
    }
  }
  return violations;
}

std::vector<std::string> Unexplained(const SourceFile& document, const SourceFile& source) {
  static const std::regex toml_key(R"(^([a-z]\w*) = )");
  static const std::regex idl_field(R"(^    (?:@\S+ )*(?:[\w:]+)(?:<.*>)? (\w+);)");
  const std::regex& pattern = source.Is(".toml") ? toml_key : idl_field;
  std::set<std::string> names;
  for (const Line& line : Lines(source.text)) {
    std::smatch match;
    if (std::regex_search(line.text, match, pattern)) names.insert(match[1]);
  }
  std::vector<std::string> violations;
  for (const std::string& name : names) {
    if (document.text.find("`" + name + "`") != std::string::npos) continue;
    violations.push_back(document.path + ": does not explain `" + name + "` of " + source.path);
  }
  return violations;
}

std::vector<std::string> DeadLinks(const SourceFile& document,
                                   const std::vector<SourceFile>& tree) {
  static const std::regex link(R"(\]\(([^)#:]+)(#[^)]*)?\))");
  std::vector<std::string> violations;
  const auto folder = std::filesystem::path(document.path).parent_path();
  bool code = false;  // where a lambda looks like a link
  for (const Line& line : Lines(document.text)) {
    if (line.text.starts_with("```")) code = !code;
    if (code) continue;
    for (std::sregex_iterator i(line.text.begin(), line.text.end(), link), end; i != end; ++i) {
      std::string target = (folder / (*i)[1].str()).lexically_normal().string();
      if (target.ends_with('/')) target.pop_back();
      const bool exists = std::any_of(tree.begin(), tree.end(), [&](const SourceFile& file) {
        return file.path == target || file.In(target + "/");
      });
      if (!exists) violations.push_back(At(document, line.number, "there is no " + target));
    }
  }
  return violations;
}

std::set<std::string> TestsOf(const std::vector<SourceFile>& tree) {
  static const std::regex declared(R"(TEST\w*\(\s*(\w+),\s*(\w+)\))");
  std::set<std::string> tests;
  for (const SourceFile& file : tree) {
    if (!file.IsCpp()) continue;
    for (std::size_t at = 0; (at = file.text.find("TEST", at)) != std::string::npos; ++at) {
      std::smatch match;
      if (std::regex_search(file.text.begin() + static_cast<std::ptrdiff_t>(at), file.text.end(),
                            match, declared, std::regex_constants::match_continuous)) {
        tests.insert(match[1].str() + "." + match[2].str());
      }
    }
  }
  return tests;
}

std::vector<std::string> MissingTests(const SourceFile& document,
                                      const std::set<std::string>& tests) {
  static const std::regex cited(R"(`([A-Z]\w+\.[A-Z]\w+)`)");
  std::vector<std::string> violations;
  for (const Line& line : Lines(document.text)) {
    for (std::sregex_iterator i(line.text.begin(), line.text.end(), cited), end; i != end; ++i) {
      const std::string name = (*i)[1];
      if (tests.contains(name)) continue;
      violations.push_back(At(document, line.number, "there is no test " + name));
    }
  }
  return violations;
}

}  // namespace musher::house
