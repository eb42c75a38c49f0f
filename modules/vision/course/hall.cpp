#include "musher/modules/vision/course/hall.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "musher/base/toml/rows.hpp"
#include "musher/modules/vision/course/marker_finder.hpp"

namespace musher::vision {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

void ReadHsv(TableReader& reader, std::string_view key, std::array<int, 3>& hsv) {
  constexpr std::array<std::int64_t, 3> kMost = {179, 255, 255};
  const auto found = reader.Integers(key, INT32_MIN, INT32_MAX);
  if (!found) return;
  bool valid = found->size() == kMost.size();
  for (std::size_t i = 0; valid && i < kMost.size(); ++i) {
    valid = (*found)[i] >= 0 && (*found)[i] <= kMost.at(i);
  }
  if (!valid) {
    return reader.Fault(reader.At(key), key,
                        "expected [hue 0 to 179, saturation 0 to 255, value 0 to 255]");
  }
  std::transform(found->begin(), found->end(), hsv.begin(),
                 [](std::int64_t number) { return static_cast<int>(number); });
}

std::string PathOf(const TableReader& reader, std::string_view key) {
  return reader.path().empty() ? std::string(key) : reader.path() + "." + std::string(key);
}

void ReadRegions(TableReader& hall, std::map<std::string, Region>& regions, Findings& findings) {
  const Table* table = hall.SubTable("regions");
  if (table == nullptr) return;
  TableReader reader(*table, hall.At("regions"), "hall.regions", findings);
  for (const char* kind : {"arrow", "barrier", "marker", "light"}) {
    Region region = kind == std::string_view("marker")  ? MarkerParameters().region
                    : kind == std::string_view("light") ? LightParameters().region
                                                        : Region();
    if (ReadRegion(reader, kind, region, findings)) regions.emplace(kind, region);
  }
  reader.RefuseOthers();
}

void ReadBalance(TableReader& hall, std::optional<WhiteBalance>& balance) {
  constexpr std::string_view kKey = "white_balance";
  if (!hall.Has(kKey)) return;
  WhiteBalance& found = balance.emplace();
  row::Numbers(kKey, {&found.red, &found.green, &found.blue}, kLeastGain, kMostGain,
               "expected the factors [red, green, blue], each 0.2 to 5")(hall);
}

void ReadHallTable(const Table& table, config_toml::Position at, Hall& hall, double& trunk_height_m,
                   Findings& findings) {
  TableReader reader(table, at, "hall", findings);
  const auto color = [&](std::string_view key, std::optional<HsvRange>& range) {
    HsvRange found;
    if (ReadColor(reader, key, found, findings)) range = found;
  };
  color("yellow", hall.yellow);
  color("green", hall.green);
  color("red", hall.red);
  ReadBalance(reader, hall.balance);
  ReadRegions(reader, hall.regions, findings);
  ReadRows(reader, {row::Number("lane_m", hall.lane_m, 0.2, 5),
                    row::Numbers("line_width_m", {&hall.least_line_m, &hall.most_line_m}, 0.001, 1,
                                 "expected [the least, the most], in metres"),
                    row::Check(
                        "line_width_m", [&] { return hall.least_line_m <= hall.most_line_m; },
                        "expected the least width first"),
                    row::Number("trunk_height_m", trunk_height_m, 0.01, 2)});
}

void ReadMount(const Table& table, config_toml::Position at, double trunk_height_m, Hall& hall,
               Findings& findings) {
  TableReader reader(table, at, "mounts", findings);
  reader.Require("picture", "the topic of the camera's picture, as in \"image_left\"");
  std::string picture;
  Mount mount;
  mount.trunk_height_m = trunk_height_m;
  config_toml::Rows rows = navigation::CameraRows(mount.camera);
  rows.push_back(row::Topic("picture", picture, "image_left"));
  ReadRows(reader, rows);
  if (picture.empty() || hall.mounts.emplace(picture, mount).second) return;
  reader.Fault(reader.At("picture"), "picture",
               "there is a mount of the camera of \"" + picture + "\" already");
}

}  // namespace

bool ReadColor(TableReader& reader, std::string_view key, HsvRange& range, Findings& findings) {
  const Table* table = reader.SubTable(key);
  if (table == nullptr) return false;
  TableReader color(*table, reader.At(key), PathOf(reader, key), findings);
  ReadHsv(color, "from", range.from);
  ReadHsv(color, "to", range.to);
  color.RefuseOthers();
  for (const std::size_t i : {1, 2}) {
    if (range.from.at(i) <= range.to.at(i)) continue;
    color.Fault(color.At("to"), "to",
                std::string(i == 1 ? "the saturation" : "the value") +
                    " must not be less than that of from; only a hue may go through 0");
  }
  return true;
}

bool ReadRegion(TableReader& reader, std::string_view key, Region& region, Findings& findings) {
  const Table* table = reader.SubTable(key);
  if (table == nullptr) return false;
  ReadRegion(*table, reader.At(key), PathOf(reader, key), region, findings);
  return true;
}

void ReadRegion(const Table& table, config_toml::Position at, const std::string& path,
                Region& region, Findings& findings) {
  TableReader reader(table, at, path, findings);
  region.top = reader.Number("top", 0, 1).value_or(region.top);
  region.bottom = reader.Number("bottom", 0, 1).value_or(region.bottom);
  region.left = reader.Number("left", 0, 1).value_or(region.left);
  region.right = reader.Number("right", 0, 1).value_or(region.right);
  reader.RefuseOthers();
  if (region.bottom <= region.top) {
    reader.Fault(reader.At("bottom"), "bottom", "must be more than top: y is downwards");
  }
  if (region.right <= region.left) {
    reader.Fault(reader.At("right"), "right", "must be more than left");
  }
}

Hall ReadHall(TableReader& root, Findings& findings) {
  Hall hall;
  double trunk_height_m = Mount().trunk_height_m;
  if (const Table* table = root.SubTable("hall")) {
    ReadHallTable(*table, root.At("hall"), hall, trunk_height_m, findings);
  }
  for (const config_toml::Value* value : root.Tables("mounts")) {
    if (const auto* table = value->As<Table>()) {
      ReadMount(*table, value->at, trunk_height_m, hall, findings);
    }
  }
  return hall;
}

}  // namespace musher::vision
