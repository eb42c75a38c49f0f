#pragma once
// Frontal faces of people who do not exist, for guests and posters: drawn so that common detectors
// find them.

#include "musher/modules/world/paint/canvas.hpp"

namespace musher::world {

// Head and shoulders that fill a canvas of that size. The same number is the same face; successive
// numbers look different.
void DrawFace(int number, double width, double height, Canvas& canvas);

// The head alone, from the top of its hair to its chin, on a canvas of its hair's colour.
void DrawHead(int number, double width, double height, Canvas& canvas);

Color SkinOf(int number);
Color HairOf(int number);
bool HasLongHair(int number);

}  // namespace musher::world
