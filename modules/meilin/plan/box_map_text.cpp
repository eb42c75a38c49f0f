#include "musher/modules/meilin/plan/box_map_text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/base/words.hpp"
#include "musher/modules/meilin/plan/json_reader.hpp"

namespace musher::meilin {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::string_view kGridRule = "six rows of three numbers, as in [[0, 2, 0], …]";
constexpr std::string_view kBoxRule = "0 (empty), 1 (KFS1), 2 (KFS2) or 3 (fake)";

void ReadGridJson(const nlohmann::json& grid, JsonFaults& faults, BoxMap& map) {
  if (!grid.is_array() || grid.size() != kRows) {
    return faults.Add("grid", fmt::format("expected {}, found {}", kGridRule,
                                          grid.is_array() ? Counted(grid.size(), "row")
                                                          : std::string(JsonTypeName(grid))));
  }
  for (std::size_t row = 0; row < kRows; ++row) {
    const nlohmann::json& cells = grid[row];
    if (!cells.is_array() || cells.size() != kCols) {
      faults.Add(fmt::format("grid[{}]", row),
                 fmt::format("expected {} numbers, found {}", kCols,
                             cells.is_array() ? std::to_string(cells.size())
                                              : std::string(JsonTypeName(cells))));
      continue;
    }
    for (std::size_t col = 0; col < kCols; ++col) {
      const nlohmann::json& cell = cells[col];
      const double number = cell.is_number_integer() ? cell.get<double>() : -1;
      if (number >= 0 && number <= 3) {
        map.boxes.at(row).at(col) = static_cast<Box>(static_cast<int>(number));
        continue;
      }
      faults.Add(fmt::format("grid[{}][{}]", row, col),
                 fmt::format("expected {}, found {}", kBoxRule,
                             cell.is_number() ? cell.dump() : std::string(JsonTypeName(cell))));
    }
  }
}

void ReadGridToml(TableReader& root, BoxMap& map) {
  root.Require("grid", kGridRule);
  const config_toml::Value* value = root.Get("grid");
  if (value == nullptr) return;
  const auto* rows = value->As<config_toml::Array>();
  if (rows == nullptr || rows->size() != kRows) {
    return root.Fault(value->at, "grid",
                      fmt::format("expected {}, found {}", kGridRule,
                                  rows == nullptr ? std::string(TypeName(*value))
                                                  : Counted(rows->size(), "row")));
  }
  for (std::size_t row = 0; row < kRows; ++row) {
    const auto* cells = rows->at(row).As<config_toml::Array>();
    if (cells == nullptr || cells->size() != kCols) {
      root.Fault(rows->at(row).at, "grid", fmt::format("row {}: expected three numbers", row));
      continue;
    }
    for (std::size_t col = 0; col < kCols; ++col) {
      const auto* number = cells->at(col).As<std::int64_t>();
      if (number != nullptr && *number >= 0 && *number <= 3) {
        map.boxes.at(row).at(col) = static_cast<Box>(*number);
      } else {
        root.Fault(cells->at(col).at, "grid", fmt::format("expected {}", kBoxRule));
      }
    }
  }
}

BoxMap ReadMapTable(const Table& table, Findings& findings) {
  BoxMap map;
  TableReader root(table, {1, 1}, "", findings);
  root.Require("team", "\"blue\" or \"red\"");
  if (const auto side = root.Choice<Side>("team", {{"blue", Side::kBlue}, {"red", Side::kRed}})) {
    map.side = *side;
  }
  if (const auto omni = root.Choice<bool>("method", {{"one-way", false}, {"omni", true}})) {
    map.omni = *omni;
  }
  ReadGridToml(root, map);
  root.RefuseOthers();
  return map;
}

}  // namespace

BoxMapReading ReadBoxMapJson(std::string_view text) {
  BoxMapReading reading;
  JsonFaults faults;
  BoxMap map;
  if (const auto document = ParseJson(text, faults)) {
    JsonObject root(*document, "", faults);
    root.Require("team", "\"red\" or \"blue\"");
    root.Require("grid", kGridRule);
    if (const auto team = root.Choice("team", {"blue", "red"})) {
      map.side = *team == 0 ? Side::kBlue : Side::kRed;
    }
    map.omni = root.Integer("method", 0, 1).value_or(1) == 0;
    if (const nlohmann::json* grid = root.Get("grid")) ReadGridJson(*grid, faults, map);
  }
  reading.faults = faults.list();
  if (reading.faults.empty()) reading.map = map;
  return reading;
}

BoxMapFileReading ReadBoxMapText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<BoxMapFileReading>(text, path, ReadMapTable);
}

BoxMapFileReading ReadBoxMapFile(const std::string& path) {
  return config_toml::ReadFileWith(path, [](std::string_view text, const std::string& file) {
    if (!file.ends_with(".json")) return ReadBoxMapText(text, file);
    const BoxMapReading read = ReadBoxMapJson(text);
    BoxMapFileReading reading{read.map, {}};
    for (const std::string& fault : read.faults) {
      reading.diagnostics.push_back({file, 0, 0, Severity::kError, fault});
    }
    return reading;
  });
}

std::string RoutesJson(const Routes& routes) {
  nlohmann::ordered_json buckets = nlohmann::ordered_json::array();
  for (std::size_t count = 0; count < routes.size(); ++count) {
    nlohmann::ordered_json paths = nlohmann::ordered_json::array();
    for (const Route& route : routes.at(count).routes) {
      nlohmann::ordered_json detail = nlohmann::ordered_json::array();
      for (const PlanStep& step : route.steps) {
        detail.push_back({step.fetch ? 1 : 0, step.cell.row, step.cell.col, step.height_mm,
                          step.yaw_rad, 0, 0, 0});
      }
      paths.push_back({{"index", paths.size() + 1},
                       {"cost", route.cost_s},
                       {"kfs2_count", route.kfs2_count},
                       {"kfs1_affected", route.kfs1_affected},
                       {"steps", route.steps.size()},
                       {"detail", std::move(detail)}});
    }
    buckets.push_back(
        {{"kfs2_count", count}, {"total", routes.at(count).total}, {"paths", std::move(paths)}});
  }
  return nlohmann::ordered_json{{"buckets", std::move(buckets)}}.dump();
}

}  // namespace musher::meilin
