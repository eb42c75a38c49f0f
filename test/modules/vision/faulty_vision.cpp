// musher-vision-manager with detectors controlled by the file `detector` of its working folder:
// "throw", "hang" until the other end of the fifo `gate` is opened, or nothing.

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/vision/vision_manager.hpp"

namespace musher::vision {
namespace {

std::string Mode() {
  std::string mode;
  std::ifstream("detector") >> mode;
  return mode;
}

void Misbehave() {
  if (Mode() == "hang") std::ifstream("gate").peek();
  if (Mode() == "throw") throw std::runtime_error("by the test");
}

class FaultyDetector : public Detector {
 public:
  std::vector<FaceBox> Detect(const msg::Image&) override {
    Misbehave();
    return {};
  }
};

class FaultyCourseDetector : public CourseDetector {
 public:
  CourseSight Look(const cv::Mat&, std::int64_t, const std::optional<Lens>&) override {
    Misbehave();
    return {std::nullopt, std::nullopt, "found"};
  }
  void Draw(cv::Mat&) const override {}
};

int Run(const program::Options& options) {
  const Parsed<VisionConfig> reading = ReadVisionFile(options.file);
  program::PrintErrors(reading.diagnostics);
  if (!reading.config) return program::kUsageError;
  VisionConfig config = *reading.config;
  config.still = {};  // the test has one picture
  for (CourseEntry& entry : config.detectors) {
    entry.factory = {[] { return std::unique_ptr<CourseDetector>(new FaultyCourseDetector); },
                     [] { return Ok(); }};
  }
  VisionManager manager(options.actuator, config,
                        [] { return std::unique_ptr<Detector>(new FaultyDetector); });
  return program::RunToEnd(manager, options.state_config);
}

}  // namespace
}  // namespace musher::vision

int main(int argc, char** argv) {
  return musher::program::Main(argc, argv, {"faulty-vision", "For tests.", ""},
                               musher::vision::Run);
}
