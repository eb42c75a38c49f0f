#include "musher/modules/world/scene_file/scene_keys.hpp"

#include <cmath>
#include <utility>

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

Row Coordinate(std::string_view key, double& value_m) {
  return row::Number(key, value_m, -kFarthestM, kFarthestM);
}

Row Length(std::string_view key, double& value_m) {
  return row::Number(key, value_m, kSmallestM, kFarthestM);
}

Row Half(std::string_view key, double& half_m) {
  return row::Required(key, "a length in metres", [key, &half_m](TableReader& reader) {
    half_m = reader.Number(key, kSmallestM, kFarthestM).value_or(1) / 2;
  });
}

Row Height(std::string_view key, double& value_m) {
  return row::Number(key, value_m, 0, kFarthestM);
}

Row Share(std::string_view key, double& value) {
  return row::Number(key, value, 0, 1);
}

Row Angle(std::string_view key, double& value_rad, double least_deg, double most_deg) {
  return [=, &value_rad](TableReader& reader) {
    if (const auto degrees = reader.Number(key, least_deg, most_deg)) value_rad = Radians(*degrees);
  };
}

std::optional<Vector2d> ReadPoint(TableReader& reader, std::string_view key) {
  const Value* value = reader.Get(key);
  if (value == nullptr) return std::nullopt;
  auto pair = PairOf(*value);
  if (!pair) {
    reader.Fault(value->at, key, "expected two numbers from -1000 to 1000, as in [1.5, -2.0]");
  }
  return pair;
}

std::optional<std::vector<Vector2d>> ReadPoints(TableReader& reader, std::string_view key) {
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

Row Point(std::string_view key, Vector2d& point_m) {
  return [key, &point_m](TableReader& reader) { Set(point_m, ReadPoint(reader, key)); };
}

Row Range(std::string_view key, std::optional<Vector2d>& range, double gap) {
  return [key, &range, gap](TableReader& reader) {
    const auto read = ReadPoint(reader, key);
    if (!read) return;
    if (read->y() - read->x() >= gap) {
      range = read;
      return;
    }
    reader.Fault(reader.At(key), key,
                 gap >= 1 ? "expected [least, most], at least a metre apart"
                          : "expected [least, most], at least a centimetre apart");
  };
}

Row Center(Eigen::Ref<Vector2d> center_m) {
  return [center_m](TableReader& reader) mutable {
    center_m.setZero();
    for (const char* key : {"x_m", "y_m"}) reader.Require(key, "a position in metres");
    ReadSome(reader, {Coordinate("x_m", center_m.x()), Coordinate("y_m", center_m.y())});
  };
}

Row Topic(std::string_view key, std::string& topic) {
  return config_toml::row::Topic(key, topic, "/show/pose");
}

Row Colour(std::string_view key, Color& color, Findings& findings) {
  return [key, &color, &findings](TableReader& reader) {
    const auto word = reader.String(key);
    if (!word) return;
    if (const auto parsed = ParseColor(word->text)) {
      color = *parsed;
      return;
    }
    reader.Fault(word->at, key,
                 "expected a colour, \"#rrggbb\" or one of " + config_toml::Listing(ColorNames()) +
                     ", found " + config_toml::Quote(word->text) +
                     findings.Guess(word->text, ColorNames()));
  };
}

Row PictureFile(std::string_view key, std::string& path, const std::string& folder) {
  return [key, &path, &folder](TableReader& reader) {
    const auto word = reader.String(key);
    if (!word) return;
    std::string absolute = config_toml::Absolute(folder, word->text);
    const Result<> readable = CheckPicture(absolute);
    if (readable) {
      path = std::move(absolute);
      return;
    }
    reader.Fault(word->at, key,
                 "the picture " + config_toml::Quote(word->text) +
                     " cannot be shown: " + readable.error().message);
  };
}

}  // namespace musher::world::keys
