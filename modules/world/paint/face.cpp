#include "musher/modules/world/paint/face.hpp"

#include <cmath>
#include <iterator>

namespace musher::world {
namespace {

using Eigen::Vector2d;

constexpr Color kSkins[] = {{236, 198, 170}, {222, 176, 142}, {198, 150, 116}, {240, 208, 184}};
constexpr Color kHairs[] = {
    {40, 32, 28}, {92, 62, 38}, {150, 108, 58}, {64, 46, 40}, {110, 110, 112}};
constexpr Color kShirts[] = {
    {60, 86, 140}, {150, 52, 60}, {58, 120, 92}, {214, 196, 160}, {90, 70, 120}};
constexpr Color kIrises[] = {{70, 52, 38}, {60, 90, 120}, {70, 100, 70}};
constexpr Color kBlack{22, 20, 20};
constexpr Color kWhite{240, 238, 234};

template <std::size_t N>
const Color& Pick(const Color (&colors)[N], int number) {
  return colors[static_cast<std::size_t>(number) % N];
}

// In units of the face's half width, from the middle between the eyes.
class Face {
 public:
  Face(int number, double unit_px, const Vector2d& middle_px, Canvas& canvas)
      : canvas_(canvas),
        unit_(unit_px),
        middle_(middle_px),
        number_(number),
        skin_(SkinOf(number)),
        hair_(HairOf(number)) {}

  void Draw() {
    Body();
    Hair();
    DrawHead();
  }
  void DrawHead() {
    Skin();
    for (const int side : {-1, 1}) Eye(side);
    Nose();
    Mouth();
  }

 private:
  void Spot(const Vector2d& at, const Vector2d& radii, const Color& color, double solid = 0.96,
            double share = 1) {
    canvas_.Glow(middle_ + at * unit_, radii * unit_, color, solid, share);
  }
  Color Dark(double share) const { return Mix(skin_, {96, 56, 44}, share); }
  Color Bright(double share) const { return Mix(skin_, {255, 246, 236}, share); }

  void Body() {
    Spot({0, 3.3}, {1.75, 1.25}, Pick(kShirts, number_ * 2 + 1), 0.97);
    Spot({0, 1.75}, {0.52, 0.95}, Dark(0.25), 0.9);
  }
  void Hair() {
    Spot({0, -0.35}, {1.14, 1.28}, hair_, 0.95);
    if (!HasLongHair(number_)) return;
    for (const int side : {-1, 1}) Spot({0.86 * side, 0.7}, {0.42, 1.5}, hair_, 0.85);
  }
  void Skin() {
    for (const int side : {-1, 1}) Spot({1.0 * side, 0.22}, {0.14, 0.3}, Dark(0.2));
    Spot({0, 0.25}, {1.0, 1.38}, Dark(0.28), 0.95);
    Spot({0, 0.22}, {0.96, 1.32}, skin_, 0.72);
    Spot({0, -0.5}, {0.62, 0.3}, Bright(0.45), 0.2);  // forehead
    for (const int side : {-1, 1})
      Spot({0.5 * side, 0.5}, {0.36, 0.3}, Bright(0.5), 0.2);  // cheeks
    Spot({0, 1.28}, {0.3, 0.2}, Bright(0.3), 0.1);             // chin
    if (number_ % 3 == 0) return;
    Spot({0, -1.0}, {0.86, 0.36}, hair_, 0.85);  // a fringe
  }
  void Eye(int side) {
    const double x = 0.42 * side;
    Spot({x, -0.04}, {0.34, 0.24}, Dark(0.55), 0.1, 0.9);  // the socket's shade
    Spot({x, -0.27}, {0.3, 0.075}, Mix(hair_, kBlack, 0.4), 0.6);
    Spot({x, 0.0}, {0.22, 0.105}, Dark(0.8), 0.85);
    Spot({x, 0.012}, {0.19, 0.085}, kWhite, 0.9);
    Spot({x, 0.0}, {0.095, 0.1}, Pick(kIrises, number_ + number_ / 3), 0.9);
    Spot({x, 0.0}, {0.05, 0.055}, kBlack, 0.9);
    Spot({x, -0.075}, {0.22, 0.04}, kBlack, 0.4);  // lashes
    Spot({x + 0.03, -0.03}, {0.02, 0.02}, kWhite);
  }
  void Nose() {
    Spot({0, 0.2}, {0.11, 0.5}, Bright(0.6), 0.2, 0.9);
    Spot({0, 0.58}, {0.22, 0.1}, Dark(0.35), 0.2, 0.8);
    Spot({0, 0.5}, {0.12, 0.1}, Bright(0.5), 0.3);
    for (const int side : {-1, 1}) Spot({0.1 * side, 0.6}, {0.055, 0.035}, Dark(0.9), 0.5);
  }
  void Mouth() {
    const Color lips = Mix({176, 72, 74}, skin_, number_ % 2 == 0 ? 0.35 : 0.0);
    Spot({0, 0.93}, {0.38, 0.12}, lips, 0.75);
    Spot({0, 0.915}, {0.34, 0.03}, Mix(lips, kBlack, 0.6), 0.5);
    Spot({0, 1.09}, {0.24, 0.06}, Dark(0.4), 0.1, 0.8);
  }

  Canvas& canvas_;
  const double unit_;
  const Vector2d middle_;
  const int number_;
  const Color skin_;
  const Color hair_;
};

}  // namespace

void DrawFace(int number, double width, double height, Canvas& canvas) {
  Face(number, std::min(width / 3.4, height / 4.0), {width / 2, height * 0.44}, canvas).Draw();
}

void DrawHead(int number, double width, double height, Canvas& canvas) {
  constexpr double kHalfWidth = 1.14;  // of the hair
  Face(number, width / 2 / kHalfWidth, {width / 2, height / 2}, canvas).DrawHead();
}

Color SkinOf(int number) {
  return Pick(kSkins, number);
}

Color HairOf(int number) {
  return Pick(kHairs, number * 3 + number / 4);
}

bool HasLongHair(int number) {
  return number % 2 == 1;
}

}  // namespace musher::world
