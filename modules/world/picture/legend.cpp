#include "musher/modules/world/picture/legend.hpp"

#include <chrono>
#include <cmath>
#include <map>
#include <string>

#include "musher/modules/world/paint/palette.hpp"
#include "musher/modules/world/picture/strip_chart.hpp"

namespace musher::world {
namespace {

// Seconds spent in each state, in the order they first came.
std::map<int, double> TimeInStates(const Track& track) {
  std::map<int, double> seconds;
  const std::vector<Sample>& samples = track.samples();
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    seconds[samples[i].machine_state] +=
        std::chrono::duration<double>(samples[i + 1].at - samples[i].at).count();
  }
  return seconds;
}

}  // namespace

void DrawLegend(const World& world, const Pixel& corner, Canvas& canvas) {
  constexpr double kRow = 24;
  constexpr double kLetters = 12;
  const Track& track = world.track();
  Pixel at = corner;
  const auto title = [&](const std::string& text) {
    canvas.Text(text, at, 13, kInk);
    at.y() += kRow;
  };
  const auto row = [&](const std::string& text, const std::string& right = "") {
    canvas.Text(text, at + Pixel(38, 0), kLetters, kInk);
    canvas.Text(right, at + Pixel(200, 0), kLetters, kGreyInk, Align::kRight);
    at.y() += kRow;
  };
  const auto swatch = [&](const Color& color) {
    canvas.FillRect(at + Pixel(0, -9), at + Pixel(26, 1), color);
  };
  if (world.scene().picture.way == Picture::Way::kTime) {
    title("The way, by time");
    const double end_s = std::chrono::duration<double>(track.samples().back().at).count();
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      swatch(ColorOfTime(share));
      row(ClockText(std::round(share * end_s)));
    }
  } else if (HasMachineState(track)) {
    title("The way, by machine state");
    for (const auto& [index, seconds] : TimeInStates(track)) {
      const std::string& state = track.states().at(static_cast<std::size_t>(index));
      if (state.empty() && seconds < 1) continue;
      swatch(ColorOfState(state));
      row(state.empty() ? "unknown" : state, ClockText(std::round(seconds)));
    }
  } else {
    title("The way, by battery");
    for (const int percent : {100, 50, 20, 0}) {
      swatch(ColorOfBattery(percent));
      row(std::to_string(percent) + " %");
    }
  }
  at.y() += kRow / 2;
  title("The place");
  canvas.Outline({at + Pixel(4, -10), at + Pixel(22, -10), at + Pixel(22, 1), at + Pixel(4, 1)},
                 kInk, 1.5);
  row("where it began");
  canvas.FillRect(at + Pixel(4, -10), at + Pixel(22, 1), kInk);
  row("where it is");
  if (!world.scene().boxes.empty() || !world.scene().circles.empty()) {
    swatch(kObstacle);
    row("obstacle");
  }
  if (!world.scene().boards.empty()) {
    canvas.Line(at + Pixel(2, -4), at + Pixel(24, -4), kBoard, 2.5);
    canvas.Line(at + Pixel(13, -4), at + Pixel(13, 1), kBoard, 1.5);
    row("board, its front");
  }
  if (!world.scene().zones.empty()) {
    canvas.FillRect(at + Pixel(0, -9), at + Pixel(26, 1), kZone);
    canvas.Outline({at + Pixel(0, -9), at + Pixel(26, -9), at + Pixel(26, 1), at + Pixel(0, 1)},
                   kZoneEdge);
    row("zone of the referee");
  }
  if (!world.scene().pads.empty()) {
    swatch(kPad);
    row("charging pad");
  }
  if (world.humanoid()) {
    swatch(kSight);
    row("what it can see");
  }
  if (!track.bumps().empty()) {
    canvas.Line(at + Pixel(8, -9), at + Pixel(18, 1), kBumpRed, 2);
    canvas.Line(at + Pixel(8, 1), at + Pixel(18, -9), kBumpRed, 2);
    row("bump", std::to_string(track.bumps().size()));
  }
}

}  // namespace musher::world
