#include "musher/modules/world/picture.hpp"

#include <cmath>
#include <cstdio>
#include <exception>

#include "musher/modules/world/palette.hpp"
#include "musher/modules/world/strip_chart.hpp"
#include "musher/modules/world/top_view.hpp"

namespace musher::world {
namespace {

// Along the way, without what it was carried.
double WalkedM(const Track& track) {
  double walked_m = 0;
  const std::vector<Sample>& samples = track.samples();
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double seconds = std::chrono::duration<double>(samples[i].at - samples[i - 1].at).count();
    const double way_m = (samples[i].pose.position_m - samples[i - 1].pose.position_m).norm();
    if (way_m <= 0.3 + 2 * seconds) walked_m += way_m;
  }
  return walked_m;
}

Result<> DrawAll(const World& world, const std::string& path) {
  constexpr double kMargin = 36;
  constexpr double kMapBottom = 660;
  constexpr double kLegend = 900;  // begins there at the latest
  constexpr double kLeft = kMargin + kChartNames;
  Canvas canvas(kPictureWidth, kPictureHeight, kPaper);
  canvas.Text(world.scene().name, {kLeft, 42}, 22, kInk);
  char facts[160];
  std::snprintf(facts, sizeof(facts), "%s of world time    %.1f m walked    battery %.0f %%",
                ClockText(std::floor(std::chrono::duration<double>(world.now()).count())).c_str(),
                WalkedM(world.track()), world.battery().percent());
  canvas.Text(facts, {kPictureWidth - kMargin, 42}, 13, kGreyInk, Align::kRight);
  const double right = DrawTopView(world, {kLeft, 74}, {kLegend - 44, kMapBottom}, canvas);
  DrawLegend(world, {right + 44, 92}, canvas);
  DrawStripChart(world.track(), {kMargin, kMapBottom + 30},
                 {kPictureWidth - kMargin, kPictureHeight - 24.0}, canvas);
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
