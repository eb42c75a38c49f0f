#include "musher/view/page/files.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>

namespace musher::view {
namespace {

std::set<std::string> Paths() {
  std::set<std::string> paths;
  for (const http::Asset& file : PageFiles()) paths.emplace(file.path);
  return paths;
}

// The names in `text` that `pattern` captures, as paths.
std::set<std::string> NamesIn(std::string_view text, const std::string& pattern) {
  std::set<std::string> names;
  const std::regex regex(pattern);
  using Iterator = std::regex_iterator<std::string_view::const_iterator>;
  for (Iterator i(text.begin(), text.end(), regex), end; i != end; ++i) {
    names.insert("/" + (*i)[1].str());
  }
  return names;
}

TEST(PageFilesTest, EveryFileThatThePageNamesIsEmbedded) {
  const std::set<std::string> paths = Paths();
  const http::Asset* index = http::FindAsset(PageFiles(), "/");
  ASSERT_NE(index, nullptr);
  const auto named = NamesIn(index->content, R"re((?:href|src)="([a-z_]+\.[a-z]+)")re");
  EXPECT_EQ(named.count("/app.js"), 1u);
  EXPECT_EQ(named.count("/style.css"), 1u);
  for (const std::string& name : named) EXPECT_EQ(paths.count(name), 1u) << name;
}

TEST(PageFilesTest, EveryModuleIsImportedAndEveryImportIsEmbedded) {
  const std::set<std::string> paths = Paths();
  std::set<std::string> imported = {"/app.js"};
  for (const http::Asset& file : PageFiles()) {
    for (const std::string& name : NamesIn(file.content, R"re(from '\./([a-z0-9_]+\.js)')re")) {
      EXPECT_EQ(paths.count(name), 1u) << file.path << " imports " << name;
      imported.insert(name);
    }
  }
  for (const std::string& path : paths) {
    if (path.ends_with(".js")) {
      EXPECT_EQ(imported.count(path), 1u) << path << " is not imported";
    }
  }
}

TEST(PageFilesTest, TheWholePageIsBelow181Kilobytes) {
  std::size_t bytes = 0;
  for (const http::Asset& file : PageFiles()) bytes += file.content.size();
  EXPECT_GT(bytes, 50'000u);
  EXPECT_LT(bytes, 181'000u);
}

}  // namespace
}  // namespace musher::view
