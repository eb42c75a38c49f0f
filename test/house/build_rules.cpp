#include "musher/test/house/build_rules.hpp"

#include <filesystem>
#include <regex>
#include <set>

namespace musher::house {

std::vector<std::string> DeadFiles(const std::vector<SourceFile>& tree) {
  static const std::regex name(R"([\w./*-]+\.cpp\b)");  // or a pattern: "commands/*.cpp"
  std::set<std::string> built;
  std::set<std::string> built_folders;
  for (const SourceFile& file : tree) {
    if (!file.Is("CMakeLists.txt")) continue;
    const auto folder = std::filesystem::path(file.path).parent_path();
    for (const Line& line : Lines(file.text)) {
      const std::string text = line.text.substr(0, line.text.find('#'));
      for (std::sregex_iterator i(text.begin(), text.end(), name), end; i != end; ++i) {
        const auto path = (folder / i->str()).lexically_normal();
        const std::string pattern = path.filename().string();
        if (pattern.starts_with('*')) built_folders.insert(path.parent_path().string());
        built.insert(path.string());
      }
    }
  }
  std::vector<std::string> unbuilt;
  for (const SourceFile& file : tree) {
    const std::string folder = std::filesystem::path(file.path).parent_path().string();
    if (file.Is(".cpp") && !built.contains(file.path) && !built_folders.contains(folder)) {
      unbuilt.push_back(file.path + ": is in no CMake target");
    }
  }
  return unbuilt;
}

}  // namespace musher::house
