#pragma once
// Pictures of config/scenes/course.toml with labels: what a detector of config/vision/course.toml
// has to find in each, for figures and for tests.
//
// For each kind of detector there is a grid of cells, a distance by an angle. In each cell a
// picture is taken in each of several lights: brightness, direction, gradient and colour of the
// light (300 K beyond what the scene varies), exposure and noise of the camera, the robot's tilt
// and its heading differ at random. Every second time the same picture is taken again of a course
// without the thing, or with something alike in its place: a code that is no word, a green board
// without an arrow, a red post, white lines, a blue sign, a white lamp.
//
// Units: metres, degrees, pixels. Distances are from the camera; of lines, from the body's middle
// to the place of the line. Angles are those between the line of sight and the front of a board, a
// bar or a sign; of the light, from the picture's middle; of lines, of the heading off the lane.
// The same seed gives the same pictures. Threads: one at a time.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/vision/course/course_config.hpp"
#include "musher/modules/world/render/render.hpp"
#include "musher/test/modules/vision/labelled/line_map.hpp"

namespace musher::vision {

struct Cell {
  double distance_m = 0;  // of lines: from the middle of the lane to its right
  double angle_deg = 0;
};

struct LabelledPicture {
  CourseKind kind = CourseKind::kQr;
  Cell cell;
  bool there = false;  // the thing
  cv::Mat bgr;
  Lens lens;
  // Of a thing that is there.
  cv::Rect2d box;         // in the picture
  double distance_m = 0;  // along the camera's axis, as detectors measure it
  std::string text;       // the word of a board, the direction of an arrow
  // Of lines.
  std::size_t camera = 0;  // front, left, right
  world::Intrinsics intrinsics;
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  Eigen::Vector2d body_m{0, 0};
  std::shared_ptr<const LineMap> lines;  // where they are, or would be

  // Where a pixel shows the ground; nothing above the horizon and beyond a fisheye's circle.
  std::optional<Eigen::Vector2d> GroundAt(const Eigen::Vector2d& pixel) const;
};

struct LabelledSettings {
  std::uint64_t seed = 1;
  int lights = 6;
  double texels_per_m = 240;     // of the ground
  double most_distance_m = 100;  // cells up to there
  double most_angle_deg = 90;
};

std::vector<Cell> CellsOf(CourseKind kind);

// Calls `see` with each picture of these kinds, in a fixed order. Pictures in which the thing is
// cut by the edge of the picture are left out: what a detector has to say of them differs.
void SeeLabelledPictures(const LabelledSettings& settings, const std::vector<CourseKind>& kinds,
                         const std::function<void(const LabelledPicture&)>& see);

}  // namespace musher::vision
