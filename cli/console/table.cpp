#include "musher/cli/console/table.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

namespace musher::cli {
namespace {

constexpr std::size_t kGap = 2;
constexpr std::size_t kLeast = 20;  // columns of a last column that is wrapped

std::size_t columns_of_terminal = 0;

// Lines of at most `width` columns, broken at spaces; a longer word stays whole.
std::vector<std::string> Wrapped(const std::string& text, std::size_t width) {
  std::vector<std::string> lines;
  std::string line;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!line.empty() && Width(line) + 1 + Width(word) > width) {
      lines.push_back(std::exchange(line, ""));
    }
    line += (line.empty() ? "" : " ") + word;
  }
  lines.push_back(line);
  return lines;
}

// A last cell that begins at column `at`, and its further lines below it.
std::string LastCell(const Table::Cell& cell, std::size_t at, bool colour) {
  const bool fits = columns_of_terminal == 0 || at + Width(cell.text) <= columns_of_terminal ||
                    at + kLeast > columns_of_terminal;
  if (fits) return Paint(cell.text, cell.style, colour);
  std::string text;
  for (const std::string& line : Wrapped(cell.text, columns_of_terminal - at)) {
    if (!text.empty()) text += "\n" + std::string(at, ' ');
    text += Paint(line, cell.style, colour);
  }
  return text;
}

}  // namespace

void FitTables(std::size_t columns) {
  columns_of_terminal = columns;
}

std::size_t Width(std::string_view text) {
  return std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;  // not a byte that continues a character
  });
}

Table::Table(std::vector<std::string> header) {
  rows_.emplace_back();
  for (std::string& title : header) rows_.front().push_back({std::move(title), Style::kDim});
}

std::string Table::Text(bool colour) const {
  std::vector<std::size_t> widths(rows_.front().size());
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i)
      widths[i] = std::max(widths[i], Width(row[i].text));
  }
  std::string text;
  for (const auto& row : rows_) {
    std::size_t pending = 0;  // spaces before the next text of this line
    std::size_t at = 0;       // column of the cell
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (!row[i].text.empty()) {
        text.append(pending, ' ');
        text += i + 1 == widths.size() ? LastCell(row[i], at, colour)
                                       : Paint(row[i].text, row[i].style, colour);
        pending = 0;
      }
      pending += widths[i] - Width(row[i].text) + kGap;
      at += widths[i] + kGap;
    }
    text += '\n';
  }
  return text;
}

}  // namespace musher::cli
