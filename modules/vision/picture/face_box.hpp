#pragma once
// A face in a picture, as a detector finds it. Lengths are fractions of the picture's width and
// height, (0, 0) is its upper left corner.

#include <cmath>

namespace musher::vision {

struct FaceBox {
  double x = 0;  // of the upper left corner
  double y = 0;
  double width = 0;
  double height = 0;
  bool frontal = true;    // it looks towards the camera
  double confidence = 0;  // 0 to 1

  double center_x() const { return x + width / 2; }
  double center_y() const { return y + height / 2; }
  double area() const { return width * height; }

  friend bool operator==(const FaceBox&, const FaceBox&) = default;
};

// Intersection over union of two boxes: 0 to 1.
double Iou(const FaceBox& a, const FaceBox& b);

// Between their centres.
inline double Distance(const FaceBox& a, const FaceBox& b) {
  return std::hypot(a.center_x() - b.center_x(), a.center_y() - b.center_y());
}

// Finite numbers, a size, and a centre in the picture. A detector must not return anything else.
bool IsFace(const FaceBox& box);

}  // namespace musher::vision
