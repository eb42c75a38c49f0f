#pragma once
// Faces of people who do not exist, for guests and posters: from the front, drawn so that usual
// detectors find them.

#include "musher/modules/world/canvas.hpp"

namespace musher::world {

// Head and shoulders on all of a canvas of that size. The same number is the same face; neighbours
// look different.
void DrawFace(int number, double width, double height, Canvas& canvas);

// The head alone, from the top of its hair to its chin, on a canvas of its hair's colour.
void DrawHead(int number, double width, double height, Canvas& canvas);

Color SkinOf(int number);
Color HairOf(int number);
bool HasLongHair(int number);

}  // namespace musher::world
