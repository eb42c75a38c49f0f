#include "musher/modules/world/picture/legend.hpp"

#include <chrono>
#include <cmath>
#include <map>
#include <string>

#include "musher/modules/world/paint/palette.hpp"
#include "musher/modules/world/picture/field_view.hpp"
#include "musher/modules/world/picture/fleet_view.hpp"
#include "musher/modules/world/picture/strip_chart.hpp"

namespace musher::world {
namespace {

// Seconds spent in each state, in the order they first came.
std::map<int, double> TimeInStates(const Track& track) {
  std::map<int, double> seconds;
  const std::vector<Sample>& samples = track.samples();
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    seconds[samples[i].machine_state] += ToSeconds(samples[i + 1].at - samples[i].at);
  }
  return seconds;
}

// Downwards, row by row.
class Legend {
 public:
  Legend(const World& world, const Pixel& corner, Canvas& canvas)
      : world_(world), track_(world.track()), at_(corner), canvas_(canvas) {}

  void Draw() {
    at_ = DrawFieldLegend(world_, at_, canvas_);
    if (!world_.scene().robots.empty()) at_ = DrawFleetLegend(world_, at_, canvas_);
    if (world_.scene().has_body) {
      Way();
      at_.y() += kRow / 2;
    }
    Place();
  }

 private:
  static constexpr double kRow = 24;
  static constexpr double kLetters = 12;

  void Title(const std::string& text) {
    canvas_.Text(text, at_, 13, kInk);
    at_.y() += kRow;
  }
  void Row(const std::string& text, const std::string& right = "") {
    canvas_.Text(text, at_ + Pixel(38, 0), kLetters, kInk);
    canvas_.Text(right, at_ + Pixel(200, 0), kLetters, kGreyInk, Align::kRight);
    at_.y() += kRow;
  }
  void Swatch(const Color& color) {
    canvas_.FillRect(at_ + Pixel(0, -9), at_ + Pixel(26, 1), color);
  }

  // The colours of the body's way.
  void Way() {
    if (world_.scene().picture.way == Picture::Way::kTime) {
      Title("The way, by time");
      const double end_s = ToSeconds(track_.samples().back().at);
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        Swatch(ColorOfTime(share));
        Row(ClockText(std::round(share * end_s)));
      }
    } else if (HasMachineState(track_)) {
      Title("The way, by machine state");
      for (const auto& [index, seconds] : TimeInStates(track_)) {
        const std::string& state = track_.states().at(static_cast<std::size_t>(index));
        if (state.empty() && seconds < 1) continue;
        Swatch(ColorOfState(state));
        Row(state.empty() ? "unknown" : state, ClockText(std::round(seconds)));
      }
    } else {
      Title("The way, by battery");
      for (const int percent : {100, 50, 20, 0}) {
        Swatch(ColorOfBattery(percent));
        Row(std::to_string(percent) + " %");
      }
    }
  }

  void Place() {
    if (world_.scene().has_body) {
      Title("The place");
      canvas_.Outline(
          {at_ + Pixel(4, -10), at_ + Pixel(22, -10), at_ + Pixel(22, 1), at_ + Pixel(4, 1)}, kInk,
          1.5);
      Row("where it began");
      canvas_.FillRect(at_ + Pixel(4, -10), at_ + Pixel(22, 1), kInk);
      Row("where it is");
    }
    if (!world_.scene().boxes.empty() || !world_.scene().circles.empty()) {
      Swatch(kObstacle);
      Row("obstacle");
    }
    if (!world_.scene().boards.empty()) {
      canvas_.Line(at_ + Pixel(2, -4), at_ + Pixel(24, -4), kBoard, 2.5);
      canvas_.Line(at_ + Pixel(13, -4), at_ + Pixel(13, 1), kBoard, 1.5);
      Row("board, its front");
    }
    if (!world_.scene().zones.empty()) {
      canvas_.FillRect(at_ + Pixel(0, -9), at_ + Pixel(26, 1), kZone);
      canvas_.Outline(
          {at_ + Pixel(0, -9), at_ + Pixel(26, -9), at_ + Pixel(26, 1), at_ + Pixel(0, 1)},
          kZoneEdge);
      Row("zone of the referee");
    }
    if (!world_.scene().pads.empty()) {
      Swatch(kPad);
      Row("charging pad");
    }
    if (world_.humanoid()) {
      Swatch(kSight);
      Row("what it can see");
    }
    if (!track_.bumps().empty()) {
      canvas_.Line(at_ + Pixel(8, -9), at_ + Pixel(18, 1), kBumpRed, 2);
      canvas_.Line(at_ + Pixel(8, 1), at_ + Pixel(18, -9), kBumpRed, 2);
      Row("bump", std::to_string(track_.bumps().size()));
    }
  }

  const World& world_;
  const Track& track_;
  Pixel at_;
  Canvas& canvas_;
};

}  // namespace

void DrawLegend(const World& world, const Pixel& corner, Canvas& canvas) {
  Legend(world, corner, canvas).Draw();
}

}  // namespace musher::world
