#pragma once
// Things that a neural network finds: boxes with a label and a confidence. The network is an ONNX
// file of one's own, which OpenCV's dnn runs on the CPU; Musher has none.
//
// The picture is scaled to the network's input, with grey bars where the aspects differ. Its one
// output has to be, for L labels and N boxes, in pixels of the input:
//
//   1 x N x (5 + L)   rows of middle x, y, width, height, objectness, label shares: YOLO 5
//   1 x (4 + L) x N   the same in columns, without an objectness: YOLO 8
//   1 x 1 x N x 7     rows of picture, label, confidence, left, top, right, bottom, the last four
//                     as shares of the input: SSD. Its first label is the background
//
// Boxes of one label that overlap are one, the most confident. An output with numbers that are not
// finite is a doubt, and says nothing.
//
// Threads: one call at a time for each Net. Errors: the Error's message says what is wrong with the
// file, without its name.

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::vision {

struct NetParameters {
  std::string model;                // the ONNX file
  std::vector<std::string> labels;  // in the order of the network's classes
  int width_px = 640;               // of the input
  int height_px = 640;
  double scale = 1.0 / 255;             // of a pixel's values, after
  std::array<double, 3> mean{0, 0, 0};  // was subtracted, in the order of the input's channels
  bool red_first = true;                // the order of these: red, green, blue
  bool keep_aspect = true;              // false: the picture is stretched to the input
  double least_confidence = 0.5;
  double most_overlap = 0.45;  // of two boxes: the shared area as a share of both together
  int min_repeats = 2;         // pictures in a row that have to agree
  Duration longest = Milliseconds(500);  // for a picture; what took longer is old
  double height_m = 0;                   // of the thing; 0: the distance stays unknown
  double focal_px = 600;                 // of a picture 640 pixels wide, while no lens is known

  friend bool operator==(const NetParameters&, const NetParameters&) = default;
};

struct NetBox {
  std::size_t label = 0;
  double confidence = 0;
  cv::Rect2d box;  // pixels of the picture
};

// Where the picture is in the input.
struct NetPlace {
  double scale_x = 1, scale_y = 1;
  double left_px = 0, top_px = 0;
};
NetPlace PlaceInInput(const cv::Size& picture, const NetParameters& parameters);

enum class NetLayout { kRows, kColumns, kShares };

// Of an output of that shape; nothing where none fits, or two do.
std::optional<NetLayout> LayoutOf(const std::vector<int>& shape, std::size_t labels);

struct NetLook {
  std::vector<NetBox> boxes;  // the most confident first
  std::string doubt{};        // why they say nothing
};

// What an output of CV_32F says, whose layout is known.
NetLook ReadNetOutput(const cv::Mat& output, NetLayout layout, const NetPlace& place,
                      const NetParameters& parameters);

class Net {
 public:
  // Loads the file, and tries it with a grey picture.
  static Result<std::unique_ptr<Net>> Load(const NetParameters& parameters);
  ~Net();

  // `bgr`: as of color_mask.hpp. Throws what OpenCV does.
  NetLook Look(const cv::Mat& bgr);

 private:
  struct Engine;
  Net(NetParameters parameters, std::unique_ptr<Engine> engine);
  cv::Mat OutputOf(const cv::Mat& bgr);

  const NetParameters parameters_;
  const std::unique_ptr<Engine> engine_;
};

}  // namespace musher::vision
