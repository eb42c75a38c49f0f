#pragma once
// Rows of cells, aligned in columns.

#include <string>
#include <string_view>
#include <vector>

#include "musher/cli/console/console.hpp"

namespace musher::cli {

// The number of terminal columns of a UTF-8 text, one for each character.
std::size_t Width(std::string_view text);

// From now on the last column of a table is wrapped to this width of the terminal; 0, as at first:
// never. For a program that prints to a terminal; loop thread only.
void FitTables(std::size_t columns);

class Table {
 public:
  struct Cell {
    std::string text;
    Style style = Style::kPlain;
  };

  explicit Table(std::vector<std::string> header);

  void Add(std::vector<Cell> row) { rows_.push_back(std::move(row)); }

  // Two spaces between columns, no trailing spaces.
  std::string Text(bool colour) const;

 private:
  std::vector<std::vector<Cell>> rows_;
};

}  // namespace musher::cli
