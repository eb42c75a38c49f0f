#include "musher/test/house/source_tree.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace musher::house {
namespace {

namespace fs = std::filesystem;

std::string Read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool IsOurs(const fs::path& path) {
  const std::string name = path.filename().string();
  return name != "build" && name != "node_modules" && (name == ".ci" || !name.starts_with('.'));
}

}  // namespace

std::string SourceFile::Folder() const {
  return path.substr(0, path.find('/'));
}

std::vector<SourceFile> ReadTree(const std::string& root) {
  std::vector<SourceFile> files;
  for (auto i = fs::recursive_directory_iterator(root); i != fs::end(i); ++i) {
    if (!IsOurs(i->path())) {
      i.disable_recursion_pending();
    } else if (i->is_regular_file()) {
      const bool executable =
          (i->status().permissions() & fs::perms::owner_exec) != fs::perms::none;
      files.push_back({fs::relative(i->path(), root).string(), Read(i->path()), executable});
    }
  }
  std::sort(files.begin(), files.end(),
            [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
  return files;
}

std::vector<Line> Lines(std::string_view text) {
  std::vector<Line> lines;
  std::istringstream stream{std::string(text)};
  for (std::string line; std::getline(stream, line);) {
    lines.push_back({static_cast<int>(lines.size()) + 1, line});
  }
  return lines;
}

std::string WithoutComments(std::string_view text) {
  std::string code;
  char quote = 0;  // in which kind of literal we are
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view next = text.substr(i, 2);
    if (quote != 0) {
      if (text[i] == '\\' && next.size() == 2)
        code += text[i++];
      else if (text[i] == quote)
        quote = 0;
      code += text[i];
    } else if (next == "//") {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else if (next == "/*") {
      const std::size_t end = std::min(text.find("*/", i), text.size() - 2) + 2;
      code.append(static_cast<std::size_t>(std::count(text.begin() + i, text.begin() + end, '\n')),
                  '\n');
      i = end - 1;
    } else {
      const bool digit_separator = text[i] == '\'' && i > 0 && std::isalnum(text[i - 1]) != 0;
      if ((text[i] == '"' || text[i] == '\'') && !digit_separator) quote = text[i];
      code += text[i];
    }
  }
  return code;
}

std::string At(const SourceFile& file, int line, const std::string& violation) {
  return file.path + ":" + std::to_string(line) + ": " + violation;
}

}  // namespace musher::house
