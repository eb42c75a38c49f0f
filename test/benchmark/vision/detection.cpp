// What the detectors of config/vision/course.toml find in rendered pictures of the course with
// labels: found, missed and falsely found, by distance and angle; the error of the distances; how
// many codes are read by their size in the picture; the CPU time of a picture.
//
//   benchmark_detection [--lights N] [--seed S] [--kind arrow] [--missed DIR]
//
// See test/modules/vision/labelled: the same seed and number of lights give the same pictures. The
// reader of boards looks thoroughly in each picture here, on the robot in each fifth.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/modules/vision/labelled/tally.hpp"

namespace musher::benchmark {
namespace {

using vision::CourseKind;
using vision::LabelledPicture;
using vision::Tally;

const std::vector<std::pair<CourseKind, const char*>> kKinds{
    {CourseKind::kQr, "qr"},           {CourseKind::kArrow, "arrow"},
    {CourseKind::kBarrier, "barrier"}, {CourseKind::kMarker, "marker"},
    {CourseKind::kLight, "light"},     {CourseKind::kLines, "lines"}};

double CpuMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) / 1e6;
}

using Cells = std::map<std::pair<double, double>, Tally>;  // by distance and angle

struct Score {
  Cells cells;
  int pictures = 0, without = 0;  // the thing
  std::vector<double> times_ms;
};

// Of codes, by their size in the picture.
struct Reading {
  int shown = 0, quick = 0, thorough = 0;
};
constexpr int kSizeStepPx = 20;
using Readings = std::map<std::pair<int, double>, Reading>;

class Examination {
 public:
  explicit Examination(std::string missed_folder) : missed_folder_(std::move(missed_folder)) {
    for (const vision::CourseEntry& entry : vision::ShippedDetectors()) entries_.push_back(entry);
  }

  void See(const LabelledPicture& picture) {
    Score& score = scores_[picture.kind];
    ++(picture.there ? score.pictures : score.without);
    const vision::CourseEntry& entry = DetectorOf(entries_, picture.kind, picture.camera);
    vision::CourseDetector& detector = *Made(entry);
    const double begin_ms = CpuMs();
    const vision::CourseSight sight = detector.Look(picture.bgr, ++stamp_ns_, picture.lens);
    score.times_ms.push_back(CpuMs() - begin_ms);
    Tally all;
    if (sight.lines) {
      const auto& parameters = std::get<vision::LinesParameters>(entry.parameters);
      const auto tallies = TallyOfLines(*sight.lines, parameters, picture);
      for (std::size_t i = 0; i < tallies.size(); ++i) {
        score.cells[{vision::kLineRangesM.at(i), picture.cell.angle_deg}].Add(tallies.at(i));
        all.Add(tallies.at(i));
      }
    } else {
      all = TallyOf(sight, picture);
      score.cells[{picture.cell.distance_m, picture.cell.angle_deg}].Add(all);
    }
    if (picture.kind == CourseKind::kQr && picture.there) Read(picture);
    if (!missed_folder_.empty() && (all.missed() > 0 || all.false_finds > 0)) {
      Save(picture, detector, all);
    }
  }

  void Print() const {
    for (const auto& [kind, name] : kKinds) {
      if (scores_.contains(kind)) Print(name, kind, scores_.at(kind));
    }
    if (!readings_.empty()) PrintReadings();
  }

 private:
  vision::CourseDetector* Made(const vision::CourseEntry& entry) {
    auto& detector = detectors_[entry.name];
    if (!detector && entry.kind == CourseKind::kQr) {
      auto parameters = std::get<vision::QrParameters>(entry.parameters);
      parameters.thorough_every = 1;
      detector = vision::MakeQrDetector(parameters);
    } else if (!detector) {
      detector = entry.factory.make().value();
    }
    return detector.get();
  }

  void Read(const LabelledPicture& picture) {
    const int size_px = static_cast<int>(picture.box.height) / kSizeStepPx * kSizeStepPx;
    Reading& reading = readings_[{size_px, picture.cell.angle_deg}];
    ++reading.shown;
    const auto says = [&](const auto& code) { return code && code->content == picture.text; };
    const bool quick = says(vision::FindCode(picture.bgr));
    if (quick) ++reading.quick;
    if (quick || says(vision::FindCodeThoroughly(picture.bgr))) ++reading.thorough;
  }

  void Save(const LabelledPicture& picture, const vision::CourseDetector& detector,
            const Tally& tally) {
    cv::Mat drawn = picture.bgr.clone();
    detector.Draw(drawn);
    char name[160];
    std::snprintf(name, sizeof name, "%s/%d-%.1fm-%.0fdeg-cam%zu-%s-%d-%d-%lld",
                  missed_folder_.c_str(), static_cast<int>(picture.kind), picture.cell.distance_m,
                  picture.cell.angle_deg, picture.camera, picture.there ? "with" : "without",
                  tally.missed(), tally.false_finds, static_cast<long long>(stamp_ns_));
    cv::imwrite(std::string(name) + ".png", picture.bgr);
    cv::imwrite(std::string(name) + "-drawn.png", drawn);
  }

  static void Print(const char* name, CourseKind kind, const Score& score) {
    const bool lines = kind == CourseKind::kLines;
    std::printf("\n### %s: %d pictures with, %d without; CPU %.2f ms, p99 %.2f\n\n", name,
                score.pictures, score.without, Median(score.times_ms),
                Quantile(score.times_ms, 0.99));
    std::map<double, std::map<double, const Tally*>> rows;
    std::map<double, bool> angles;
    Tally sum;
    for (const auto& [cell, tally] : score.cells) {
      rows[cell.first][cell.second] = &tally;
      angles[cell.second] = true;
      sum.Add(tally);
    }
    std::printf("%s", lines ? "Columns: found / missed / false; distance from the robot\n\n| m |"
                            : "Found / missed / false, the latter also without it\n\n| m |");
    for (const auto& [angle, known] : angles) std::printf(" %.0f° |", angle);
    std::printf("\n|---|");
    for (std::size_t i = 0; i < angles.size(); ++i) std::printf("---|");
    std::printf("\n");
    for (const auto& [distance, row] : rows) {
      std::printf("| %.1f |", distance);
      for (const auto& [angle, known] : angles) {
        const auto tally = row.find(angle);
        if (tally == row.end()) {
          std::printf(" – |");
        } else {
          const Tally& of = *tally->second;
          std::printf(" %d / %d / %d |", of.found, of.missed(), of.false_finds);
        }
      }
      std::printf("\n");
    }
    std::printf("| all | found %d of %d, false %d; without it %d |", sum.found, sum.shown,
                sum.false_finds, sum.absent);
    if (!sum.errors.empty()) {
      const double unit = 100;
      std::printf(" error %+.1f (%+.1f to %+.1f) %s, 1 %% to 99 %% |", unit * Median(sum.errors),
                  unit * Quantile(sum.errors, 0.01), unit * Quantile(sum.errors, 0.99),
                  lines ? "cm" : "%");
    }
    std::printf("\n");
  }

  void PrintReadings() const {
    std::printf("\n### Codes read, by their size in the picture and their angle\n\n");
    std::printf(
        "| px | angle | codes | read quickly | with a thorough look |\n|---|---|---|---|---|\n");
    for (const auto& [at, reading] : readings_) {
      std::printf("| %d – %d | %.0f° | %d | %d | %d |\n", at.first, at.first + kSizeStepPx - 1,
                  at.second, reading.shown, reading.quick, reading.thorough);
    }
  }

  const std::string missed_folder_;
  std::vector<vision::CourseEntry> entries_;
  std::map<std::string, std::unique_ptr<vision::CourseDetector>> detectors_;
  std::map<CourseKind, Score> scores_;
  Readings readings_;
  std::int64_t stamp_ns_ = 0;
};

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  using namespace musher;
  vision::LabelledSettings settings;
  std::string kind, missed;
  CLI::App app("What the detectors of a course find in pictures with labels.",
               "benchmark_detection");
  app.add_option("--lights", settings.lights, "Pictures for each distance and angle");
  app.add_option("--seed", settings.seed, "Of lights, poses and noise");
  app.add_option("--kind", kind, "qr, arrow, barrier, marker, light or lines alone");
  app.add_option("--missed", missed, "A folder for the pictures with a miss or a false find");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  std::vector<vision::CourseKind> kinds;
  for (const auto& [each, name] : benchmark::kKinds) {
    if (kind.empty() || kind == name) kinds.push_back(each);
  }
  benchmark::Examination examination(missed);
  SeeLabelledPictures(settings, kinds,
                      [&](const vision::LabelledPicture& picture) { examination.See(picture); });
  examination.Print();
  return 0;
}
