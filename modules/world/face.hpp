#pragma once
// Faces of people who do not exist, for guests and posters: from the front, drawn so that usual
// detectors find them.

#include "musher/modules/world/canvas.hpp"

namespace musher::world {

// On all of a canvas of that size. The same number is the same face; neighbours look different.
void DrawFace(int number, double width, double height, Canvas& canvas);

}  // namespace musher::world
