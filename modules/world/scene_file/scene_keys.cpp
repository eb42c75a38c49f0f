#include "musher/modules/world/scene_file/scene_keys.hpp"

#include <cmath>

#include "musher/base/toml/names.hpp"
#include "musher/modules/world/scene_file/picture_file.hpp"

namespace musher::world::keys {
namespace {

using config_toml::Array;
using Eigen::Vector2d;

constexpr std::size_t kMostPoints = 10'000;

std::optional<Vector2d> PairOf(const Value& value) {
  const auto* array = value.As<Array>();
  if (array == nullptr || array->size() != 2) return std::nullopt;
  Vector2d pair;
  for (const int i : {0, 1}) {
    const Value& item = array->at(static_cast<std::size_t>(i));
    const auto* integer = item.As<std::int64_t>();
    const auto* number = item.As<double>();
    if (integer == nullptr && number == nullptr) return std::nullopt;
    pair[i] = number != nullptr ? *number : static_cast<double>(*integer);
    if (!(std::abs(pair[i]) <= kFarthestM)) return std::nullopt;  // nan, too
  }
  return pair;
}

}  // namespace

double Radians(double degrees) {
  return std::remainder(degrees, 360) * M_PI / 180;
}

std::optional<double> Coordinate(TableReader& reader, std::string_view key) {
  return reader.Number(key, -kFarthestM, kFarthestM);
}

std::optional<double> Length(TableReader& reader, std::string_view key) {
  return reader.Number(key, kSmallestM, kFarthestM);
}

std::optional<double> Height(TableReader& reader, std::string_view key) {
  return reader.Number(key, 0, kFarthestM);
}

std::optional<double> Share(TableReader& reader, std::string_view key) {
  return reader.Number(key, 0, 1);
}

std::optional<double> Angle(TableReader& reader, std::string_view key, double least_deg,
                            double most_deg) {
  const auto degrees = reader.Number(key, least_deg, most_deg);
  if (!degrees) return std::nullopt;
  return Radians(*degrees);
}

std::optional<Vector2d> Pair(TableReader& reader, std::string_view key) {
  const Value* value = reader.Get(key);
  if (value == nullptr) return std::nullopt;
  auto pair = PairOf(*value);
  if (!pair) {
    reader.Fault(value->at, key, "expected two numbers from -1000 to 1000, as in [1.5, -2.0]");
  }
  return pair;
}

std::optional<std::vector<Vector2d>> Points(TableReader& reader, std::string_view key) {
  const Value* value = reader.Get(key);
  if (value == nullptr) return std::nullopt;
  const auto* array = value->As<Array>();
  std::vector<Vector2d> points;
  bool good = array != nullptr && array->size() >= 2 && array->size() <= kMostPoints;
  for (std::size_t i = 0; good && i < array->size(); ++i) {
    const auto point = PairOf(array->at(i));
    good = point.has_value();
    if (good) points.push_back(*point);
  }
  if (good) return points;
  reader.Fault(value->at, key,
               "expected two points or more of numbers from -1000 to 1000, as in "
               "[[0, 0], [1.5, -2.0]]");
  return std::nullopt;
}

std::optional<Vector2d> Range(TableReader& reader, std::string_view key, double gap) {
  auto range = Pair(reader, key);
  if (!range) return std::nullopt;
  if (range->y() - range->x() >= gap) return range;
  reader.Fault(reader.At(key), key,
               gap >= 1 ? "expected [least, most], at least a metre apart"
                        : "expected [least, most], at least a centimetre apart");
  return std::nullopt;
}

Vector2d Center(TableReader& reader) {
  for (const char* key : {"x_m", "y_m"}) reader.Require(key, "a position in metres");
  const double x = Coordinate(reader, "x_m").value_or(0);
  return {x, Coordinate(reader, "y_m").value_or(0)};
}

std::string Name(TableReader& reader) {
  const auto name = reader.String("name");
  return name ? name->text : "";
}

std::optional<std::string> Topic(TableReader& reader, std::string_view key) {
  const auto word = reader.String(key);
  if (!word) return std::nullopt;
  if (config_toml::IsTopic(word->text)) return word->text;
  reader.Fault(word->at, key,
               "expected a topic, as in \"/show/pose\", found " + config_toml::Quote(word->text));
  return std::nullopt;
}

std::optional<Color> ReadColor(TableReader& reader, std::string_view key, Findings& findings) {
  const auto word = reader.String(key);
  if (!word) return std::nullopt;
  const auto color = ParseColor(word->text);
  if (!color) {
    reader.Fault(word->at, key,
                 "expected a colour, \"#rrggbb\" or one of " + config_toml::Listing(ColorNames()) +
                     ", found " + config_toml::Quote(word->text) +
                     findings.Guess(word->text, ColorNames()));
  }
  return color;
}

std::optional<std::string> PictureFile(TableReader& reader, std::string_view key,
                                       const std::string& folder) {
  const auto word = reader.String(key);
  if (!word) return std::nullopt;
  std::string path = config_toml::Absolute(folder, word->text);
  const Result<> readable = CheckPicture(path);
  if (readable) return path;
  reader.Fault(word->at, key,
               "the picture " + config_toml::Quote(word->text) +
                   " cannot be shown: " + readable.error().message);
  return std::nullopt;
}

}  // namespace musher::world::keys
