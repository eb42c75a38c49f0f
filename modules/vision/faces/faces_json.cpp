#include "musher/modules/vision/faces/faces_json.hpp"

#include <nlohmann/json.hpp>

namespace musher::vision {

std::string FacesJson(const Sight& sight) {
  using OrderedJson = nlohmann::ordered_json;
  const double timestamp_s = static_cast<double>(sight.stamp_ns) / 1e9;
  OrderedJson faces = OrderedJson::array();
  for (const auto& [id, box, distance_m] : sight.faces) {
    OrderedJson face = {{"x", box.x},
                        {"y", box.y},
                        {"width", box.width},
                        {"height", box.height},
                        {"area", box.area()},
                        {"center_x", box.center_x()},
                        {"center_y", box.center_y()},
                        {"is_frontal", box.frontal},
                        {"yaw", 0.0},  // a cascade does not measure angles
                        {"pitch", 0.0},
                        {"roll", 0.0},
                        {"confidence", box.confidence},
                        {"face_id", id},
                        {"timestamp", timestamp_s}};
    if (distance_m) face["distance"] = *distance_m;
    faces.push_back(std::move(face));
  }
  const OrderedJson all = {{"faces", faces}, {"count", faces.size()}, {"timestamp", timestamp_s}};
  return all.dump();
}

}  // namespace musher::vision
