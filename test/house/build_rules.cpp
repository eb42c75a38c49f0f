#include "musher/test/house/build_rules.hpp"

#include <filesystem>
#include <regex>
#include <set>

namespace musher::house {

std::vector<std::string> DeadFiles(const std::vector<SourceFile>& tree) {
  static const std::regex name(R"([\w./-]+\.cpp\b)");
  std::set<std::string> built;
  for (const SourceFile& file : tree) {
    if (!file.Is("CMakeLists.txt") && !file.Is(".cmake")) continue;
    const auto folder = std::filesystem::path(file.path).parent_path();
    for (const Line& line : Lines(file.text)) {
      const std::string text = line.text.substr(0, line.text.find('#'));
      for (std::sregex_iterator i(text.begin(), text.end(), name), end; i != end; ++i) {
        built.insert((folder / i->str()).lexically_normal().string());
      }
    }
  }
  std::vector<std::string> unbuilt;
  for (const SourceFile& file : tree) {
    if (file.Is(".cpp") && !built.contains(file.path)) {
      unbuilt.push_back(file.path + ": is in no CMake target");
    }
  }
  return unbuilt;
}

}  // namespace musher::house
