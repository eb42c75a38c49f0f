#include "musher/modules/meilin/plan/plan_text.hpp"
#include "musher/base/words.hpp"

#include <fmt/format.h>

namespace musher::meilin {
namespace {

constexpr int kCellWidth = 16;

std::string_view BoxText(Box box) {
  switch (box) {
    case Box::kEmpty:
      return "";
    case Box::kKfs1:
      return "KFS1";
    case Box::kKfs2:
      return "KFS2";
    case Box::kFake:
      return "fake";
  }
  return "";
}

// "move 1, 3; fetch 2", shortened to the cell.
std::string StepsAt(const std::vector<PlanStep>& steps, Cell cell) {
  std::string moves, fetches;
  int number = 0;
  for (const PlanStep& step : steps) {
    ++number;
    if (step.cell != cell) continue;
    std::string& list = step.fetch ? fetches : moves;
    list += (list.empty() ? "" : ",") + std::to_string(number);
  }
  std::string text = moves.empty() ? "" : "to " + moves;
  if (!fetches.empty()) text += (text.empty() ? "" : " ") + ("take " + fetches);
  if (text.size() > kCellWidth - 2) text.resize(kCellWidth - 2);
  return text;
}

std::string Border() {
  std::string line = "     +";
  for (int col = 0; col < kCols; ++col) line.append(kCellWidth, '-').append("+");
  return line + "\n";
}

}  // namespace

std::string StepTable(const std::vector<PlanStep>& steps, const Grid& grid) {
  std::string table = fmt::format("{:>4}  {:<13} {:<9} {:>9} {:>8}   {}\n", "step", "what", "goes",
                                  "height", "yaw", "numbers");
  Cell here{-1, -1};
  int number = 0;
  for (const PlanStep& step : steps) {
    const auto direction = DirectionTo(here, step.cell);
    const std::string height = step.fetch ? fmt::format("{:+g} mm", step.height_mm)
                                          : fmt::format("{} mm", grid.HeightMm(step.cell));
    const std::string what = (step.fetch ? "fetch " : "move ") + CellText(step.cell);
    const std::string_view goes =
        direction ? DirectionText(*direction) : (here == step.cell ? "centre" : "");
    table += fmt::format("{:>4}  {:<13} {:<9} {:>9} {:>4.0f} deg   {} {} {} {:g} {:.4g} 0 0 0\n",
                         ++number, what, goes, height, step.yaw_rad * 180 / kPi, step.fetch ? 1 : 0,
                         step.cell.row, step.cell.col, step.height_mm, step.yaw_rad);
    if (!step.fetch) here = step.cell;
  }
  return table;
}

std::string FieldDrawing(const BoxMap& map, const std::vector<PlanStep>& steps) {
  Grid grid;
  grid.side = map.side;
  std::string drawing =
      fmt::format("{} field, from above; the robot enters at row 0\n      ", SideText(map.side));
  for (int col = kCols - 1; col >= 0; --col) {
    drawing += fmt::format("{:^{}} ", fmt::format("col {}", col), kCellWidth);
  }
  drawing.erase(drawing.find_last_not_of(' ') + 1);
  drawing += "\n" + Border();
  for (int row = kRows - 1; row >= 0; --row) {
    std::string heights = fmt::format("row {}|", row);
    std::string ways = "     |";
    for (int col = kCols - 1; col >= 0; --col) {
      const Cell cell{row, col};
      const std::string what = fmt::format("{} mm {}", grid.HeightMm(cell), BoxText(map.At(cell)));
      heights += fmt::format(" {:<{}}|", what, kCellWidth - 1);
      ways += fmt::format(" {:<{}}|", StepsAt(steps, cell), kCellWidth - 1);
    }
    drawing += heights + "\n" + ways + "\n" + Border();
  }
  return drawing;
}

std::string RouteSummary(const Route& route) {
  return fmt::format("{} KFS2, {:g} s, {} KFS1 on the way, {}", route.kfs2_count, route.cost_s,
                     route.kfs1_affected, Counted(route.steps.size(), "step"));
}

}  // namespace musher::meilin
