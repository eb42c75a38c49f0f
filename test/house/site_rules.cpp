#include "musher/test/house/site_rules.hpp"

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>

#include "musher/test/house/reference_rules.hpp"

namespace musher::house {
namespace {

constexpr const char* kContents = "docs/site/contents.py";

// The fenced blocks, each with its language and the comment above that names its source.
std::vector<std::string> BlocksOf(const std::string& text) {
  std::vector<std::string> blocks;
  bool inside = false;
  std::string above;
  for (const Line& line : Lines(text)) {
    const bool fence = line.text.starts_with("```");
    if (fence && !inside) {
      blocks.push_back(above.starts_with("<!--") ? above + "\n" : "");
      inside = true;
    } else if (fence) {
      inside = false;
    }
    if (inside) blocks.back() += line.text + "\n";
    above = line.text;
  }
  return blocks;
}

// The lines of headings, outside of code.
std::vector<Line> HeadingsOf(const std::string& text) {
  static const std::regex heading("#+ .*");
  std::vector<Line> headings;
  bool code = false;
  for (const Line& line : Lines(text)) {
    if (line.text.starts_with("```")) code = !code;
    if (!code && std::regex_match(line.text, heading)) headings.push_back(line);
  }
  return headings;
}

std::size_t DepthOf(const Line& heading) {
  return heading.text.find(' ');
}

// The comment below "#pragma once", which the site shows.
std::string TopComment(const std::string& header) {
  std::string comment;
  for (const Line& line : Lines(header)) {
    if (line.number == 1) continue;
    if (!line.text.starts_with("//")) break;
    comment += line.text + "\n";
  }
  return comment;
}

std::string FirstLines(const std::string& block) {
  return block.substr(0, 60);
}

}  // namespace

std::vector<std::string> PagesOutsideTheContents(const std::vector<SourceFile>& tree) {
  static const std::regex branches(R"re("((?:\w+/)+\w+)")re");
  static const std::regex item(R"(^(?:-|\d+\.) \[[^\]]*\]\(([^)#]+\.md)\))");
  std::set<std::string> branch_pages;
  for (const SourceFile& file : tree) {
    if (file.path != kContents) continue;
    const std::size_t begin = file.text.find("BRANCHES = {");
    const std::string names = file.text.substr(begin, file.text.find('}', begin) - begin);
    for (std::sregex_iterator i(names.begin(), names.end(), branches), end; i != end; ++i) {
      branch_pages.insert((*i)[1].str() + ".md");
    }
  }
  if (branch_pages.empty()) return {std::string("there are no BRANCHES in ") + kContents};
  std::set<std::string> listed = {"docs/README.md"};
  for (const SourceFile& file : tree) {
    if (!branch_pages.contains(file.path)) continue;
    const auto folder = std::filesystem::path(file.path).parent_path();
    for (const Line& line : Lines(file.text)) {
      std::smatch match;
      if (!std::regex_search(line.text, match, item)) continue;
      listed.insert((folder / match[1].str()).lexically_normal().string());
    }
  }
  std::vector<std::string> missing;
  for (const SourceFile& file : tree) {
    // What `musher new` copies is for the project that it makes.
    const bool page = file.Is(".md") && !file.path.starts_with("examples/new_");
    if (page && !listed.contains(file.path)) {
      missing.push_back(file.path + " is in no list of links of a page of the contents");
    }
  }
  return missing;
}

std::vector<std::string> DifferingBlocks(const SourceFile& original, const std::string& section,
                                         const SourceFile& translated) {
  const auto expected = BlocksOf(section.empty() ? original.text : SectionOf(original, section));
  const auto found = BlocksOf(translated.text);
  std::vector<std::string> wrong;
  if (expected.empty()) wrong.push_back(original.path + ": there is no code in '" + section + "'");
  for (std::size_t i = 0; i < std::max(expected.size(), found.size()); ++i) {
    const std::string number = translated.path + ": code block " + std::to_string(i + 1) + ": ";
    if (i >= found.size()) {
      wrong.push_back(number + "missing: " + FirstLines(expected[i]));
    } else if (i >= expected.size()) {
      wrong.push_back(number + "not in " + original.path + ": " + FirstLines(found[i]));
    } else if (found[i] != expected[i]) {
      wrong.push_back(number + "differs from " + original.path + ", which has:\n" + expected[i]);
    }
  }
  return wrong;
}

std::vector<std::string> DifferingHeadings(const SourceFile& original,
                                           const SourceFile& translated) {
  const std::vector<Line> expected = HeadingsOf(original.text);
  const std::vector<Line> found = HeadingsOf(translated.text);
  std::vector<std::string> wrong;
  for (std::size_t i = 0; i < std::max(expected.size(), found.size()); ++i) {
    if (i >= found.size()) {
      wrong.push_back(translated.path + ": nothing translates \"" + expected[i].text + "\"");
    } else if (i >= expected.size()) {
      wrong.push_back(
          At(translated, found[i].number, "\"" + found[i].text + "\" is not in " + original.path));
    } else if (DepthOf(found[i]) != DepthOf(expected[i])) {
      wrong.push_back(At(translated, found[i].number,
                         "\"" + found[i].text + "\" stands where " + original.path + " has \"" +
                             expected[i].text + "\""));
      break;  // those behind are moved
    }
  }
  return wrong;
}

std::vector<std::string> HeadersWithoutThreads(const std::vector<SourceFile>& tree) {
  static const std::regex shown(R"(```\{header\} (\S+))");
  std::vector<std::string> wrong;
  bool any = false;
  for (const SourceFile& page : tree) {
    if (!page.In("docs/api/")) continue;
    for (std::sregex_iterator i(page.text.begin(), page.text.end(), shown), end; i != end; ++i) {
      any = true;
      const std::string path = (*i)[1];
      const auto header = std::find_if(tree.begin(), tree.end(),
                                       [&](const SourceFile& file) { return file.path == path; });
      if (header == tree.end()) {
        wrong.push_back(page.path + ": there is no " + path);
      } else if (TopComment(header->text).find("Threads: ") == std::string::npos) {
        wrong.push_back(path + ": its comment has no line \"Threads: ...\", which " + page.path +
                        " shows");
      }
    }
  }
  if (!any) wrong.emplace_back("no page of docs/api shows a header");
  return wrong;
}

std::vector<std::string> DrawingsThatFitNoPage(const std::vector<SourceFile>& tree) {
  static const std::regex size("<svg width=\"([0-9]+)pt\" height=\"([0-9]+)pt\"");
  constexpr int kShort = 595 - 2 * 36;
  constexpr int kLong = 842 - 2 * 36;
  std::vector<std::string> wrong;
  for (const SourceFile& file : tree) {
    std::smatch match;
    if (!file.In("docs/") || !file.Is(".svg") || !std::regex_search(file.text, match, size))
      continue;
    const auto [shorter, longer] = std::minmax({std::stoi(match[1]), std::stoi(match[2])});
    if (shorter <= kShort && longer <= kLong) continue;
    wrong.push_back(file.path + " fits no page: " + match[1].str() + " x " + match[2].str() +
                    " pt; give its graph a size of at most 7.2 and 10.6 inches");
  }
  return wrong;
}

}  // namespace musher::house
