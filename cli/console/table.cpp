#include "musher/cli/console/table.hpp"

#include <algorithm>

namespace musher::cli {
namespace {

constexpr std::size_t kGap = 2;

}  // namespace

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
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (!row[i].text.empty()) {
        text.append(pending, ' ');
        text += Paint(row[i].text, row[i].style, colour);
        pending = 0;
      }
      pending += widths[i] - Width(row[i].text) + kGap;
    }
    text += '\n';
  }
  return text;
}

}  // namespace musher::cli
