#include "musher/modules/wedding/faces.hpp"

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

Error Refusal(const std::string& why) {
  return {kCodeFailed, "faces: " + why};
}

}  // namespace

Result<Faces> ReadFaces(std::string_view json) {
  const Json document = Json::parse(json, nullptr, false);
  if (document.is_discarded()) return Refusal("that is no JSON");
  const auto list = document.is_object() ? document.find("faces") : document.end();
  if (!document.is_object() || list == document.end() || !list->is_array()) {
    return Refusal("an object with a list 'faces' is expected");
  }
  Faces faces{static_cast<int>(list->size()), -1};
  const auto count = document.find("count");
  if (count != document.end() && count->is_number_integer()) {
    const auto given = count->get<std::int64_t>();
    if (given < 0 || given > 1'000'000) return Refusal("a count of " + count->dump());
    faces.count = static_cast<int>(given);
  }
  double largest = -1;
  for (const Json& face : *list) {
    if (!face.is_object()) return Refusal("a face is an object");
    const auto frontal = face.find("is_frontal");
    if (frontal == face.end() || !frontal->is_boolean() || !frontal->get<bool>()) continue;
    const double area = Number(face, "area");
    if (area <= largest) continue;
    largest = area;
    const auto id = face.find("face_id");
    faces.largest_frontal = -1;
    if (id == face.end() || !id->is_number_integer()) continue;
    const auto given = id->get<std::int64_t>();
    if (given < -1 || given > std::numeric_limits<int>::max()) {
      return Refusal("a face_id of " + id->dump());
    }
    faces.largest_frontal = static_cast<int>(given);
  }
  return faces;
}

}  // namespace musher::wedding
