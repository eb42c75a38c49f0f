#include "musher/modules/vision/course/marker_finder.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "musher/modules/vision/course/floor_color.hpp"
#include "musher/modules/vision/course/lamp_glow.hpp"
#include "musher/modules/vision/course/thing_surface.hpp"

namespace musher::vision {
namespace {

constexpr double kLeastConvex = 0.9;  // of its hull: no dents
// Of the rectangle around it: a circle fills pi / 4 of it, a square all.
constexpr double kCircle = M_PI / 4;
constexpr double kCircleTolerance = 0.08;
constexpr double kLeastSquare = 0.88;

// Whether what WithoutThinParts() leaves of it is certainly too long for its area, by a coarse
// distance that takes a fraction of the time of the precise one: a line on the ground.
bool IsLong(const cv::Mat& thing, const MarkerParameters& parameters) {
  constexpr double kCoarse = 0.03;  // at most: its error, as a share
  cv::Mat depth;
  cv::distanceTransform(thing, depth, cv::DIST_L2, cv::DIST_MASK_5);
  double deepest = 0;
  cv::minMaxLoc(depth, nullptr, &deepest);
  const int most_core_px = std::max(1, static_cast<int>(deepest / (1 - kCoarse)) / 2);
  const cv::Rect core = cv::boundingRect(depth > most_core_px * (1 + kCoarse));
  // The rectangle around what is left is at least as long as this.
  const double longer = (std::max(core.width, core.height) - 1) / M_SQRT2;
  // What ShapeOf() demands of its area and of its length, if it has every pixel of the thing.
  const double least_share = (kCircle - kCircleTolerance) * parameters.least_aspect;
  const double most_px2 = cv::countNonZero(thing) / kLeastConvex + 2 * longer + 1;
  // The left side grows faster than the right one with the length: no longer one would do.
  return least_share * longer > 1 && least_share * longer * longer > most_px2;
}

// The outline without what is thinner than half of the thing. Nothing when it falls apart, and when
// it is too long to be a marker.
std::optional<Contour> WithoutThinParts(const Contour& outline,
                                        const MarkerParameters& parameters) {
  const cv::Rect box = cv::boundingRect(outline);
  cv::Mat thing = cv::Mat::zeros(box.height + 2, box.width + 2, CV_8UC1);
  const cv::Point offset = cv::Point(1, 1) - box.tl();
  cv::drawContours(thing, std::vector<Contour>{outline}, 0, cv::Scalar(255), cv::FILLED, cv::LINE_8,
                   cv::noArray(), 0, offset);
  if (IsLong(thing, parameters)) return std::nullopt;
  cv::Mat depth;  // of each pixel below the surface
  cv::distanceTransform(thing, depth, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  double deepest = 0;
  cv::minMaxLoc(depth, nullptr, &deepest);
  const int core_px = std::max(1, static_cast<int>(deepest) / 2);
  // What is deeper than that, and all within that distance of it: an opening by a circle.
  cv::Mat core = depth <= core_px;
  cv::distanceTransform(core, depth, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat opened = (depth <= core_px + 0.5) & thing;
  std::vector<Contour> parts = OutlinesOf(opened);
  if (parts.size() != 1) return std::nullopt;
  for (cv::Point& point : parts[0]) point -= offset;
  return parts[0];
}

std::optional<Marker> ShapeOf(const Contour& outline, const MarkerParameters& parameters) {
  if (outline.empty()) return std::nullopt;  // nothing is left of it without its thin parts
  Contour hull;
  cv::convexHull(outline, hull);
  const double hull_px2 = cv::contourArea(hull);
  if (cv::contourArea(outline) < kLeastConvex * hull_px2) return std::nullopt;
  const cv::RotatedRect around = cv::minAreaRect(hull);
  // The corners are the middles of pixels: an outline is half a pixel farther out on every side.
  const double longer = std::max(around.size.width, around.size.height) + 1.0;
  const double shorter = std::min(around.size.width, around.size.height) + 1.0;
  if (shorter < parameters.least_aspect * longer) return std::nullopt;
  const double area_px2 = hull_px2 + cv::arcLength(hull, true) / 2 + 1;
  const double fill = area_px2 / (longer * shorter);
  const bool round = std::abs(fill - kCircle) < kCircleTolerance;
  const bool square = !parameters.round_only && fill > kLeastSquare;
  if (!round && !square) return std::nullopt;
  const double fill_margin = round ? 1 - std::abs(fill - kCircle) / kCircleTolerance
                                   : (fill - kLeastSquare) / (1 - kLeastSquare);
  const double aspect_margin =
      (shorter / longer - parameters.least_aspect) / std::max(0.01, 1 - parameters.least_aspect);
  return Marker{cv::boundingRect(outline), longer, round, std::min(fill_margin, aspect_margin),
                outline};
}

// Of what the outline encloses, where it is as the parameters say.
std::optional<Marker> MarkerOf(const Contour& outline, const cv::Size& picture,
                               const MarkerParameters& parameters) {
  const cv::Rect region = RectOf(parameters.region, picture);
  if (cv::contourArea(outline) < parameters.least_area_px2) return std::nullopt;
  if ((cv::boundingRect(outline) & region).empty()) return std::nullopt;
  const auto core = WithoutThinParts(outline, parameters);
  if (!core) return std::nullopt;
  const auto marker = ShapeOf(*core, parameters);
  if (!marker) return std::nullopt;
  const cv::Rect& box = marker->box;
  const bool is_cut =
      box.x == 0 || box.y == 0 || box.br().x == picture.width || box.br().y == picture.height;
  const double area_px2 = cv::contourArea(*core);
  if (is_cut || area_px2 < parameters.least_area_px2 || area_px2 > parameters.most_area_px2) {
    return std::nullopt;
  }
  if (!region.contains((box.tl() + box.br()) / 2)) return std::nullopt;
  return marker;
}

Contour OutlineOf(const Marker& marker) {
  return marker.outline.empty() ? EllipseIn(marker.box) : marker.outline;
}

// Of one paint, up to a sharp edge; unlike leaves, petals and fur. And more saturated than white
// paper is in the light of the warmest lamps.
bool IsPainted(const cv::Mat& bgr, const Marker& marker) {
  constexpr double kLeastEdge = 0.85, kLeastEnd = 0.3, kMostHue = 2, kMostSaturation = 10;
  constexpr double kWarmestPaper = 110;
  const Surface surface = SurfaceOf(bgr, OutlineOf(marker));
  return surface.edge_share >= kLeastEdge && surface.end_share >= kLeastEnd &&
         surface.hue_spread <= kMostHue && surface.saturation_spread <= kMostSaturation &&
         surface.saturation >= kWarmestPaper;
}

// Of what shines by its colours: which of it are lamps, as large as they are.
class Lamps {
 public:
  explicit Lamps(const cv::Mat& bgr) : bgr_(bgr) {}

  // Alike in every direction, and nowhere brighter than in its middle; unlike flowers and eyes. One
  // whose middle is white from brightness has shown that it shines.
  std::optional<Marker> LampOf(const Marker& marker) {
    constexpr double kWhite = 100, kLeastEdge = 0.85, kMostUnlike = 0.5;
    const auto box = UpToItsEdge(bgr_, marker.box);
    Marker lamp = marker;
    if (box && *box != marker.box) {
      lamp.size_px *= double(box->width) / marker.box.width;
      lamp.box = *box;
      lamp.outline.clear();
    }
    const Surface surface = SurfaceOf(bgr_, OutlineOf(lamp));
    if (surface.saturation < kWhite) return lamp;
    const bool is_alike = surface.edge_share >= kLeastEdge && surface.ring_share <= kMostUnlike &&
                          !surface.is_darker_inside;
    if (box && is_alike) return lamp;
    if (!refused_ || refused_->size_px < lamp.size_px) refused_ = lamp;
    return std::nullopt;
  }
  // The largest that is none by what it looks like.
  const std::optional<Marker>& refused() const { return refused_; }

 private:
  const cv::Mat& bgr_;
  std::optional<Marker> refused_;
};

std::optional<Marker> Largest(const std::vector<cv::Rect>& boxes, const cv::Size& picture,
                              const MarkerParameters& parameters, Lamps* lamps = nullptr) {
  const cv::Rect region = RectOf(parameters.region, picture);
  std::optional<Marker> largest;
  for (const cv::Rect& box : boxes) {
    const double area_px2 = M_PI / 4 * box.area();
    const bool is_cut =
        box.x <= 0 || box.y <= 0 || box.br().x >= picture.width || box.br().y >= picture.height;
    const bool fits = !is_cut && area_px2 >= parameters.least_area_px2 &&
                      area_px2 <= parameters.most_area_px2 &&
                      region.contains((box.tl() + box.br()) / 2);
    const double size_px = std::max(box.width, box.height);
    if (!fits || (largest && size_px <= largest->size_px)) continue;
    const Marker marker{box, size_px, true, 0, {}};
    const auto lamp = lamps == nullptr ? marker : lamps->LampOf(marker);
    if (lamp) largest = lamp;
  }
  return largest;
}

std::string Percent(double share) {
  return std::to_string(std::lround(100 * share)) + " %";
}

constexpr double kNear = 0.13;  // of the picture's width: about as far as the robot stops

struct WarmLook {
  MarkerLook look;
  std::optional<Marker> doubtful;  // the near round thing that is the doubt
};

// Whether the marker is that round thing, or at least as near.
bool Explains(const Marker& marker, const Marker& doubtful) {
  constexpr double kSame = 0.6;  // of its area
  return marker.size_px >= doubtful.size_px ||
         (marker.box & doubtful.box).area() > kSame * doubtful.box.area();
}

// Whether most of what is around it has the colour, with which its outline merges.
bool IsBefore(const cv::Mat& mask, const cv::Rect& box) {
  const cv::Point more(box.width / 3, box.height / 3);
  const cv::Rect wide = cv::Rect(box.tl() - more, box.br() + more) & cv::Rect({0, 0}, mask.size());
  const int outside_px2 = wide.area() - box.area();
  const int colored_px2 = cv::countNonZero(mask(wide)) - cv::countNonZero(mask(box));
  return outside_px2 > 0 && 2 * colored_px2 > outside_px2;
}

// In a picture of which `coverage` has the colour of lamps.
WarmLook LookInWarmLight(const cv::Mat& bgr, double coverage, const MarkerParameters& parameters,
                         Lamps& alike) {
  constexpr double kMostTooBright = 0.05;
  const LampsInWarmLight lamps = FindLampsInWarmLight(bgr, parameters.yellow, parameters.region);
  WarmLook warm;
  warm.look.marker = Largest(lamps.shining, bgr.size(), parameters, &alike);
  const auto round = Largest(lamps.round, bgr.size(), parameters);
  if (round && round->size_px > kNear * bgr.cols) {
    warm.doubtful = round;
    warm.look.doubt = "a near round thing may shine: " + Percent(coverage) +
                      " of the picture have the colour of the light";
  } else if (lamps.too_bright > kMostTooBright) {
    warm.look.doubt =
        Percent(lamps.too_bright) +
        " of the region have the colour of the light and are as bright as it would be";
  }
  return warm;
}

// How much more saturated the box is than what is around it, in levels of 255.
double MoreSaturated(const cv::Mat& saturation, const cv::Rect& box) {
  const cv::Point less(box.width / 5, box.height / 5), more(box.width / 3, box.height / 3);
  const cv::Rect inner(box.tl() + less, box.br() - less);
  const cv::Rect wide =
      cv::Rect(box.tl() - more, box.br() + more) & cv::Rect({0, 0}, saturation.size());
  const double in_box = cv::sum(saturation(box))[0], in_wide = cv::sum(saturation(wide))[0];
  const int around_px2 = wide.area() - box.area();
  if (inner.empty() || around_px2 <= 0) return 0;
  return cv::mean(saturation(inner))[0] - (in_wide - in_box) / around_px2;
}

// White paper has the tint of what is around it, as a wall in warm light; a sign has more.
constexpr double kLeastOffPaper = 24;

// The saturation of what has a hue of the range or near to it, however pale; 0 of the rest. White
// paper that the camera clips has another hue than the darker wall around it.
cv::Mat SaturationOfHue(const cv::Mat& hsv, const HsvRange& color) {
  constexpr int kNoisePx = 5, kNear = 8, kHues = 180;
  const HsvRange pale{{(color.from[0] - kNear + kHues) % kHues, 0, 0},
                      {(color.to[0] + kNear) % kHues, 255, 255}};
  cv::Mat saturation;
  cv::extractChannel(hsv, saturation, 1);
  cv::bitwise_and(saturation, MaskOfHsv(hsv, pale), saturation);
  cv::GaussianBlur(saturation, saturation, {kNoisePx, kNoisePx}, 0);
  return saturation;
}

// A sign where much of the picture has its colour, as a wall in warm light: the largest shape of
// what is above a level of saturation, where the next level has the same shape, and which is
// clearly more saturated than what is around it.
std::optional<Marker> FindMoreSaturated(const cv::Mat& bgr, const cv::Mat& saturation,
                                        const cv::Mat& mask, const MarkerParameters& parameters) {
  constexpr int kFrom = 70, kStep = 10, kTo = 250;
  constexpr double kSame = 0.8;  // of the area of both
  std::optional<Marker> largest;
  std::vector<cv::Rect> last;
  for (int level = kFrom; level < kTo; level += kStep) {
    cv::Mat above = (saturation >= level) & mask;
    CleanMask(above, parameters.kernel_px, parameters.kernel_px);
    std::vector<cv::Rect> boxes;
    for (const Contour& outline : OutlinesOf(above)) {
      const auto marker = MarkerOf(outline, mask.size(), parameters);
      if (!marker) continue;
      boxes.push_back(marker->box);
      const bool is_sharp = std::ranges::any_of(last, [&](const cv::Rect& other) {
        return (marker->box & other).area() > kSame * (marker->box | other).area();
      });
      if (!is_sharp || (largest && marker->size_px <= largest->size_px)) continue;
      if (MoreSaturated(saturation, marker->box) < kLeastOffPaper) continue;
      if (IsPainted(bgr, *marker)) largest = marker;
    }
    last = std::move(boxes);
  }
  return largest;
}

constexpr double kMostCoverage = 0.25;  // of a lamp that is so near that the robot stops

MarkerLook LookForSign(const cv::Mat& bgr, const MarkerParameters& parameters) {
  MarkerLook look;
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
  cv::Mat mask = MaskOfHsv(hsv, parameters.yellow);
  const cv::Mat saturation = SaturationOfHue(hsv, parameters.yellow);
  if (cv::countNonZero(mask) > kMostCoverage * double(mask.total())) {
    look.marker = FindMoreSaturated(bgr, saturation, mask, parameters);
  }
  CleanMask(mask, parameters.kernel_px, parameters.kernel_px);
  for (const Contour& outline : OutlinesOf(mask)) {
    const auto marker = MarkerOf(outline, bgr.size(), parameters);
    if (!marker || (look.marker && marker->size_px <= look.marker->size_px)) continue;
    if (MoreSaturated(saturation, marker->box) < kLeastOffPaper) continue;
    if (IsPainted(bgr, *marker)) look.marker = marker;
  }
  return look;
}

// The largest that shines by its outline, or by its white core.
std::optional<Marker> LargestLamp(const cv::Mat& hsv, const cv::Mat& mask,
                                  const MarkerParameters& parameters, std::optional<Marker> largest,
                                  Lamps& lamps) {
  for (const Contour& outline : OutlinesOf(mask)) {
    const auto marker = MarkerOf(outline, hsv.size(), parameters);
    if (!marker || (largest && marker->size_px <= largest->size_px)) continue;
    if (!Shines(hsv, marker->box)) continue;
    if (const auto lamp = lamps.LampOf(*marker)) largest = lamp;
  }
  // Also beside an outline: a farther lamp has one, the white core of a near one has none.
  const auto core = Largest(FindWhiteCores(hsv, parameters.yellow), hsv.size(), parameters, &lamps);
  return core && (!largest || core->size_px > largest->size_px) ? core : largest;
}

MarkerLook LookForLight(const cv::Mat& bgr, const MarkerParameters& parameters) {
  constexpr double kSome = 0.03;  // a wall of the colour, with which a lamp merges
  MarkerLook look;
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
  cv::Mat mask = MaskOfHsv(hsv, parameters.yellow);
  const double coverage = cv::countNonZero(mask) / double(mask.total());
  std::optional<Marker> doubtful, merged;
  Lamps lamps(bgr);
  if (coverage > kSome) {
    WarmLook warm = LookInWarmLight(bgr, coverage, parameters, lamps);
    if (coverage > kMostCoverage) {
      look = std::move(warm.look);
      doubtful = warm.doubtful;
      // What is clearly more saturated than the rest, too.
      mask = MaskOfLines(bgr, parameters.yellow, kMostCoverage).mask;
    } else {
      const auto& lamp = warm.look.marker;
      if (lamp && IsBefore(mask, lamp->box) && Shines(hsv, lamp->box)) merged = lamp;
      if (warm.doubtful && IsBefore(mask, warm.doubtful->box)) {
        doubtful = warm.doubtful;
        look.doubt = std::move(warm.look.doubt);
      }
    }
  }
  CleanMask(mask, parameters.kernel_px, parameters.kernel_px);
  look.marker = LargestLamp(hsv, mask, parameters, look.marker, lamps);
  // An outline of its own is more precise.
  if (merged && (!look.marker || !Explains(*look.marker, *merged))) look.marker = merged;
  const auto& refused = lamps.refused();
  const bool is_near = refused && refused->size_px > kNear * bgr.cols;
  if (is_near && (!doubtful || doubtful->size_px < refused->size_px)) {
    doubtful = refused;
    look.doubt = "a near round thing that may shine is not alike all around";
  }
  if (look.marker && (!doubtful || Explains(*look.marker, *doubtful))) look.doubt.clear();
  return look;
}

}  // namespace

MarkerParameters LightParameters() {
  MarkerParameters light;
  light.yellow = {{9, 100, 100}, {34, 255, 255}};
  light.shines = true;
  light.region = {0.16, 0.7, 0, 1};
  light.most_area_px2 = 100000;
  light.round_only = true;
  light.least_aspect = 0.8;
  return light;
}

MarkerLook LookForMarker(const cv::Mat& bgr, const MarkerParameters& parameters) {
  CheckCoursePicture(bgr);
  return parameters.shines ? LookForLight(bgr, parameters) : LookForSign(bgr, parameters);
}

std::optional<Marker> FindMarker(const cv::Mat& bgr, const MarkerParameters& parameters) {
  return LookForMarker(bgr, parameters).marker;
}

}  // namespace musher::vision
