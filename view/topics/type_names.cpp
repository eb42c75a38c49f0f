#include "musher/view/topics/type_names.hpp"

namespace musher::view {

std::string RosType(std::string_view dds_type) {
  constexpr std::string_view kMiddle = "::dds_::";
  const std::size_t kind = dds_type.find("::");
  const std::size_t middle = dds_type.find(kMiddle);
  if (kind == std::string_view::npos || middle == std::string_view::npos || kind >= middle) {
    return "";
  }
  std::string_view name = dds_type.substr(middle + kMiddle.size());
  if (name.size() < 2 || !name.ends_with('_')) return "";
  name.remove_suffix(1);
  return std::string(dds_type.substr(0, kind)) + "/" +
         std::string(dds_type.substr(kind + 2, middle - kind - 2)) + "/" + std::string(name);
}

std::string DdsType(std::string_view ros_type) {
  const std::size_t first = ros_type.find('/');
  const std::size_t last = ros_type.rfind('/');
  if (first == std::string_view::npos || first == last || first == 0 ||
      last + 1 == ros_type.size()) {
    return "";
  }
  return std::string(ros_type.substr(0, first)) +
         "::" + std::string(ros_type.substr(first + 1, last - first - 1)) +
         "::dds_::" + std::string(ros_type.substr(last + 1)) + "_";
}

}  // namespace musher::view
