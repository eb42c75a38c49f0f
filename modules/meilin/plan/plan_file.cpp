#include "musher/modules/meilin/plan/plan_file.hpp"

#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::meilin {
namespace {

using config_toml::Findings;
using config_toml::Position;
using config_toml::Table;
using config_toml::TableReader;

constexpr double kDegree = kPi / 180;

// Follows the robot through the steps, for the yaws and heights that the text leaves out.
class DrawnPlanReader {
 public:
  DrawnPlanReader(const PlanRules& rules, Findings& findings)
      : rules_(rules), findings_(findings) {}

  DrawnPlan Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    if (const auto side = root.Choice<Side>("side", {{"blue", Side::kBlue}, {"red", Side::kRed}})) {
      plan_.side = *side;
    }
    rules_.grid.side = plan_.side;
    ReadStart(root);
    root.Require("step", "a table [[step]] for each step");
    for (const config_toml::Value* step : root.Tables("step")) ReadStep(*step);
    root.RefuseOthers();
    if (!findings_.HasErrors()) Check();
    return std::move(plan_);
  }

 private:
  std::optional<Cell> ReadCell(TableReader& reader, std::string_view key) {
    const auto numbers = reader.Integers(key, 0, kRows - 1);
    if (!numbers) return std::nullopt;
    const auto* written = reader.Get(key)->As<config_toml::Array>();
    if (written != nullptr && written->size() == 2 && numbers->size() != 2) return std::nullopt;
    if (numbers->size() != 2) {
      reader.Fault(reader.At(key), key, "expected a row and a column, as in [1, 0]");
      return std::nullopt;
    }
    const Cell cell{static_cast<int>(numbers->front()), static_cast<int>(numbers->back())};
    if (IsInside(cell)) return cell;
    reader.Fault(reader.At(key), key,
                 "there is no column " + std::to_string(cell.col) + ", expected 0 to " +
                     std::to_string(kCols - 1));
    return std::nullopt;
  }

  std::optional<double> ReadYaw(TableReader& reader, std::string_view key) {
    const auto degrees = reader.Number(key, -360, 360);
    if (!degrees) return std::nullopt;
    return NormalizeYaw(*degrees * kDegree);
  }

  void ReadStart(TableReader& root) {
    plan_.start.cell = ReadCell(root, "start").value_or(Cell{});
    plan_.start.yaw_rad = ReadYaw(root, "start_yaw_deg").value_or(0);
    plan_.start.height_mm = rules_.grid.HeightMm(plan_.start.cell);
    cell_ = plan_.start.cell;
    yaw_rad_ = plan_.start.yaw_rad;
  }

  void ReadStep(const config_toml::Value& value) {
    const Table* table = value.As<Table>();
    if (table == nullptr) return;
    TableReader reader(*table, value.at, "step", findings_);
    const auto move = ReadCell(reader, "move");
    const auto fetch = ReadCell(reader, "fetch");
    const auto yaw_rad = ReadYaw(reader, "yaw_deg");
    const bool both = reader.Has("move") && reader.Has("fetch");
    if (both || (!reader.Has("move") && !reader.Has("fetch"))) {
      findings_.Error(value.at, "a step has either move = [row, column] or fetch = [row, column]");
    } else if (move) {
      AddMove(*move, yaw_rad);
    } else if (fetch) {
      AddFetch(*fetch, yaw_rad);
    }
    places_.push_back(value.at);
    reader.RefuseOthers();
  }

  void AddMove(Cell to, std::optional<double> yaw_rad) {
    cell_ = to;
    yaw_rad_ = yaw_rad.value_or(yaw_rad_);
    plan_.steps.push_back({false, to, static_cast<double>(rules_.grid.HeightMm(to)), yaw_rad_});
  }

  void AddFetch(Cell box, std::optional<double> yaw_rad) {
    const auto direction = DirectionTo(cell_, box);
    if (direction) yaw_rad_ = YawOf(*direction);
    yaw_rad_ = yaw_rad.value_or(yaw_rad_);
    const int difference_mm = rules_.grid.HeightMm(box) - rules_.grid.HeightMm(cell_);
    plan_.steps.push_back({true, box, static_cast<double>(difference_mm), yaw_rad_});
  }

  // Each step that was read has a place: without an error no step is left out.
  void Check() {
    const PlanReading reading =
        ReadActionSequence(ToActionSequence(plan_.steps), rules_, plan_.start);
    for (const PlanFault& fault : reading.faults) {
      const bool whole = fault.step == 0 || places_.empty();
      findings_.Error(whole ? Position{1, 1} : places_.at(static_cast<std::size_t>(fault.step - 1)),
                      fault.message);
    }
  }

  PlanRules rules_;
  Findings& findings_;
  DrawnPlan plan_;
  std::vector<Position> places_;  // of the steps
  Cell cell_;
  double yaw_rad_ = 0;
};

}  // namespace

DrawnPlanReading ReadPlanText(std::string_view text, const std::string& path,
                              const PlanRules& rules) {
  return config_toml::ReadTextWith<DrawnPlanReading>(
      text, path, [&rules](const Table& root, Findings& findings) {
        return DrawnPlanReader(rules, findings).Read(root);
      });
}

DrawnPlanReading ReadPlanFile(const std::string& path, const PlanRules& rules) {
  return config_toml::ReadFileWith(path, [&rules](std::string_view text, const std::string& file) {
    return ReadPlanText(text, file, rules);
  });
}

}  // namespace musher::meilin
