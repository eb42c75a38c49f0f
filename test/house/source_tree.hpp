#pragma once
// The files of this repository, as the house rules see them: no build folders, nothing hidden.

#include <string>
#include <string_view>
#include <vector>

namespace musher::house {

struct SourceFile {
  std::string path;  // from the root: "lifecycle/switch/plan.cpp"
  std::string text;
  bool executable = false;

  std::string Folder() const;  // the first part of the path: "lifecycle"
  bool Is(std::string_view extension) const { return path.ends_with(extension); }
  bool In(std::string_view folder) const { return path.starts_with(folder); }
  bool IsCpp() const { return Is(".cpp") || Is(".hpp"); }
};

// All files under `root`, by path.
std::vector<SourceFile> ReadTree(const std::string& root);

struct Line {
  int number = 0;  // from 1
  std::string text;
};
std::vector<Line> Lines(std::string_view text);

// C++ without its comments; strings and line numbers stay.
std::string WithoutComments(std::string_view text);

// What a rule has to say about one place: "lifecycle/switch/plan.cpp:12: ...".
std::string At(const SourceFile& file, int line, const std::string& violation);

}  // namespace musher::house
