#include "musher/modules/vision/course/course_parameters.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace musher::vision {
namespace {

using config_toml::Table;
using config_toml::TableReader;

constexpr double kMostAreaPx2 = 8192.0 * 8192;  // of a picture that CheckPicture() accepts
constexpr double kMostFocalPx = 10'000;
constexpr int kMostKernelPx = 99;
constexpr int kMostPictures = 1000;

class ParametersReader {
 public:
  ParametersReader(TableReader& reader, config_toml::Findings& findings)
      : reader_(reader), findings_(findings) {}

  LinesParameters Lines() {
    LinesParameters lines;
    Color("yellow", lines.yellow);
    SearchedIn("region", lines.region);
    Number("least_area_px2", 1, kMostAreaPx2, lines.least_area_px2);
    Number("least_length", 0, 100, lines.least_length);
    Integer("most_lines", 1, 100, lines.most_lines);
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
    return lines;
  }

  ArrowParameters Arrow() {
    ArrowParameters arrow;
    Color("green", arrow.green);
    SearchedIn("region", arrow.region);
    Number("least_area_px2", 1, kMostAreaPx2, arrow.least_area_px2);
    Integer("kernel_px", 1, kMostKernelPx, arrow.kernel_px);
    Number("most_misfit", 0.001, 1, arrow.most_misfit);
    Number("clearly", 1, 100, arrow.clearly);
    return arrow;
  }

  BarrierParameters Barrier() {
    BarrierParameters barrier;
    Color("red", barrier.red);
    SearchedIn("region", barrier.region);
    Number("least_area_px2", 1, kMostAreaPx2, barrier.least_area_px2);
    Number("least_length", 1, 100, barrier.least_length);
    Number("least_fill", 0.01, 1, barrier.least_fill);
    Number("most_tilt_deg", 0, 90, barrier.most_tilt_deg);
    Number("top", 0, 1, barrier.top);
    Number("height_m", 0.001, 10, barrier.height_m);
    Number("focal_px", 1, kMostFocalPx, barrier.focal_px);
    return barrier;
  }

  MarkerParameters Marker(MarkerParameters marker) {
    Color("yellow", marker.yellow);
    SearchedIn("region", marker.region);
    Number("least_area_px2", 1, kMostAreaPx2, marker.least_area_px2);
    Number("most_area_px2", 1, kMostAreaPx2, marker.most_area_px2);
    if (marker.most_area_px2 < marker.least_area_px2) {
      reader_.Fault(reader_.At("most_area_px2"), "most_area_px2",
                    "must not be less than least_area_px2");
    }
    Integer("kernel_px", 1, kMostKernelPx, marker.kernel_px);
    Number("least_aspect", 0.01, 1, marker.least_aspect);
    marker.round_only = reader_.Bool("round_only").value_or(marker.round_only);
    Number("size_m", 0.001, 10, marker.size_m);
    Number("focal_px", 1, kMostFocalPx, marker.focal_px);
    Integer("sightings", 1, kMostPictures, marker.sightings);
    Integer("misses", 1, kMostPictures, marker.misses);
    return marker;
  }

  QrParameters Qr() {
    QrParameters qr;
    if (const auto words = reader_.Strings("words")) {
      qr.words.clear();
      for (const config_toml::Word& word : *words) {
        qr.words.push_back(word.text);
        if (word.text.empty() || word.text.size() > 64) {
          reader_.Fault(word.at, "words", "expected words of 1 to 64 bytes");
        }
      }
    }
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
          ReadRegion(*table, value->at, "regions", region);
        qr.regions.push_back(region);
      }
    }
    return qr;
  }

 private:
  void Number(std::string_view key, double least, double most, double& number) {
    number = reader_.Number(key, least, most).value_or(number);
  }

  void Integer(std::string_view key, int least, int most, int& number) {
    if (const auto found = reader_.Integer(key, least, most)) number = static_cast<int>(*found);
  }

  std::string Path(std::string_view key) const { return reader_.path() + "." + std::string(key); }

  void SearchedIn(std::string_view key, Region& region) {
    const Table* table = reader_.SubTable(key);
    if (table != nullptr) ReadRegion(*table, reader_.At(key), key, region);
  }

  void ReadRegion(const Table& table, config_toml::Position at, std::string_view key,
                  Region& region) {
    TableReader reader(table, at, Path(key), findings_);
    region.top = reader.Number("top", 0, 1).value_or(region.top);
    region.bottom = reader.Number("bottom", 0, 1).value_or(region.bottom);
    region.left = reader.Number("left", 0, 1).value_or(region.left);
    region.right = reader.Number("right", 0, 1).value_or(region.right);
    reader.RefuseOthers();
    if (region.bottom <= region.top) {
      reader.Fault(reader.At("bottom"), "bottom", "must be more than top: y is downwards");
    }
    if (region.right <= region.left) {
      reader.Fault(reader.At("right"), "right", "must be more than left");
    }
  }

  void Color(std::string_view key, HsvRange& range) {
    const Table* table = reader_.SubTable(key);
    if (table == nullptr) return;
    TableReader reader(*table, reader_.At(key), Path(key), findings_);
    ReadHsv(reader, "from", range.from);
    ReadHsv(reader, "to", range.to);
    reader.RefuseOthers();
    for (const std::size_t i : {1, 2}) {
      if (range.from.at(i) <= range.to.at(i)) continue;
      reader.Fault(reader.At("to"), "to",
                   std::string(i == 1 ? "the saturation" : "the value") +
                       " must not be less than that of from; only a hue may go through 0");
    }
  }

  static void ReadHsv(TableReader& reader, std::string_view key, std::array<int, 3>& hsv) {
    constexpr std::array<std::int64_t, 3> kMost = {179, 255, 255};
    const auto found = reader.Integers(key, INT32_MIN, INT32_MAX);
    if (!found) return;
    bool valid = found->size() == kMost.size();
    for (std::size_t i = 0; valid && i < kMost.size(); ++i) {
      valid = (*found)[i] >= 0 && (*found)[i] <= kMost.at(i);
    }
    if (!valid) {
      return reader.Fault(reader.At(key), key,
                          "expected [hue 0 to 179, saturation 0 to 255, value 0 to 255]");
    }
    std::transform(found->begin(), found->end(), hsv.begin(),
                   [](std::int64_t number) { return static_cast<int>(number); });
  }

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
  CourseFactory operator()(const QrParameters& qr) const {
    CourseFactory factory = FactoryWith(qr, MakeQrDetector);
    factory.check = [qr] { return CheckLetters(qr); };
    return factory;
  }
};

}  // namespace

CourseParameters ReadCourseParameters(CourseKind kind, TableReader& reader,
                                      config_toml::Findings& findings) {
  ParametersReader parameters(reader, findings);
  switch (kind) {
    case CourseKind::kQr:
      return parameters.Qr();
    case CourseKind::kArrow:
      return parameters.Arrow();
    case CourseKind::kBarrier:
      return parameters.Barrier();
    case CourseKind::kMarker:
      return parameters.Marker({});
    case CourseKind::kLight:
      return parameters.Marker(LightParameters());
    case CourseKind::kLines:
      break;
  }
  return parameters.Lines();
}

CourseFactory FactoryOf(const CourseParameters& parameters) {
  return std::visit(FactoryOfKind(), parameters);
}

}  // namespace musher::vision
