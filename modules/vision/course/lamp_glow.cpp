#include "musher/modules/vision/course/lamp_glow.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace musher::vision {
namespace {

constexpr double kSixth = 30;  // of OpenCV's hues
constexpr double kRedHue = 0, kGreenHue = 2 * kSixth, kBlueHue = 4 * kSixth;

// Of a light, in the picture: eyes of an animal and a lid of wood are round and darker.
constexpr double kLeastRed = 170;

// The red, green or blue of a pixel, 0 to 255.
double ChannelOf(const cv::Vec3b& hsv, double hue) {
  const double value = hsv[2], least = value * (1 - hsv[1] / 255.0);
  // A colour is full within a sixth of its hue, on either side, and falls to nothing in the next.
  const double off = std::abs(hsv[0] - hue), apart = std::min(off, 6 * kSixth - off) / kSixth;
  return least + (value - least) * std::clamp(2 - apart, 0.0, 1.0);
}

// How bright it looks, 0 to 255.
double LumaOf(const cv::Vec3b& hsv) {
  return 0.3 * ChannelOf(hsv, kRedHue) + 0.59 * ChannelOf(hsv, kGreenHue) +
         0.11 * ChannelOf(hsv, kBlueHue);
}

struct Mean {
  double value = 0, saturation = 0, luma = 0, red = 0, green = 0;
  int count = 0;
};

// Places between two ellipses around the middle of the box, in shares of its half sides.
template <class Visit>
void VisitBetween(const cv::Size& picture, const cv::Rect& box, double least, double most,
                  const Visit& visit) {
  constexpr int kSteps = 64, kRings = 6;
  const double x_px = box.width / 2.0, y_px = box.height / 2.0;
  for (int ring = 0; ring < kRings; ++ring) {
    const double share = least + (most - least) * (ring + 0.5) / kRings;
    for (int i = 0; i < kSteps; ++i) {
      const double turn = 2 * M_PI * i / kSteps;
      const cv::Point at(int(box.x + x_px + share * x_px * std::cos(turn)),
                         int(box.y + y_px + share * y_px * std::sin(turn)));
      if (cv::Rect({0, 0}, picture).contains(at)) visit(at);
    }
  }
}

Mean MeanBetween(const cv::Mat& hsv, const cv::Rect& box, double least, double most) {
  Mean mean;
  VisitBetween(hsv.size(), box, least, most, [&](const cv::Point& at) {
    const auto& pixel = hsv.at<cv::Vec3b>(at);
    mean.value += pixel[2];
    mean.saturation += pixel[1];
    mean.luma += LumaOf(pixel);
    mean.red += ChannelOf(pixel, kRedHue);
    mean.green += ChannelOf(pixel, kGreenHue);
    ++mean.count;
  });
  if (mean.count == 0) return mean;
  mean.value /= mean.count;
  mean.saturation /= mean.count;
  mean.luma /= mean.count;
  mean.red /= mean.count;
  mean.green /= mean.count;
  return mean;
}

// Of a channel; nothing outside of the picture.
std::optional<double> LevelBetween(const cv::Mat& channel, const cv::Rect& box, double least,
                                   double most) {
  double sum = 0;
  int count = 0;
  VisitBetween(channel.size(), box, least, most, [&](const cv::Point& at) {
    sum += channel.at<std::uint8_t>(at);
    ++count;
  });
  if (count == 0) return std::nullopt;
  return sum / count;
}

// The share of the box's middle that has the colour.
double ShareOf(const cv::Mat& hsv, const cv::Rect& box, const HsvRange& color) {
  int in = 0, all = 0;
  VisitBetween(hsv.size(), box, 0, 0.9, [&](const cv::Point& at) {
    in += IsIn(hsv.at<cv::Vec3b>(at), color) ? 1 : 0;
    ++all;
  });
  return all == 0 ? 0 : in / double(all);
}

constexpr double kFarthestRing = 2.2;  // in radii of the core
constexpr double kAroundFrom = 1.5, kAroundTo = 2.2;

// In shares of the radius of a core: where the ring of colour ends in each direction; 0: there is
// none.
double RingEnd(const cv::Mat& hsv, const cv::Rect& core, const HsvRange& color, double turn) {
  constexpr double kLeastLuma = 185;  // of the lamp; its glow on what is around it is darker
  constexpr double kMostGapPx = 1.6;  // noise
  const double radius_px = (core.width + core.height) / 4.0;
  const cv::Point2d middle(core.x + core.width / 2.0, core.y + core.height / 2.0);
  double end = 0;
  constexpr double kBegin = 0.8;
  const double step = 0.5 / radius_px;
  const int steps = int(std::ceil((kFarthestRing - kBegin) / step));
  for (int i = 0; i < steps; ++i) {
    const double at = kBegin + i * step;
    const cv::Point place(int(middle.x + at * radius_px * std::cos(turn)),
                          int(middle.y + at * radius_px * std::sin(turn)));
    if (!cv::Rect({0, 0}, hsv.size()).contains(place)) break;
    const auto& pixel = hsv.at<cv::Vec3b>(place);
    if (IsIn(pixel, color) && LumaOf(pixel) > kLeastLuma) {
      end = at;
    } else if (end > 0 && (at - end) * radius_px > kMostGapPx) {
      break;
    }
  }
  return end;
}

// The core with its ring; nothing where the ring is not around nearly all of it, or not as round as
// the core: a sign with a white disc.
std::optional<cv::Rect> WithRing(const cv::Mat& hsv, const cv::Rect& core, const HsvRange& color) {
  constexpr int kDirections = 32, kLeast = 26;
  std::vector<double> ends;
  for (int i = 0; i < kDirections; ++i) {
    const double end = RingEnd(hsv, core, color, 2 * M_PI * i / kDirections);
    if (end > 0) ends.push_back(end);
  }
  if (ends.size() < kLeast) return std::nullopt;
  std::nth_element(ends.begin(), ends.begin() + std::ptrdiff_t(ends.size() / 2), ends.end());
  const double factor = std::max(1.0, ends[ends.size() / 2]);
  const double unlike = std::max(0.08 * factor, 2.8 / (core.width + core.height));
  const auto alike = std::count_if(ends.begin(), ends.end(), [&](double end) {
    return end < kFarthestRing - 0.1 && std::abs(end - factor) <= unlike;
  });
  if (alike < kLeast) return std::nullopt;
  const int width = cvRound(factor * core.width), height = cvRound(factor * core.height);
  const cv::Rect box(core.x + (core.width - width) / 2, core.y + (core.height - height) / 2, width,
                     height);
  // More saturated than what is beyond, which a warm light colours, too.
  constexpr double kMoreSaturated = 25;
  const Mean ring = MeanBetween(hsv, core, 0.95, std::max(1.1, factor * 0.97));
  const Mean beyond = MeanBetween(hsv, box, kAroundFrom, kAroundTo);
  if (beyond.count == 0 || ring.saturation < beyond.saturation + kMoreSaturated) {
    return std::nullopt;
  }
  // Where the middle is white the lamp has all the red that a picture can have; paint has less.
  constexpr double kLeastInner = 245;
  const double inner = MeanBetween(hsv, core, 1, 1 + 0.6 * (factor - 1)).value;
  if (inner < kLeastInner) return std::nullopt;
  return box;
}

bool IsRound(const Contour& outline) {
  constexpr double kLeastAspect = 0.75, kCircle = M_PI / 4, kTolerance = 0.1, kConvex = 0.9;
  const cv::RotatedRect around = cv::minAreaRect(outline);
  const double longer = std::max(around.size.width, around.size.height) + 1.0;
  const double shorter = std::min(around.size.width, around.size.height) + 1.0;
  if (shorter < kLeastAspect * longer) return false;
  Contour hull;
  cv::convexHull(outline, hull);
  const double area_px2 = cv::contourArea(hull) + cv::arcLength(hull, true) / 2 + 1;
  return std::abs(area_px2 / (longer * shorter) - kCircle) < kTolerance &&
         cv::contourArea(outline) > kConvex * cv::contourArea(hull);
}

bool IsSameOutline(const cv::Rect& one, const cv::Rect& other) {
  constexpr int kMostOffPx = 1;
  const cv::Point from = one.tl() - other.tl(), to = one.br() - other.br();
  return std::max({std::abs(from.x), std::abs(from.y), std::abs(to.x), std::abs(to.y)}) <=
         kMostOffPx;
}

// Round, convex outlines of what is above a level of the channel, where the next level has the same
// outline. A pool of light has no sharp edge.
std::vector<cv::Rect> SharpRounds(const cv::Mat& channel) {
  constexpr int kFrom = 104, kStep = 6, kWhite = 255;
  constexpr double kLeastArea = 40;
  std::vector<cv::Rect> found, last;
  for (int level = kFrom; level < kWhite; level += kStep) {
    std::vector<Contour> outlines;
    std::vector<cv::Vec4i> tree;  // next, previous, first child, parent
    cv::findContours(channel >= level, outlines, tree, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
    std::vector<cv::Rect> rounds;
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      if (tree[i][3] >= 0) continue;  // of a hole
      if (cv::contourArea(outlines[i]) < kLeastArea || !IsRound(outlines[i])) continue;
      rounds.push_back(cv::boundingRect(outlines[i]));
      const cv::Rect& box = rounds.back();
      const auto same = [&](const cv::Rect& other) { return IsSameOutline(box, other); };
      if (std::ranges::any_of(last, same) && std::ranges::none_of(found, same)) {
        found.push_back(box);
      }
    }
    last = std::move(rounds);
  }
  return found;
}

}  // namespace

bool Shines(const cv::Mat& hsv, const cv::Rect& box) {
  // In values, of which a picture has the square root of the light.
  constexpr double kBrighterThanAround = 1.15, kBrighterThanRim = 1.12;
  const Mean middle = MeanBetween(hsv, box, 0, 0.4), rim = MeanBetween(hsv, box, 0.75, 0.92);
  const Mean around = MeanBetween(hsv, box, kAroundFrom, kAroundTo);
  if (around.count == 0) return false;
  if (std::max(middle.red, rim.red) < kLeastRed) return false;
  // A lamp with a white middle is bright up to its rim: what is darker there is its glow on a wall.
  constexpr double kWhite = 90, kBrightRim = 0.87;
  if (middle.saturation < kWhite && rim.luma < kBrightRim * middle.luma) return false;
  // No paint has all of the red and of the green that a picture can have where white has not: a
  // lamp before a bright wall or the sky, which cannot be brighter than these in the picture.
  constexpr double kAllRed = 248, kAllGreen = 240, kNotYetWhite = 251;
  if (std::min(middle.red, rim.red) > kAllRed && std::min(middle.green, rim.green) > kAllGreen &&
      around.luma < kNotYetWhite && middle.saturation >= kWhite) {
    return true;
  }
  const double bright = std::max(middle.value, rim.value);
  if (bright > kBrighterThanAround * around.value) return true;
  // A core that is so bright loses its colour instead.
  const bool fades = middle.value > kBrighterThanRim * rim.value ||
                     middle.saturation * kBrighterThanRim < rim.saturation - 8;
  return fades && middle.value > around.value;
}

std::vector<cv::Rect> FindWhiteCores(const cv::Mat& hsv, const HsvRange& color) {
  constexpr int kLeastValue = 235, kMostSaturation = 95;
  constexpr double kLeastArea = 30;
  cv::Mat white;
  cv::inRange(hsv, cv::Scalar(0, 0, kLeastValue), cv::Scalar(179, kMostSaturation, 255), white);
  std::vector<cv::Rect> found;
  // All outer outlines: the glow on a light wall is white, too, around the ring and the core.
  std::vector<Contour> outlines;
  std::vector<cv::Vec4i> tree;  // next, previous, first child, parent
  cv::findContours(white, outlines, tree, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    const Contour& outline = outlines[i];
    if (tree[i][3] >= 0) continue;  // of a hole
    if (cv::contourArea(outline) < kLeastArea || !IsRound(outline)) continue;
    if (const auto box = WithRing(hsv, cv::boundingRect(outline), color)) found.push_back(*box);
  }
  return found;
}

LampsInWarmLight FindLampsInWarmLight(const cv::Mat& bgr, const HsvRange& color,
                                      const Region& searched) {
  constexpr double kLeastContrast = 14;  // of green; paint in the colour of lamps is darker in it
  constexpr double kLeastMoreSaturated = 20, kLeastShare = 0.9;
  // Of saturation. White paper has that of what is around it, and is paler in a second light; a
  // lamp is paler only where it has all the green that a picture can have.
  constexpr double kOwnColor = 10, kMostPaler = 32;
  constexpr double kAllGreen = 240, kOverexposed = 245;
  constexpr double kEdge = 1.2, kBeyond = 1.7;  // what is around it, in shares of its half sides
  constexpr int kNoisePx = 3;
  constexpr int kScale = 2;  // a quarter of the pixels takes a quarter of the time
  LampsInWarmLight lamps;
  cv::Mat half, hsv, green, red, saturation;
  cv::resize(bgr, half, {std::max(1, bgr.cols / kScale), std::max(1, bgr.rows / kScale)}, 0, 0,
             cv::INTER_AREA);
  cv::GaussianBlur(half, half, {kNoisePx, kNoisePx}, 0);
  cv::cvtColor(half, hsv, cv::COLOR_BGR2HSV);
  cv::extractChannel(half, green, 1);
  cv::extractChannel(half, red, 2);
  cv::extractChannel(hsv, saturation, 1);
  const auto whole = [](const cv::Rect& box) {
    return cv::Rect(box.tl() * kScale, box.br() * kScale);
  };
  const auto is_dim = [&](const cv::Rect& box) {
    return LevelBetween(red, box, 0, 0.8).value_or(0) < kLeastRed;
  };
  const auto more = [&](const cv::Mat& channel, const cv::Rect& box) {
    const auto around = LevelBetween(channel, box, kEdge, kBeyond);
    return around ? LevelBetween(channel, box, 0, 0.8).value_or(0) - *around : 0;
  };
  for (const cv::Rect& box : SharpRounds(green)) {
    if (more(green, box) < kLeastContrast || is_dim(box)) continue;
    const double more_saturated = more(saturation, box);
    const bool has_color = more_saturated >= -kMostPaler && ShareOf(hsv, box, color) >= kLeastShare;
    const bool all_green = LevelBetween(green, box, 0, 0.8).value_or(0) >= kAllGreen;
    if (has_color && (more_saturated >= kOwnColor || all_green)) {
      lamps.shining.push_back(whole(box));
    } else if (has_color || LevelBetween(green, box, 0, 0.4).value_or(0) >= kOverexposed) {
      lamps.round.push_back(whole(box));
    }
  }
  for (const cv::Rect& box : SharpRounds(saturation)) {
    if (more(saturation, box) < kLeastMoreSaturated || ShareOf(hsv, box, color) < kLeastShare ||
        is_dim(box)) {
      continue;
    }
    const bool shines = more(green, box) >= kLeastContrast || Shines(hsv, box);
    (shines ? lamps.shining : lamps.round).push_back(whole(box));
  }
  // What leaves no room for something brighter.
  constexpr int kBrightest = 255 - int(kLeastContrast);
  const cv::Rect region = RectOf(searched, half.size());
  cv::Mat bright = green(region) > kBrightest;
  cv::bitwise_and(bright, MaskOfHsv(hsv(region), color), bright);
  for (const cv::Rect& box : lamps.shining) {
    const cv::Rect at(box.tl() / kScale - region.tl(), box.br() / kScale - region.tl());
    cv::rectangle(bright, at, cv::Scalar(0), cv::FILLED);
  }
  lamps.too_bright = cv::countNonZero(bright) / double(bright.total());
  return lamps;
}

}  // namespace musher::vision
