#include "musher/modules/world/paint/palette.hpp"

#include <algorithm>
#include <utility>

namespace musher::world {
namespace {

constexpr Color kUnknown{176, 180, 186};
constexpr Color kFull{46, 160, 92};
constexpr Color kHalf{236, 176, 46};
constexpr Color kEmpty{206, 52, 48};

const std::pair<const char*, Color> kStates[] = {
    {"Active", {46, 150, 88}},     {"Protected", {240, 164, 32}}, {"LowPower", {66, 122, 196}},
    {"DeActive", {146, 152, 162}}, {"OTA", {140, 90, 180}},       {"Error", {206, 52, 48}},
    {"SelfCheck", {44, 168, 172}}, {"SetUp", {190, 214, 222}},    {"TearDown", {70, 76, 86}},
};

const std::pair<const char*, Color> kMotionColors[] = {
    {"off", {206, 52, 48}},    {"lie", {168, 186, 214}},   {"stand", {150, 204, 168}},
    {"walk", {58, 150, 120}},  {"pose", {196, 176, 120}},  {"jump", {232, 140, 60}},
    {"flip", {214, 100, 140}}, {"dance", {150, 110, 190}}, {"show", {170, 140, 200}},
};

// Colours for states added by a config.
constexpr Color kOthers[] = {{0, 140, 160}, {180, 110, 60}, {110, 130, 40}, {170, 70, 120}};

}  // namespace

Color ColorOfState(const std::string& state) {
  if (state.empty() || state == "Uninitialized") return kUnknown;
  for (const auto& [name, color] : kStates) {
    if (state == name) return color;
  }
  unsigned sum = 0;
  for (const char letter : state) sum = sum * 31 + static_cast<unsigned char>(letter);
  return kOthers[sum % std::size(kOthers)];
}

Color ColorOfBattery(double percent) {
  return percent < 50 ? Mix(kEmpty, kHalf, percent / 50) : Mix(kHalf, kFull, percent / 50 - 1);
}

Color ColorOfTime(double share) {
  constexpr Color kStops[] = {
      {44, 80, 190}, {24, 150, 190}, {52, 158, 84}, {226, 140, 30}, {200, 36, 60}};
  constexpr double kParts = 4;
  const double at = std::clamp(share, 0.0, 1.0) * kParts;
  const auto part = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(kParts) - 1);
  return Mix(kStops[part], kStops[part + 1], at - static_cast<double>(part));
}

Color ColorOfMotion(const std::string& motion) {
  for (const auto& [name, color] : kMotionColors) {
    if (motion == name) return color;
  }
  return kUnknown;
}

Color InkOn(const Color& background) {
  const int light = 3 * background.red + 6 * background.green + background.blue;
  return light > 1500 ? kInk : kPaper;
}

bool HasMachineState(const Track& track) {
  return std::any_of(track.states().begin(), track.states().end(),
                     [](const std::string& state) { return !state.empty(); });
}

Color ColorOfWay(const Track& track, const Sample& sample) {
  return HasMachineState(track) ? ColorOfState(track.states().at(sample.machine_state))
                                : ColorOfBattery(sample.battery_percent);
}

}  // namespace musher::world
