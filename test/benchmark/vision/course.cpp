// The detectors of a course: CPU time of a picture of 640 x 480, beside the calls of OpenCV that
// each cannot do without, in the same region. Of the reader of boards these are the grey pictures
// only: what its libraries need to read is its own.
//
//   benchmark_course [PICTURES]

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/test/benchmark/common/statistics.hpp"

namespace musher::benchmark {
namespace {

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

std::vector<double> Times(const std::vector<cv::Mat>& pictures,
                          const std::function<void(const cv::Mat&)>& look) {
  look(pictures[0]);
  std::vector<double> times;
  for (const cv::Mat& picture : pictures) {
    const double begin_ms = CpuMs();
    look(picture);
    times.push_back(CpuMs() - begin_ms);
  }
  return times;
}

// Colour to mask to outlines.
void Plain(const cv::Mat& bgr, const vision::Region& region, const vision::HsvRange& range,
           int kernel_px) {
  cv::Mat hsv, mask;
  cv::cvtColor(bgr(vision::RectOf(region, bgr.size())), hsv, cv::COLOR_BGR2HSV);
  cv::inRange(hsv, cv::Scalar(range.from[0] % 170, range.from[1], range.from[2]),
              cv::Scalar(range.to[0], range.to[1], range.to[2]), mask);
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

void Run(int count) {
  cv::setNumThreads(1);
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < count; ++i) pictures.push_back(CoursePicture(i));
  std::puts(
      "| detector | median, ms | p99, ms | plain OpenCV, median, ms | ratio of medians | ratio of "
      "p99 |\n"
      "|---|---|---|---|---|---|");
  for (Contest& contest : Contests()) {
    std::int64_t stamp_ns = 0;
    const auto detector = Times(pictures, [&](const cv::Mat& bgr) {
      contest.detector->Look(bgr, ++stamp_ns, std::nullopt);
    });
    const auto plain = Times(pictures, contest.plain);
    const double p99 = Quantile(detector, 0.99), plain_p99 = Quantile(plain, 0.99);
    std::printf("| %s | %.2f | %.2f | %.2f | %.2f | %.2f |\n", contest.name, Median(detector), p99,
                Median(plain), Median(detector) / Median(plain), p99 / plain_p99);
  }
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 200;
  musher::benchmark::Run(count > 0 ? count : 1);
}
