#pragma once
// One detector of a course in the module: its topics, and the detector on a thread of its own.
//
// Threads: Load() from any; the constructor, the destructor of the topics and all else on the loop.

#include <functional>
#include <memory>
#include <string>

#include "musher/modules/vision/course/course_topics.hpp"
#include "musher/modules/vision/picture/detector_thread.hpp"

namespace musher::vision {

// What the module does with its detectors.
struct DetectionEvents {
  std::function<void(Duration)> checkpoint;   // on the detector's thread: see MachineActuator
  std::function<void(const Error&)> on_lost;  // on the detector's thread, as its last call
};

class CourseDetection {
 public:
  static Result<std::unique_ptr<CourseDetection>> Make(const Dependencies& dependencies,
                                                       const CourseEntry& entry, Duration silence,
                                                       const DetectionEvents& events);

  // Checks what the detector needs, and creates it, unless it exists. Fails with the reason. One
  // call at a time.
  Result<> Load();

  CourseTopics& topics() { return *topics_; }
  // Ends the topics; the destructor then waits for the picture that is being processed, and may run
  // on another thread.
  void CloseTopics() { topics_.reset(); }
  const std::string& name() const { return name_; }

 private:
  CourseDetection(const Dependencies& dependencies, const CourseEntry& entry,
                  const DetectionEvents& events);

  const std::string name_;
  const std::function<Result<>()> check_;
  bool is_checked_ = false;
  DetectorThread<CourseProcessor> thread_;
  std::unique_ptr<CourseTopics> topics_;
};

}  // namespace musher::vision
