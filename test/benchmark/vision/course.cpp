// The detectors of a course: CPU time of a picture of 640 x 480, beside the calls of OpenCV that
// each cannot do without, in the same region. Of the reader of boards these are the grey pictures
// only: what its libraries need to read is its own. Then all shipped detectors on three cameras of
// 15 Hz, as if each had a subscriber all the time.
//
//   benchmark_course [PICTURES]

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/modules/vision/labelled/tally.hpp"

namespace musher::benchmark {
namespace {

using vision::LabelledPicture;

// A lane on a grey floor, a bar, a sign and an arrow, and noise.
cv::Mat CoursePicture(int seed) {
  cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(140, 150, 150)), noise(480, 640, CV_8UC3);
  const cv::Scalar yellow(20, 206, 246);
  cv::line(bgr, {280, 260}, {60, 479}, yellow, 24);
  cv::line(bgr, {360, 260}, {580, 479}, yellow, 24);
  cv::rectangle(bgr, cv::Rect(120, 160, 400, 40), cv::Scalar(30, 30, 200), cv::FILLED);
  cv::circle(bgr, {500, 80}, 30, yellow, cv::FILLED);
  cv::arrowedLine(bgr, {60, 80}, {180, 80}, cv::Scalar(60, 170, 40), 24, cv::LINE_AA, 0, 0.4);
  cv::RNG random(static_cast<std::uint64_t>(seed));
  random.fill(noise, cv::RNG::UNIFORM, 0, 6);
  return bgr + noise;
}

double CpuMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) / 1e6;
}

struct Turns {
  std::vector<double> detector_ms, plain_ms;
};

// One picture by one, then by the other.
Turns InTurns(const std::vector<cv::Mat>& pictures,
              const std::function<void(const cv::Mat&)>& detector,
              const std::function<void(const cv::Mat&)>& plain) {
  detector(pictures[0]);
  plain(pictures[0]);
  Turns turns;
  for (const cv::Mat& picture : pictures) {
    const double begin_ms = CpuMs();
    detector(picture);
    const double middle_ms = CpuMs();
    plain(picture);
    turns.plain_ms.push_back(CpuMs() - middle_ms);
    turns.detector_ms.push_back(middle_ms - begin_ms);
  }
  return turns;
}

// Colour to mask to outlines.
void Plain(const cv::Mat& bgr, const vision::Region& region, const vision::HsvRange& range,
           int kernel_px) {
  cv::Mat hsv, mask;
  cv::cvtColor(bgr(vision::RectOf(region, bgr.size())), hsv, cv::COLOR_BGR2HSV);
  const auto in_range = [&](int least_hue, int most_hue, cv::Mat& found) {
    cv::inRange(hsv, cv::Scalar(least_hue, range.from[1], range.from[2]),
                cv::Scalar(most_hue, range.to[1], range.to[2]), found);
  };
  if (range.from[0] <= range.to[0]) {
    in_range(range.from[0], range.to[0], mask);
  } else {  // reds
    cv::Mat others;
    in_range(0, range.to[0], mask);
    in_range(range.from[0], 179, others);
    mask |= others;
  }
  const cv::Mat kernel = cv::getStructuringElement(cv::MORPH_RECT, {kernel_px, kernel_px});
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, kernel);
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, kernel);
  std::vector<vision::Contour> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
}

struct Contest {
  const char* name;
  std::unique_ptr<vision::CourseDetector> detector;
  std::function<void(const cv::Mat&)> plain;
};

std::vector<Contest> Contests() {
  const vision::LinesParameters lines;
  const vision::ArrowParameters arrow;
  const vision::BarrierParameters barrier;
  const vision::MarkerParameters marker, light = vision::LightParameters();
  vision::QrParameters quick;
  quick.letters = false;
  quick.thorough_every = 1 << 30;  // the first look only, which is not measured
  const auto plain = [](auto region, auto range, int kernel_px) {
    return [=](const cv::Mat& bgr) { Plain(bgr, region, range, kernel_px); };
  };
  const auto grey = [](const cv::Mat& bgr) {
    cv::Mat one_channel, larger;
    cv::cvtColor(bgr, one_channel, cv::COLOR_BGR2GRAY);
    cv::resize(one_channel, larger, {}, 1.5, 1.5, cv::INTER_CUBIC);
  };
  std::vector<Contest> contests;
  contests.push_back(
      {"lines", vision::MakeLinesDetector(lines), plain(lines.region, lines.yellow, 3)});
  contests.push_back({"arrow", vision::MakeArrowDetector(arrow),
                      plain(arrow.region, arrow.green, arrow.kernel_px)});
  contests.push_back(
      {"barrier", vision::MakeBarrierDetector(barrier), plain(barrier.region, barrier.red, 3)});
  contests.push_back({"marker", vision::MakeMarkerDetector(marker),
                      plain(vision::Region{}, marker.yellow, marker.kernel_px)});
  contests.push_back({"light", vision::MakeMarkerDetector(light),
                      plain(vision::Region{}, light.yellow, light.kernel_px)});
  contests.push_back({"qr, quick look", vision::MakeQrDetector(quick), grey});
  quick.thorough_every = 1;
  contests.push_back({"qr, thorough", vision::MakeQrDetector(quick), grey});
  quick.letters = true;
  contests.push_back({"qr, thorough and letters", vision::MakeQrDetector(quick), grey});
  return contests;
}

void Compare(int count) {
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < count; ++i) pictures.push_back(CoursePicture(i));
  std::puts(
      "| detector | median, ms | p99, ms | plain OpenCV, median, ms | ratio, in turns | quartiles "
      "|\n"
      "|---|---|---|---|---|---|");
  for (Contest& contest : Contests()) {
    std::int64_t stamp_ns = 0;
    const auto look = [&](const cv::Mat& bgr) {
      contest.detector->Look(bgr, ++stamp_ns, std::nullopt);
    };
    const Turns turns = InTurns(pictures, look, contest.plain);
    const auto ratios = Ratios(turns.detector_ms, turns.plain_ms);
    std::printf("| %s | %.2f | %.2f | %.2f | %.2f | %.2f – %.2f |\n", contest.name,
                Median(turns.detector_ms), Quantile(turns.detector_ms, 0.99),
                Median(turns.plain_ms), Median(ratios), Quantile(ratios, 0.25),
                Quantile(ratios, 0.75));
    std::fflush(stdout);
  }
}

// Every table of config/vision/course.toml, on rendered pictures of the course by its camera. The
// reader of boards sees none in most of them: it looks thoroughly in each fifth.
void All(int most) {
  constexpr double kRateHz = 15;
  std::array<std::vector<LabelledPicture>, world::kCameras> pictures;
  vision::LabelledSettings settings;
  settings.lights = 4;
  using Kind = vision::CourseKind;
  SeeLabelledPictures(settings, {Kind::kQr, Kind::kArrow, Kind::kMarker, Kind::kLines},
                      [&](const LabelledPicture& picture) {
                        auto& of_camera = pictures.at(picture.camera);
                        if (of_camera.size() < static_cast<std::size_t>(most)) {
                          of_camera.push_back(picture);
                        }
                      });
  std::puts(
      "\n| detector | pictures | mean, ms | median, ms | p99, ms | % of a core at 15 Hz | at its "
      "rate |\n|---|---|---|---|---|---|---|");
  double sum = 0, sum_by_rate = 0;
  for (const vision::CourseEntry& entry : vision::ShippedDetectors()) {
    const std::size_t camera = entry.picture == "image_left"    ? 1
                               : entry.picture == "image_right" ? 2
                                                                : 0;
    const auto detector = entry.factory.make().value();
    std::vector<double> times_ms;
    double mean_ms = 0;
    std::int64_t stamp_ns = 0;
    for (const LabelledPicture& picture : pictures.at(camera)) {
      const double begin_ms = CpuMs();
      detector->Look(picture.bgr, ++stamp_ns, picture.lens);
      times_ms.push_back(CpuMs() - begin_ms);
      mean_ms += times_ms.back() / static_cast<double>(pictures.at(camera).size());
    }
    const double percent = mean_ms * kRateHz / 10;
    const double by_rate = mean_ms * std::min(kRateHz, entry.rate_hz) / 10;
    sum += percent;
    sum_by_rate += by_rate;
    std::printf("| %s | %zu | %.2f | %.2f | %.2f | %.1f | %.1f |\n", entry.name.c_str(),
                times_ms.size(), mean_ms, Median(times_ms), Quantile(times_ms, 0.99), percent,
                by_rate);
  }
  std::printf("| all | | | | | %.1f | %.1f |\n", sum, sum_by_rate);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 200;
  cv::setNumThreads(1);
  musher::benchmark::Compare(std::max(1, count));
  musher::benchmark::All(std::max(1, count));
}
