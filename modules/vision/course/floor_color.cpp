#include "musher/modules/vision/course/floor_color.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace musher::vision {
namespace {

constexpr int kLevels = 256;
// Between the saturations of floor and lines, at least: in levels of 255, and in spreads of the
// floor's own. Oak and tape differ by 45 under lamps of 3000 K, and by 100 in daylight.
constexpr double kLeastContrast = 24;
constexpr double kLeastSpreads = 2.5;
constexpr double kLittle = 0.5;          // of the greatest coverage
constexpr double kMostPaintSpread = 24;  // of the lines' own, in levels
constexpr double kMostSpread = 0.45;     // of a floor without their colour, see Spread()

struct Histogram {
  std::array<double, kLevels> count{};
  double all = 0;
};

Histogram HistogramOf(const cv::Mat& levels, const cv::Mat& mask) {
  Histogram histogram;
  for (int y = 0; y < levels.rows; ++y) {
    const auto* level = levels.ptr<std::uint8_t>(y);
    const auto* in = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < levels.cols; ++x) {
      if (in[x] != 0) histogram.count.at(level[x]) += 1;
    }
  }
  for (const double count : histogram.count) histogram.all += count;
  return histogram;
}

struct Class {
  double share = 0;
  double mean = 0;
  double spread = 0;  // standard deviation
};

Class ClassOf(const Histogram& histogram, int from, int to) {
  double count = 0, sum = 0, squares = 0;
  for (int i = from; i < to; ++i) {
    const double n = histogram.count.at(static_cast<std::size_t>(i));
    count += n;
    sum += n * i;
    squares += n * i * i;
  }
  if (count == 0) return {};
  const double mean = sum / count;
  return {count / histogram.all, mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

// The level that divides them best (Otsu): the variance between the two classes is greatest.
int BestThreshold(const Histogram& histogram) {
  double total = 0;
  for (int i = 0; i < kLevels; ++i) total += i * histogram.count.at(static_cast<std::size_t>(i));
  double below = 0, sum = 0, best = -1;
  int threshold = 0;
  for (int i = 1; i < kLevels; ++i) {
    const double n = histogram.count.at(static_cast<std::size_t>(i - 1));
    below += n;
    sum += n * (i - 1);
    const double above = histogram.all - below;
    if (below == 0 || above == 0) continue;
    const double between = below * above * std::pow(sum / below - (total - sum) / above, 2);
    if (between <= best) continue;
    best = between;
    threshold = i;
  }
  return threshold;
}

std::string FloorHasTheColor(double share, const std::string& of) {
  return "the floor has the colour of the lines: " +
         std::to_string(static_cast<int>(std::lround(100 * share))) + " % of " + of;
}

// The share of the floor's cells in which some of the mask is. Lines go through few of them.
double Spread(const cv::Mat& mask) {
  constexpr int kColumns = 12, kRows = 8;
  constexpr double kSome = 0.08 * 255;
  cv::Mat cells;
  cv::resize(mask, cells, {kColumns, kRows}, 0, 0, cv::INTER_AREA);
  return cv::countNonZero(cells > kSome) / double(cells.total());
}

cv::Mat SaturationOf(const cv::Mat& bgr) {
  constexpr int kNoisePx = 5;
  cv::Mat smooth, saturation;
  cv::GaussianBlur(bgr, smooth, {kNoisePx, kNoisePx}, 0);
  cv::cvtColor(smooth, smooth, cv::COLOR_BGR2HSV);
  cv::extractChannel(smooth, saturation, 1);
  return saturation;
}

}  // namespace

LineMask MaskOfLines(const cv::Mat& bgr, const HsvRange& yellow, double most_coverage,
                     const cv::Mat& floor) {
  LineMask lines{MaskOf(bgr, yellow), ""};
  const auto total = static_cast<double>(lines.mask.total());
  const double coverage = cv::countNonZero(lines.mask) / total;
  const double spread = floor.empty() ? 0 : Spread(MaskOf(floor, yellow));
  if (coverage <= most_coverage && spread <= kMostSpread) return lines;

  const cv::Mat saturation = SaturationOf(bgr);
  const Histogram histogram = HistogramOf(saturation, lines.mask);
  const int threshold = BestThreshold(histogram);
  const Class less = ClassOf(histogram, 0, threshold);
  const Class paint = ClassOf(histogram, threshold, kLevels);
  const double contrast = paint.mean - less.mean;
  const bool apart = less.share > 0 && paint.share > 0 && contrast >= kLeastContrast &&
                     contrast >= kLeastSpreads * less.spread &&
                     (floor.empty() || paint.spread <= kMostPaintSpread);
  // Little of the region has it: then the shapes of what has it decide.
  if (!apart && coverage <= kLittle * most_coverage) return lines;
  if (!apart || paint.share * coverage > most_coverage) {
    lines.mask.setTo(0);
    lines.doubt = coverage > most_coverage ? FloorHasTheColor(coverage, "the region")
                                           : FloorHasTheColor(spread, "the places below it");
    return lines;
  }
  lines.mask.setTo(0, saturation < threshold);
  return lines;
}

}  // namespace musher::vision
