#include "musher/modules/vision/picture/face_box.hpp"

#include <algorithm>

namespace musher::vision {

double Iou(const FaceBox& a, const FaceBox& b) {
  const double width = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const double height = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  if (width <= 0 || height <= 0) return 0;
  const double common = width * height;
  return common / (a.area() + b.area() - common);
}

bool IsFace(const FaceBox& box) {
  const auto in_picture = [](double value) { return value >= 0 && value <= 1; };
  return box.width > 0 && box.height > 0 && box.width <= 1 && box.height <= 1 &&
         in_picture(box.center_x()) && in_picture(box.center_y()) && in_picture(box.confidence);
}

}  // namespace musher::vision
