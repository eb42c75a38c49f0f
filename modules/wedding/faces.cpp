#include "musher/modules/wedding/faces.hpp"

#include <chrono>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

namespace musher::wedding {
namespace {

using Json = nlohmann::json;

double Number(const Json& face, const char* key) {
  const auto found = face.find(key);
  return found != face.end() && found->is_number() ? found->get<double>() : 0;
}

// The centre of the box if the face has none of its own; nothing without either.
std::optional<double> Center(const Json& face, const char* center, const char* edge,
                             const char* size) {
  if (face.contains(center)) return Number(face, center);
  if (face.contains(edge)) return Number(face, edge) + Number(face, size) / 2;
  return std::nullopt;
}

// Seconds since 1970, or since the simulation began. Zero for an impossible time.
Duration StampOf(const Json& object) {
  constexpr double kLatest = 4e9;
  const double seconds = Number(object, "timestamp");
  if (!(seconds > 0 && seconds < kLatest)) return {};
  return FromSeconds(seconds);
}

Error InvalidFaces(const std::string& why) {
  return {kCodeFailed, "faces: " + why};
}

}  // namespace

Result<Faces> ReadFaces(std::string_view json) {
  const Json document = Json::parse(json, nullptr, false);
  if (document.is_discarded()) return InvalidFaces("that is no JSON");
  const auto list = document.is_object() ? document.find("faces") : document.end();
  if (!document.is_object() || list == document.end() || !list->is_array()) {
    return InvalidFaces("an object with a list 'faces' is expected");
  }
  Faces faces;
  faces.count = static_cast<int>(list->size());
  const auto count = document.find("count");
  if (count != document.end() && count->is_number_integer()) {
    const auto given = count->get<std::int64_t>();
    if (given < 0 || given > 1'000'000) return InvalidFaces("a count of " + count->dump());
    faces.count = static_cast<int>(given);
  }
  double largest = -1;
  for (const Json& face : *list) {
    if (!face.is_object()) return InvalidFaces("a face is an object");
    const auto frontal = face.find("is_frontal");
    if (frontal == face.end() || !frontal->is_boolean() || !frontal->get<bool>()) continue;
    const double area = Number(face, "area");
    if (area <= largest) continue;
    largest = area;
    faces.center.reset();
    const auto x = Center(face, "center_x", "x", "width");
    const auto y = Center(face, "center_y", "y", "height");
    if (x && y) {
      if (!IsInUnitRange(*x) || !IsInUnitRange(*y)) {
        return InvalidFaces("a centre of (" + std::to_string(*x) + ", " + std::to_string(*y) +
                            ") is not in the picture: x and y are 0 to 1");
      }
      faces.center = Gaze{*x, *y};
    }
    faces.stamp = face.contains("timestamp") ? StampOf(face) : StampOf(document);
    const auto id = face.find("face_id");
    faces.largest_frontal = -1;
    if (id == face.end() || !id->is_number_integer()) continue;
    const auto given = id->get<std::int64_t>();
    if (given < -1 || given > std::numeric_limits<int>::max()) {
      return InvalidFaces("a face_id of " + id->dump());
    }
    faces.largest_frontal = static_cast<int>(given);
  }
  return faces;
}

}  // namespace musher::wedding
