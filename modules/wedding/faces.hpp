#pragma once
// Parses the face message, a JSON document: how many faces there are, and which one is the largest
// that looks at the robot.

#include <optional>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/modules/wedding/data/gaze.hpp"

namespace musher::wedding {

struct Faces {
  int count = 0;
  int largest_frontal = -1;  // its face_id, -1: none
  // The centre of the largest frontal one in the picture, 0 to 1; nothing: there is none, or the
  // message has no position.
  std::optional<Gaze> center;
  Duration stamp{};  // of the picture; zero: unknown

  friend bool operator==(const Faces&, const Faces&) = default;
};

// Missing fields of a face default to 0, false and -1, its centre to the centre of its box, `count`
// to the length of the list. A face without a stamp has the stamp of the message.
Result<Faces> ReadFaces(std::string_view json);

}  // namespace musher::wedding
