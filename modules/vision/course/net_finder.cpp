#include "musher/modules/vision/course/net_finder.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {
namespace {

constexpr int kBoxNumbers = 4, kShareNumbers = 7;
constexpr double kGrey = 114;  // of the bars, as networks of this kind are trained with

std::vector<int> ShapeOf(const cv::Mat& output) {
  return {output.size.p, output.size.p + output.dims};
}

std::string TextOf(const std::vector<int>& shape) {
  std::string text;
  for (const int size : shape) text += (text.empty() ? "" : " x ") + std::to_string(size);
  return text.empty() ? "nothing" : text;
}

// Without OpenCV's place in its source, and only its first line.
std::string Why(const std::exception& thrown) {
  std::string why = thrown.what();
  why = why.substr(0, why.find('\n'));
  const std::size_t error = why.find("error: (");
  return error == std::string::npos ? why : why.substr(error);
}

// While it lives OpenCV prints nothing: what it has to say is in its exception.
class Quiet {
 public:
  Quiet() : level_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~Quiet() { cv::utils::logging::setLogLevel(level_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  const cv::utils::logging::LogLevel level_;
};

// One row of an output, whatever its layout.
class Row {
 public:
  Row(const float* first, int step) : first_(first), step_(step) {}
  double operator[](int i) const { return first_[std::ptrdiff_t(i) * step_]; }

 private:
  const float* first_;
  int step_;
};

NetBox WithMiddle(const Row& row, bool has_objectness, std::size_t labels) {
  const int first = kBoxNumbers + (has_objectness ? 1 : 0);
  NetBox box;
  double best = row[first];
  for (std::size_t i = 1; i < labels; ++i) {
    const double share = row[first + int(i)];
    if (share <= best) continue;
    best = share;
    box.label = i;
  }
  box.confidence = best * (has_objectness ? row[kBoxNumbers] : 1);
  box.box = {row[0] - row[2] / 2, row[1] - row[3] / 2, row[2], row[3]};
  return box;
}

// A label that the network has and the list has not is none.
std::optional<NetBox> WithShares(const Row& row, const NetParameters& parameters) {
  const double label = row[1];
  if (label < 0 || label >= double(parameters.labels.size())) return std::nullopt;
  const double left = row[3] * parameters.width_px, top = row[4] * parameters.height_px;
  return NetBox{
      std::size_t(label),
      row[2],
      {left, top, row[5] * parameters.width_px - left, row[6] * parameters.height_px - top}};
}

double OverlapOf(const cv::Rect2d& one, const cv::Rect2d& other) {
  const double shared = (one & other).area();
  return shared / std::max(1e-9, one.area() + other.area() - shared);
}

// Of each label's boxes that overlap the most confident one.
std::vector<NetBox> Suppress(std::vector<NetBox> boxes, double most_overlap) {
  std::ranges::stable_sort(boxes, [](const NetBox& one, const NetBox& other) {
    return one.confidence > other.confidence;
  });
  std::vector<NetBox> kept;
  for (const NetBox& box : boxes) {
    const bool is_known = std::ranges::any_of(kept, [&](const NetBox& each) {
      return each.label == box.label && OverlapOf(each.box, box.box) > most_overlap;
    });
    if (!is_known) kept.push_back(box);
  }
  return kept;
}

}  // namespace

NetPlace PlaceInInput(const cv::Size& picture, const NetParameters& parameters) {
  NetPlace place{double(parameters.width_px) / picture.width,
                 double(parameters.height_px) / picture.height};
  if (!parameters.keep_aspect) return place;
  place.scale_x = place.scale_y = std::min(place.scale_x, place.scale_y);
  place.left_px = std::floor((parameters.width_px - place.scale_x * picture.width) / 2);
  place.top_px = std::floor((parameters.height_px - place.scale_y * picture.height) / 2);
  return place;
}

std::optional<NetLayout> LayoutOf(const std::vector<int>& shape, std::size_t labels) {
  if (labels == 0 || shape.empty() || shape[0] != 1) return std::nullopt;
  if (shape.size() == 4 && shape[1] == 1 && shape[3] == kShareNumbers) return NetLayout::kShares;
  if (shape.size() != 3) return std::nullopt;
  const bool rows = shape[2] == kBoxNumbers + 1 + int(labels);
  const bool columns = shape[1] == kBoxNumbers + int(labels);
  // An export with its own choice of boxes: x, y, x, y, confidence, class. It has as many numbers
  // as one label has here, and its class would be read as a confidence.
  constexpr int kMostChosen = 1000;
  if (rows && labels == 1 && shape[1] <= kMostChosen) return std::nullopt;
  if (rows == columns) return std::nullopt;
  return rows ? NetLayout::kRows : NetLayout::kColumns;
}

NetLook ReadNetOutput(const cv::Mat& output, NetLayout layout, const NetPlace& place,
                      const NetParameters& parameters) {
  const float* numbers = output.ptr<float>();
  if (!std::all_of(numbers, numbers + output.total(), [](float x) { return std::isfinite(x); })) {
    return {{}, "the network yields numbers that are not finite"};
  }
  const std::vector<int> shape = ShapeOf(output);
  const bool columns = layout == NetLayout::kColumns;
  const int wide = columns ? shape.at(1) : shape.back();
  const int count = columns ? shape.at(2) : shape.at(shape.size() - 2);
  std::vector<NetBox> boxes;
  for (int i = 0; i < count; ++i) {
    const Row row = columns ? Row(numbers + i, count) : Row(numbers + std::ptrdiff_t(i) * wide, 1);
    const auto box = layout == NetLayout::kShares
                         ? WithShares(row, parameters)
                         : WithMiddle(row, !columns, parameters.labels.size());
    if (!box || box->confidence < parameters.least_confidence) continue;
    boxes.push_back(*box);
    cv::Rect2d& at = boxes.back().box;
    at = {(at.x - place.left_px) / place.scale_x, (at.y - place.top_px) / place.scale_y,
          at.width / place.scale_x, at.height / place.scale_y};
  }
  return {Suppress(std::move(boxes), parameters.most_overlap)};
}

struct Net::Engine {
  cv::dnn::Net net;
  NetLayout layout = NetLayout::kRows;
};

Net::Net(NetParameters parameters, std::unique_ptr<Engine> engine)
    : parameters_(std::move(parameters)), engine_(std::move(engine)) {}

Net::~Net() = default;

cv::Mat Net::OutputOf(const cv::Mat& bgr) {
  const NetPlace place = PlaceInInput(bgr.size(), parameters_);
  const cv::Size input(parameters_.width_px, parameters_.height_px);
  const cv::Matx23d into(place.scale_x, 0, place.left_px + (place.scale_x - 1) / 2, 0,
                         place.scale_y, place.top_px + (place.scale_y - 1) / 2);
  cv::Mat scaled;
  cv::warpAffine(bgr, scaled, into, input, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
                 cv::Scalar::all(kGrey));
  const auto& mean = parameters_.mean;
  engine_->net.setInput(cv::dnn::blobFromImage(scaled, parameters_.scale, input,
                                               {mean[0], mean[1], mean[2]}, parameters_.red_first));
  return engine_->net.forward();
}

Result<std::unique_ptr<Net>> Net::Load(const NetParameters& parameters) {
  const auto error = [](const std::string& what) { return Error{kCodeFailed, what}; };
  std::error_code none;
  if (!std::filesystem::is_regular_file(parameters.model, none)) {
    return error("there is no such file");
  }
  const std::string content = ReadFile(parameters.model);
  const Quiet quiet;
  cv::setNumThreads(1);  // leave CPU to the robot's other programs
  auto engine = std::make_unique<Engine>();
  try {
    if (!content.empty()) engine->net = cv::dnn::readNetFromONNX(content.data(), content.size());
  } catch (const std::exception& thrown) {
    return error("this is no ONNX model that OpenCV can load: " + Why(thrown));
  }
  if (engine->net.empty()) return error("this is no ONNX model");
  const std::size_t outputs = engine->net.getUnconnectedOutLayers().size();
  if (outputs != 1) {
    return error("the network has " + std::to_string(outputs) + " outputs, where one is expected");
  }
  engine->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  std::unique_ptr<Net> net(new Net(parameters, std::move(engine)));
  cv::Mat output;
  try {
    output =
        net->OutputOf({parameters.height_px, parameters.width_px, CV_8UC3, cv::Scalar::all(kGrey)});
  } catch (const std::exception& thrown) {
    return error("the network takes no picture of " + std::to_string(parameters.width_px) + " x " +
                 std::to_string(parameters.height_px) + " pixels: " + Why(thrown));
  }
  const auto layout = LayoutOf(ShapeOf(output), parameters.labels.size());
  if (!layout || output.depth() != CV_32F) {
    const std::size_t labels = parameters.labels.size();
    return error("the network's output of " + TextOf(ShapeOf(output)) +
                 " is of no known layout; with so many labels, " + std::to_string(labels) +
                 ", expected 1 x N x " + std::to_string(kBoxNumbers + 1 + labels) + ", 1 x " +
                 std::to_string(kBoxNumbers + labels) + " x N or 1 x 1 x N x 7");
  }
  net->engine_->layout = *layout;
  return net;
}

NetLook Net::Look(const cv::Mat& bgr) {
  CheckCoursePicture(bgr);
  NetLook look = ReadNetOutput(OutputOf(bgr), engine_->layout,
                               PlaceInInput(bgr.size(), parameters_), parameters_);
  const cv::Rect2d picture(0, 0, bgr.cols, bgr.rows);
  std::erase_if(look.boxes, [&](const NetBox& box) { return (box.box & picture).empty(); });
  return look;
}

}  // namespace musher::vision
