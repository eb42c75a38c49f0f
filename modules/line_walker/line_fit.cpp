#include "musher/modules/line_walker/line_fit.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace musher::line_walker {
namespace {

constexpr std::size_t kCurveCorners = 12;  // points that hypotheses go through
constexpr double kLeastCornerGapM = 0.06;  // between the points of a hypothesis
constexpr double kOtherLineM = 0.1;        // a curve that much nearer is another line
constexpr double kNearerShare = 0.5;       // of the points of the longest line
constexpr double kCurvatureWeight = 0.01;  // of the assumed curvature, in m^4
constexpr double kFullSpanM = 0.8;         // of a line of full quality
constexpr double kFullPoints = 16;

struct Curve {
  std::array<double, 3> c{};

  double At(double x) const { return c[0] + x * (c[1] + x * c[2]); }
  double Slope(double x) const { return c[1] + 2 * x * c[2]; }
};

double Off(const Curve& curve, const GroundPoint& point) {
  const double slope = curve.Slope(point.x_m);
  return std::abs(point.y_m - curve.At(point.x_m)) / std::sqrt(1 + slope * slope);
}

GroundPoints Inliers(const Curve& curve, const GroundPoints& points, double tolerance_m) {
  GroundPoints inliers;
  for (const GroundPoint& point : points) {
    if (Off(curve, point) <= tolerance_m) inliers.push_back(point);
  }
  return inliers;
}

bool FitsALane(const Curve& curve, const FitRules& rules) {
  const double slope = curve.c[1];
  const double curvature = 2 * curve.c[2] / std::pow(1 + slope * slope, 1.5);
  return std::abs(std::atan(slope)) <= rules.steepest_rad &&
         std::abs(curvature) * rules.tightest_m <= 1;
}

// Through two points, with that curvature.
Curve Through(const GroundPoint& a, const GroundPoint& b, double c2) {
  const double c1 = (b.y_m - a.y_m) / (b.x_m - a.x_m) - c2 * (a.x_m + b.x_m);
  return {{a.y_m - a.x_m * (c1 + a.x_m * c2), c1, c2}};
}

Curve Through(const GroundPoint& a, const GroundPoint& b, const GroundPoint& c) {
  const double first = (b.y_m - a.y_m) / (b.x_m - a.x_m);
  const double second = (c.y_m - b.y_m) / (c.x_m - b.x_m);
  return Through(a, b, (second - first) / (c.x_m - a.x_m));
}

// Least squares; the curvature is drawn to the assumed one, which decides where points are few.
Curve BestThrough(const GroundPoints& points, double c2) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const GroundPoint& point : points) {
    const Eigen::Vector3d row(1, point.x_m, point.x_m * point.x_m);
    normal += row * row.transpose();
    right += row * point.y_m;
  }
  normal(2, 2) += kCurvatureWeight;
  right(2) += kCurvatureWeight * c2;
  const Eigen::Vector3d solved = normal.inverse() * right;
  return {{solved(0), solved(1), solved(2)}};
}

class CurveSearch {
 public:
  CurveSearch(const GroundPoints& points, Side side, const FitRules& rules, double c2)
      : points_(points), side_(side), rules_(rules), c2_(c2) {
    const std::size_t count = std::min(kCurveCorners, points.size());
    for (std::size_t i = 0; i < count; ++i) {
      corners_.push_back(points[i * (points.size() - 1) / std::max<std::size_t>(1, count - 1)]);
    }
  }

  std::optional<Curve> Run() {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      for (std::size_t j = i + 1; j < corners_.size(); ++j) {
        if (corners_[j].x_m - corners_[i].x_m < kLeastCornerGapM) continue;
        Consider(Through(corners_[i], corners_[j], c2_));
        for (std::size_t k = j + 1; k < corners_.size(); ++k) {
          if (corners_[k].x_m - corners_[j].x_m < kLeastCornerGapM) continue;
          Consider(Through(corners_[i], corners_[j], corners_[k]));
        }
      }
    }
    return Choose();
  }

 private:
  struct Candidate {
    Curve curve;
    std::size_t points = 0;
    double aside_m = 0;
  };

  void Consider(const Curve& curve) {
    const double aside = side_ == Side::kLeft ? curve.At(0) : -curve.At(0);
    if (aside < rules_.nearest_m || !FitsALane(curve, rules_)) return;
    const auto near = [&](const GroundPoint& point) {
      return Off(curve, point) <= rules_.tolerance_m;
    };
    const auto count = std::size_t(std::count_if(points_.begin(), points_.end(), near));
    if (int(count) >= rules_.least_points) candidates_.push_back({curve, count, aside});
  }

  // The curve of the most points, unless a nearer one has enough of them.
  std::optional<Curve> Choose() const {
    if (candidates_.empty()) return std::nullopt;
    const auto fewer = [](const Candidate& a, const Candidate& b) { return a.points < b.points; };
    const Candidate* best = &*std::max_element(candidates_.begin(), candidates_.end(), fewer);
    const double enough = kNearerShare * double(best->points);
    for (bool nearer = true; nearer;) {
      nearer = false;
      const Candidate* next = nullptr;
      for (const Candidate& each : candidates_) {
        if (each.aside_m > best->aside_m - kOtherLineM || double(each.points) < enough) continue;
        if (next == nullptr || fewer(*next, each)) next = &each;
      }
      if (next != nullptr) {
        best = next;
        nearer = true;
      }
    }
    return best->curve;
  }

  const GroundPoints& points_;
  const Side side_;
  const FitRules& rules_;
  const double c2_;
  GroundPoints corners_;
  std::vector<Candidate> candidates_;
};

// Where the curve is nearest to the origin.
double NearestX(const Curve& curve) {
  double x = 0;
  for (int i = 0; i < 5; ++i) {
    const double slope = curve.Slope(x);
    const double y = curve.At(x);
    const double second = std::max(0.3, 1 + slope * slope + 2 * curve.c[2] * y);
    x = std::clamp(x - (x + y * slope) / second, -0.6, 0.6);
  }
  return x;
}

double QualityOf(const Curve& curve, const GroundPoints& inliers, const FitRules& rules) {
  double squares = 0;
  for (const GroundPoint& point : inliers) squares += std::pow(Off(curve, point), 2);
  const double rms_m = std::sqrt(squares / double(inliers.size()));
  const double span_m = inliers.back().x_m - inliers.front().x_m;
  // How far the body's middle is from the points beside it.
  const double beyond_m = std::max({0.0, inliers.front().x_m, -inliers.back().x_m});
  return std::min(1.0, span_m / kFullSpanM) * std::min(1.0, double(inliers.size()) / kFullPoints) *
         (1 - 0.5 * std::min(1.0, rms_m / rules.tolerance_m)) * std::max(0.1, 1 - 2 * beyond_m);
}

}  // namespace

std::optional<SideLine> FitSideLine(const GroundPoints& all, Side side, const FitRules& rules,
                                    double curvature_per_m) {
  GroundPoints points;
  for (const GroundPoint& point : all) {
    const double aside = side == Side::kLeft ? point.y_m : -point.y_m;
    const bool near = aside >= 0 && aside <= rules.farthest_m && point.x_m >= -rules.back_m &&
                      point.x_m <= rules.ahead_m;  // NaN is not near
    if (near) points.push_back(point);
  }
  std::sort(points.begin(), points.end(),
            [](const GroundPoint& a, const GroundPoint& b) { return a.x_m < b.x_m; });
  if (int(points.size()) < std::max(3, rules.least_points)) return std::nullopt;
  const double c2 = curvature_per_m / 2;
  std::optional<Curve> curve = CurveSearch(points, side, rules, c2).Run();
  GroundPoints inliers;
  for (int i = 0; curve && i < 3; ++i) {
    inliers = Inliers(*curve, points, rules.tolerance_m);
    if (int(inliers.size()) < rules.least_points) return std::nullopt;
    curve = BestThrough(inliers, c2);
  }
  if (!curve || !FitsALane(*curve, rules)) return std::nullopt;
  if (inliers.back().x_m - inliers.front().x_m < rules.least_span_m) return std::nullopt;
  const double x = NearestX(*curve);
  const double slope = curve->Slope(x);
  SideLine line;
  line.distance_m = std::hypot(x, curve->At(x));
  line.heading_rad = std::atan(slope);
  line.curvature_per_m = 2 * curve->c[2] / std::pow(1 + slope * slope, 1.5);
  line.quality = QualityOf(*curve, inliers, rules);
  line.curve = curve->c;
  line.far_x_m = inliers.back().x_m;
  const double aside = side == Side::kLeft ? curve->At(x) : -curve->At(x);
  if (aside < rules.nearest_m || line.distance_m > rules.farthest_m) return std::nullopt;
  return line;
}

}  // namespace musher::line_walker
