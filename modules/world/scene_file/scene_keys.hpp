#pragma once
// Readers of values that occur in many places of a scene file. Each reports errors, as TableReader
// does.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/world/scene/color.hpp"

namespace musher::world::keys {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Value;

inline constexpr double kFarthestM = 1000;
inline constexpr double kSmallestM = 0.01;

double Radians(double degrees);

template <typename T>
void Set(T& field, const std::optional<T>& value) {
  if (value) field = *value;
}

// Reads the table `key` of `root`, if present, and refuses the keys that `read` did not read.
template <typename Read>
void Section(TableReader& root, std::string_view key, Findings& findings, Read read) {
  const config_toml::Position at = root.At(key);
  if (const Table* table = root.SubTable(key)) {
    const std::string path =
        root.path().empty() ? std::string(key) : root.path() + "." + std::string(key);
    TableReader reader(*table, at, path, findings);
    read(reader);
    reader.RefuseOthers();
  }
}

// The same for each table of the array `key`.
template <typename Read>
void Each(TableReader& root, std::string_view key, Findings& findings, Read read) {
  if (!root.Has(key)) return;
  int number = 0;
  for (const Value* value : root.Tables(key)) {
    const std::string path = (root.path().empty() ? "" : root.path() + ".") + std::string(key) +
                             "[" + std::to_string(++number) + "]";
    TableReader reader(*value->As<Table>(), value->at, path, findings);
    read(reader);
    reader.RefuseOthers();
  }
}

std::optional<double> Coordinate(TableReader& reader, std::string_view key);
std::optional<double> Length(TableReader& reader, std::string_view key);
// From 0 on.
std::optional<double> Height(TableReader& reader, std::string_view key);
std::optional<double> Share(TableReader& reader, std::string_view key);
// In radians, of a key in degrees.
std::optional<double> Angle(TableReader& reader, std::string_view key, double least_deg = -360,
                            double most_deg = 360);
// Two numbers: a point, or the least and the most of something.
std::optional<Eigen::Vector2d> Pair(TableReader& reader, std::string_view key);
std::optional<std::vector<Eigen::Vector2d>> Points(TableReader& reader, std::string_view key);
// The same as two numbers, the second larger by at least `gap`.
std::optional<Eigen::Vector2d> Range(TableReader& reader, std::string_view key, double gap);
// x_m and y_m, both required.
Eigen::Vector2d Center(TableReader& reader);
std::string Name(TableReader& reader);
// The name of a topic; with a leading slash independent of the namespace.
std::optional<std::string> Topic(TableReader& reader, std::string_view key);
std::optional<Color> ReadColor(TableReader& reader, std::string_view key, Findings& findings);
// The absolute path of a readable picture; a relative path starts at `folder`.
std::optional<std::string> PictureFile(TableReader& reader, std::string_view key,
                                       const std::string& folder);

}  // namespace musher::world::keys
