#pragma once
// Rows of values that occur in many places of a scene file. A variable keeps its value where its
// key is missing or wrong, as with those of rows.hpp.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/rows.hpp"
#include "musher/modules/world/scene/color.hpp"

namespace musher::world::keys {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Rows;
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

// Calls `read` with each table of the array `key`, whose name in messages has its number, and
// refuses the keys that were not read.
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

// Reads rows whose keys are only a part of the table's.
inline void ReadSome(TableReader& reader, const Rows& rows) {
  for (const Row& row : rows) row(reader);
}

Row Coordinate(std::string_view key, double& value_m);
Row Length(std::string_view key, double& value_m);
// Half of a length that has to be there.
Row Half(std::string_view key, double& half_m);
// From 0 on.
Row Height(std::string_view key, double& value_m);
Row Share(std::string_view key, double& value);
// In radians, of a key in degrees; a whole turn more or less is the same.
Row Angle(std::string_view key, double& value_rad, double least_deg = -360, double most_deg = 360);
// Two numbers.
Row Point(std::string_view key, Eigen::Vector2d& point_m);
// The least and the most of something, at least `gap` apart.
Row Range(std::string_view key, std::optional<Eigen::Vector2d>& range, double gap);
// x_m and y_m, both required.
Row Center(Eigen::Ref<Eigen::Vector2d> center_m);
// The name of a topic; with a leading slash independent of the namespace.
Row Topic(std::string_view key, std::string& topic);
Row Colour(std::string_view key, Color& color, Findings& findings);
// The absolute path of a readable picture; a relative path starts at `folder`.
Row PictureFile(std::string_view key, std::string& path, const std::string& folder);

std::optional<Eigen::Vector2d> ReadPoint(TableReader& reader, std::string_view key);
std::optional<std::vector<Eigen::Vector2d>> ReadPoints(TableReader& reader, std::string_view key);

}  // namespace musher::world::keys
