#pragma once
// What is understood of the face message, a JSON document: how many there are, and which one is the
// largest that looks at the robot.

#include <string_view>

#include "musher/lifecycle/result.hpp"

namespace musher::wedding {

struct Faces {
  int count = 0;
  int largest_frontal = -1;  // its face_id, -1: none

  friend bool operator==(const Faces&, const Faces&) = default;
};

// Fields that a face does not have count as 0, false and -1; `count` as the length of the list.
Result<Faces> ReadFaces(std::string_view json);

}  // namespace musher::wedding
