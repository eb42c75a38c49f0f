#pragma once
// The line of a key of a table in the text of a config.

#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace musher::cli {

class ConfigPlaces {
 public:
  explicit ConfigPlaces(const std::string& file) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) lines_.push_back(line);
  }

  // Line from 1; that of the table where it has no such key; 0 where there is no such table.
  int LineOf(const std::string& table, std::string_view key) const {
    int found = 0;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const std::size_t begin = lines_[i].find_first_not_of(" \t");
      if (begin == std::string::npos) continue;
      const std::string_view line = std::string_view(lines_[i]).substr(begin);
      if (found != 0 && line.starts_with('[')) return found;
      if (line.starts_with("[" + table + "]")) found = static_cast<int>(i) + 1;
      if (found != 0 && line.starts_with(key)) return static_cast<int>(i) + 1;
    }
    return found;
  }

 private:
  std::vector<std::string> lines_;
};

}  // namespace musher::cli
