#pragma once
// The text of faces_json: {"faces": [...], "count": 1, "timestamp": 12.5}. Pure.

#include <string>

#include "musher/modules/vision/faces/face_watch.hpp"

namespace musher::vision {

// Each face has x, y, width, height, area, center_x, center_y (of the picture, 0 to 1), is_frontal,
// yaw, pitch, roll (degrees), confidence (0 to 1), face_id, timestamp (s), and distance (m) where
// the lens is known.
std::string FacesJson(const Sight& sight);

}  // namespace musher::vision
