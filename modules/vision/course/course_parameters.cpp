#include "musher/modules/vision/course/course_parameters.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "musher/base/toml/names.hpp"

namespace musher::vision {
namespace {

using config_toml::Table;
using config_toml::TableReader;

constexpr double kMostAreaPx2 = 8192.0 * 8192;  // of a picture that CheckPicture() accepts
constexpr double kMostFocalPx = 10'000;
constexpr int kMostKernelPx = 99;
constexpr int kMostInputPx = 4096;
constexpr int kMostPictures = 1000;

class ParametersReader {
 public:
  ParametersReader(const Hall& hall, TableReader& reader, config_toml::Findings& findings)
      : hall_(hall), reader_(reader), findings_(findings) {}

  LinesParameters Lines(const std::string& picture) {
    LinesParameters lines;
    Color("yellow", hall_.yellow, lines.yellow);
    SearchedIn("region", lines.region);
    Number("least_area_px2", 1, kMostAreaPx2, lines.least_area_px2);
    Number("least_length", 0, 100, lines.least_length);
    Integer("most_lines", 1, 100, lines.most_lines);
    lines.along = reader_.Bool("along").value_or(lines.along);
    Number("ycy_threshold", 0, 0.5, lines.ycy_threshold);
    // An offset from the target is below 1, and from the middle below 0.5.
    Number("dy_threshold", 0, 0.5, lines.dy_threshold);
    Number("dy_target", 0, 1, lines.dy_target);
    Number("ycy_center", 0, 1, lines.ycy_center);
    lines.ycy_pair = reader_
                         .Choice<LanePair>("ycy_pair", {{"outermost", LanePair::kOutermost},
                                                        {"innermost", LanePair::kInnermost}})
                         .value_or(lines.ycy_pair);
    Number("walk_bottom_px", 0, 8192, lines.walk_bottom_px);
    Number("walk_x_px", 0, 8192, lines.walk_x_px);
    Integer("edge_columns", 2, 640, lines.edge_columns);
    Number("most_coverage", 0.01, 1, lines.most_coverage);
    const auto mount = hall_.mounts.find(picture);
    if (mount != hall_.mounts.end()) lines.mount = mount->second;
    if (lines.along && !lines.mount) {
      reader_.Fault(reader_.At("along"), "along",
                    "needs a mount of the camera of \"" + picture + '"');
    }
    lines.lane_m = hall_.lane_m;
    lines.least_width_m = hall_.least_line_m;
    lines.most_width_m = hall_.most_line_m;
    return lines;
  }

  ArrowParameters Arrow() {
    ArrowParameters arrow;
    Color("green", hall_.green, arrow.green);
    SearchedIn("region", "arrow", arrow.region);
    Number("least_area_px2", 1, kMostAreaPx2, arrow.least_area_px2);
    Integer("kernel_px", 1, kMostKernelPx, arrow.kernel_px);
    Number("most_misfit", 0.001, 1, arrow.most_misfit);
    Number("clearly", 1, 100, arrow.clearly);
    arrow.other_shapes = reader_.Bool("other_shapes").value_or(arrow.other_shapes);
    Number("most_shape_misfit", 0.001, 1, arrow.most_shape_misfit);
    return arrow;
  }

  BarrierParameters Barrier() {
    BarrierParameters barrier;
    Color("red", hall_.red, barrier.red);
    Color("yellow", std::nullopt, barrier.yellow);
    barrier.striped = reader_.Bool("striped").value_or(barrier.striped);
    SearchedIn("region", "barrier", barrier.region);
    Number("least_area_px2", 1, kMostAreaPx2, barrier.least_area_px2);
    Number("least_length", 1, 100, barrier.least_length);
    Number("least_fill", 0.01, 1, barrier.least_fill);
    Number("most_tilt_deg", 0, 90, barrier.most_tilt_deg);
    Number("top", 0, 1, barrier.top);
    Number("height_m", 0.001, 10, barrier.height_m);
    Number("focal_px", 1, kMostFocalPx, barrier.focal_px);
    return barrier;
  }

  MarkerParameters Marker(const std::string& kind, MarkerParameters marker) {
    Color("yellow", hall_.yellow, marker.yellow);
    SearchedIn("region", kind, marker.region);
    Number("least_area_px2", 1, kMostAreaPx2, marker.least_area_px2);
    Number("most_area_px2", 1, kMostAreaPx2, marker.most_area_px2);
    if (marker.most_area_px2 < marker.least_area_px2) {
      reader_.Fault(reader_.At("most_area_px2"), "most_area_px2",
                    "must not be less than least_area_px2");
    }
    Integer("kernel_px", 1, kMostKernelPx, marker.kernel_px);
    Number("least_aspect", 0.01, 1, marker.least_aspect);
    marker.round_only = reader_.Bool("round_only").value_or(marker.round_only);
    marker.shines = reader_.Bool("shines").value_or(marker.shines);
    Number("size_m", 0.001, 10, marker.size_m);
    Number("focal_px", 1, kMostFocalPx, marker.focal_px);
    Integer("sightings", 1, kMostPictures, marker.sightings);
    Integer("misses", 1, kMostPictures, marker.misses);
    Number("passed_within_m", 0.01, 100, marker.passed_within_m);
    return marker;
  }

  ArucoParameters Aruco() {
    ArucoParameters aruco;
    aruco.dictionary = reader_
                           .Choice<ArucoDictionary>(
                               "dictionary", {{"4x4_50", ArucoDictionary::k4x4},
                                              {"5x5_50", ArucoDictionary::k5x5},
                                              {"6x6_50", ArucoDictionary::k6x6},
                                              {"apriltag_16h5", ArucoDictionary::kAprilTag16h5},
                                              {"apriltag_36h11", ArucoDictionary::kAprilTag36h11}})
                           .value_or(aruco.dictionary);
    Words("words", aruco.words);
    Integer("min_repeats", 1, kMostPictures, aruco.min_repeats);
    Number("size_m", 0.001, 10, aruco.size_m);
    Number("focal_px", 1, kMostFocalPx, aruco.focal_px);
    Number("nearly", 0, 1, aruco.nearly);
    return aruco;
  }

  QrParameters Qr() {
    QrParameters qr;
    Words("words", qr.words);
    Integer("min_repeats", 1, kMostPictures, qr.min_repeats);
    Integer("letter_repeats", 1, kMostPictures, qr.letter_repeats);
    Integer("thorough_every", 1, kMostPictures, qr.thorough_every);
    qr.letters = reader_.Bool("letters").value_or(qr.letters);
    if (const auto language = reader_.String("language")) {
      qr.language = language->text;
      if (qr.language.empty() || qr.language.find('/') != std::string::npos) {
        reader_.Fault(language->at, "language",
                      "expected a model of Tesseract, as in \"eng\" or \"eng+chi_sim\"");
      }
    }
    Number("least_confidence", 0, 100, qr.least_confidence);
    if (const auto modes = reader_.Integers("page_modes", 0, 13, {})) {
      qr.page_modes.assign(modes->begin(), modes->end());
    }
    if (reader_.Has("regions")) {
      qr.regions.clear();
      for (const config_toml::Value* value : reader_.Tables("regions")) {
        Region region;
        if (const auto* table = value->As<Table>())
          ReadRegion(*table, value->at, reader_.path() + ".regions", region, findings_);
        qr.regions.push_back(region);
      }
    }
    return qr;
  }

  NetParameters Net(const std::filesystem::path& folder) {
    NetParameters net;
    reader_.Require("model", "an ONNX file, as in \"cups.onnx\"");
    reader_.Require("labels", "what the network's classes are, as in [\"cup\", \"bottle\"]");
    Words("labels", net.labels);
    Integer("width_px", 8, kMostInputPx, net.width_px);
    Integer("height_px", 8, kMostInputPx, net.height_px);
    Number("scale", 1e-6, 1000, net.scale);
    if (const auto mean = reader_.Integers("mean", 0, 255)) Mean(*mean, net);
    net.red_first = reader_.Bool("red_first").value_or(net.red_first);
    net.keep_aspect = reader_.Bool("keep_aspect").value_or(net.keep_aspect);
    Number("least_confidence", 0.01, 1, net.least_confidence);
    Number("most_overlap", 0, 1, net.most_overlap);
    Integer("min_repeats", 1, kMostPictures, net.min_repeats);
    net.longest = reader_.Time("longest_ms").value_or(net.longest);
    Number("height_m", 0.001, 10, net.height_m);
    Number("focal_px", 1, kMostFocalPx, net.focal_px);
    const auto model = reader_.String("model");
    if (!model || net.labels.empty()) return net;
    net.model = config_toml::Absolute(folder, model->text);
    if (const auto loaded = Net::Load(net); !loaded) {
      reader_.Fault(model->at, "model", net.model + ": " + loaded.error().message);
    }
    return net;
  }

 private:
  void Mean(const std::vector<std::int64_t>& found, NetParameters& net) {
    if (found.size() != net.mean.size()) {
      reader_.Fault(reader_.At("mean"), "mean", "expected three integers, one for each channel");
      return;
    }
    std::ranges::copy(found, net.mean.begin());
  }

  void Number(std::string_view key, double least, double most, double& number) {
    number = reader_.Number(key, least, most).value_or(number);
  }

  void Integer(std::string_view key, int least, int most, int& number) {
    if (const auto found = reader_.Integer(key, least, most)) number = static_cast<int>(*found);
  }

  void Words(std::string_view key, std::vector<std::string>& words) {
    const auto found = reader_.Strings(key);
    if (!found) return;
    words.clear();
    for (const config_toml::Word& word : *found) {
      words.push_back(word.text);
      if (word.text.empty() || word.text.size() > 64) {
        reader_.Fault(word.at, key, "expected words of 1 to 64 bytes");
      }
    }
  }

  void SearchedIn(std::string_view key, Region& region) {
    ReadRegion(reader_, key, region, findings_);
  }

  // That of the hall for the kind, unless the detector has its own.
  void SearchedIn(std::string_view key, const std::string& kind, Region& region) {
    if (const auto of_hall = hall_.regions.find(kind); of_hall != hall_.regions.end()) {
      region = of_hall->second;
    }
    SearchedIn(key, region);
  }

  // That of the hall, unless the detector has its own.
  void Color(std::string_view key, const std::optional<HsvRange>& of_hall, HsvRange& range) {
    range = of_hall.value_or(range);
    ReadColor(reader_, key, range, findings_);
  }

  const Hall& hall_;
  TableReader& reader_;
  config_toml::Findings& findings_;
};

template <class Parameters>
CourseFactory FactoryWith(const Parameters& parameters,
                          std::unique_ptr<CourseDetector> (*make)(const Parameters&)) {
  return {
      [parameters, make]() -> Result<std::unique_ptr<CourseDetector>> { return make(parameters); },
      [] { return Ok(); }};
}

struct FactoryOfKind {
  CourseFactory operator()(const LinesParameters& lines) const {
    return FactoryWith(lines, MakeLinesDetector);
  }
  CourseFactory operator()(const ArrowParameters& arrow) const {
    return FactoryWith(arrow, MakeArrowDetector);
  }
  CourseFactory operator()(const BarrierParameters& barrier) const {
    return FactoryWith(barrier, MakeBarrierDetector);
  }
  CourseFactory operator()(const MarkerParameters& marker) const {
    return FactoryWith(marker, MakeMarkerDetector);
  }
  CourseFactory operator()(const ArucoParameters& aruco) const {
    return FactoryWith(aruco, MakeArucoDetector);
  }
  CourseFactory operator()(const NetParameters& net) const {
    return {[net] { return MakeNetDetector(net); }, [] { return Ok(); }};
  }
  CourseFactory operator()(const QrParameters& qr) const {
    CourseFactory factory = FactoryWith(qr, MakeQrDetector);
    factory.check = [qr] { return CheckLetters(qr); };
    return factory;
  }
};

}  // namespace

CourseParameters ReadCourseParameters(CourseKind kind, const Hall& hall, const std::string& picture,
                                      const std::filesystem::path& folder, TableReader& reader,
                                      config_toml::Findings& findings) {
  ParametersReader parameters(hall, reader, findings);
  switch (kind) {
    case CourseKind::kQr:
      return parameters.Qr();
    case CourseKind::kAruco:
      return parameters.Aruco();
    case CourseKind::kNet:
      return parameters.Net(folder);
    case CourseKind::kArrow:
      return parameters.Arrow();
    case CourseKind::kBarrier:
      return parameters.Barrier();
    case CourseKind::kMarker:
      return parameters.Marker("marker", {});
    case CourseKind::kLight:
      return parameters.Marker("light", LightParameters());
    case CourseKind::kLines:
      break;
  }
  return parameters.Lines(picture);
}

namespace {

// It shines by itself, and is at the limit of the camera in a colour.
bool IsLamp(const CourseParameters& parameters) {
  const auto* marker = std::get_if<MarkerParameters>(&parameters);
  return marker != nullptr && marker->shines;
}

}  // namespace

CourseFactory FactoryOf(const CourseParameters& parameters,
                        const std::optional<WhiteBalance>& balance) {
  CourseFactory factory = std::visit(FactoryOfKind(), parameters);
  // A network has learned the pictures of a camera as they are.
  const bool as_it_is = std::holds_alternative<QrParameters>(parameters) ||
                        std::holds_alternative<ArucoParameters>(parameters) ||
                        std::holds_alternative<NetParameters>(parameters) || IsLamp(parameters);
  if (!balance || as_it_is) return factory;
  factory.make = [make = factory.make,
                  balance = *balance]() -> Result<std::unique_ptr<CourseDetector>> {
    auto made = make();
    if (!made) return made.error();
    return WithBalance(std::move(made).value(), balance);
  };
  return factory;
}

}  // namespace musher::vision
