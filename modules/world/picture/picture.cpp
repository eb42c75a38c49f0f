#include "musher/modules/world/picture/picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>

#include "musher/modules/world/paint/palette.hpp"
#include "musher/modules/world/picture/field_view.hpp"
#include "musher/modules/world/picture/legend.hpp"
#include "musher/modules/world/picture/strip_chart.hpp"
#include "musher/modules/world/picture/top_view.hpp"

namespace musher::world {
namespace {

// Length of the path, without being carried.
double WalkedM(const Track& track) {
  double walked_m = 0;
  const std::vector<Sample>& samples = track.samples();
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double seconds = ToSeconds(samples[i].at - samples[i - 1].at);
    const double way_m = (samples[i].pose.position_m - samples[i - 1].pose.position_m).norm();
    if (way_m <= 0.3 + 2 * seconds) walked_m += way_m;
  }
  return walked_m;
}

constexpr double kMargin = 36;
constexpr double kLeft = kMargin + kChartNames;
constexpr double kRight = kPictureWidth - kMargin;
constexpr double kMapTop = 74;
constexpr double kMapRight = 856;  // the legend stands beyond
constexpr double kChartHeight = 300;
constexpr double kBatteriesHeight = 200;  // without the rows of the body

// Only as high as the place and the legend need.
double MapBottom(const Scene& scene) {
  constexpr double kHighest = kPictureHeight - kChartHeight;
  constexpr double kLeast = 480;
  const Eigen::Vector2d size = scene.most_m - scene.least_m;
  const double height = size.y() * (kMapRight - kLeft) / size.x() + kMapAxis;
  return std::round(std::clamp(kMapTop + height, kLeast, kHighest));
}

std::string Facts(const World& world) {
  char facts[160];
  const double now_s = std::floor(ToSeconds(world.now()));
  if (world.scene().has_body) {
    std::snprintf(facts, sizeof(facts), "%s of world time    %.1f m walked    battery %.0f %%",
                  ClockText(now_s).c_str(), WalkedM(world.track()), world.battery().percent());
  } else if (world.field()) {
    const LiftBody& robot = world.field()->robot();
    std::snprintf(facts, sizeof(facts), "%s of world time    side %s    %d bumps    %d falls",
                  ClockText(now_s).c_str(), world.field()->spec().side.c_str(), robot.bumps(),
                  robot.falls());
  } else {
    std::snprintf(facts, sizeof(facts), "%s of world time    %zu robots", ClockText(now_s).c_str(),
                  world.scene().robots.size());
  }
  return facts;
}

Result<> DrawAll(const World& world, const std::string& path) {
  const double map_bottom = MapBottom(world.scene());
  const double height = map_bottom + (world.scene().has_body ? kChartHeight : kBatteriesHeight);
  Canvas canvas(kPictureWidth, static_cast<int>(height), kPaper);
  canvas.Text(world.scene().name, {kLeft, 42}, 22, kInk);
  canvas.Text(Facts(world), {kRight, 42}, 13, kGreyInk, Align::kRight);
  const double right = DrawTopView(world, {kLeft, kMapTop}, {kMapRight, map_bottom}, canvas);
  DrawLegend(world, {right + 44, kMapTop + 18}, canvas);
  const Pixel chart(kMargin, map_bottom + 30);
  if (world.scene().has_body) {
    DrawStripChart(world.track(), chart, {kRight, height - 24}, canvas);
  } else if (!world.scene().robots.empty()) {
    DrawBatteryChart(world, chart, {kRight, height - 24}, canvas);
  } else {
    DrawHeightChart(world, chart, {kRight, height - 24}, canvas);
  }
  return canvas.Save(path);
}

}  // namespace

Result<> Draw(const World& world, const std::string& path) {
  try {
    return DrawAll(world, path);
  } catch (const std::exception& error) {  // OpenCV's, out of memory
    return Error{kCodeFailed, std::string("the picture could not be drawn: ") + error.what()};
  }
}

}  // namespace musher::world
