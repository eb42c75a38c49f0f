#pragma once
// A detector on a thread of its own.
//
// A picture that is not begun when the next one arrives is dropped. A detector that throws is
// replaced by a new one; after `failures` failures in a row it is given up.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "musher/base/work_queue.hpp"
#include "musher/modules/vision/picture/detector_worker.hpp"
#include "musher/modules/vision/picture/vision_code.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::vision {

template <class D>
struct DetectorThreadEvents {
  std::function<void(DetectionResult<D>)> on_result;  // on the loop
  std::function<void()> on_left_out;                  // on the loop: a newer picture took its place
  std::function<void(Duration)> checkpoint;           // on the thread: see MachineActuator
  std::function<void(const Error&)> on_detector_lost;  // on the thread, as its last call
};

template <class D>
class DetectorThread : public DetectorWorker<D> {
 public:
  using Maker = std::function<Result<std::unique_ptr<D>>()>;  // called on the thread and in Load()

  // The loop must outlive it; no callbacks after its destruction, which waits for a picture that is
  // being processed.
  DetectorThread(transport::EventLoop& loop, Maker maker, const DetectorLimits& rules,
                 DetectorThreadEvents<D> events);
  DetectorThread(const DetectorThread&) = delete;
  DetectorThread& operator=(const DetectorThread&) = delete;

  Result<> Load() override;
  void Submit(typename D::Input shot) override;
  Duration Busy() const override;

 private:
  void Run(const typename D::Input& shot);
  DetectionResult<D> RunDetector(const typename D::Input& shot);
  Result<typename D::Found> Process(const typename D::Input& shot);
  Result<> LoadLocked();

  transport::EventLoop& loop_;
  const Maker maker_;
  const DetectorLimits rules_;
  // Shared with work posted to the loop, which may run after the destruction.
  const std::shared_ptr<const DetectorThreadEvents<D>> events_;
  std::atomic<std::int64_t> busy_since_ns_ = 0;  // of the steady clock; 0: not busy
  std::mutex detector_mutex_;                    // guards detector_; held while it is used
  std::unique_ptr<D> detector_;
  int failures_ = 0;  // in a row; of the thread
  WorkQueue thread_;  // last: it uses the rest
};

// --- the definitions ---

namespace detector_thread {

inline constexpr Duration kNoMore = Duration::max();  // as MachineActuator::Checkpoint() has it

inline std::int64_t SteadyNs() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}

inline Error Failed(const std::string& what) {
  return {VisionCode(KeyCode::kDeviceError), what};
}

inline Error FailedBy(const std::exception& thrown) {
  const std::string why = thrown.what();
  return Failed("the detector failed: " + why.substr(0, why.find('\n')));
}

}  // namespace detector_thread

template <class D>
DetectorThread<D>::DetectorThread(transport::EventLoop& loop, Maker maker,
                                  const DetectorLimits& rules, DetectorThreadEvents<D> events)
    : loop_(loop),
      maker_(std::move(maker)),
      rules_(rules),
      events_(std::make_shared<const DetectorThreadEvents<D>>(std::move(events))),
      thread_({.name = "detector", .at_end = WorkQueueOptions::AtEnd::kDrop}) {}

template <class D>
Result<> DetectorThread<D>::Load() {
  // A detector that is processing a picture exists, and may be busy for long, even if it has just
  // begun. (Not a timed_mutex: GCC 12's thread sanitizer does not see how that is locked.)
  std::unique_lock lock(detector_mutex_, std::defer_lock);
  while (busy_since_ns_ == 0) {
    if (lock.try_lock()) return LoadLocked();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return Ok();
}

template <class D>
Result<> DetectorThread<D>::LoadLocked() {
  if (detector_) return Ok();
  try {
    auto made = maker_();
    if (!made) return made.error();
    detector_ = std::move(made).value();
    return Ok();
  } catch (const std::exception& thrown) {
    return detector_thread::FailedBy(thrown);
  }
}

template <class D>
void DetectorThread<D>::Submit(typename D::Input shot) {
  const auto given = thread_.Do([this, shot = std::move(shot)] { Run(shot); }, {.key = "picture"});
  if (given == WorkQueue::Given::kReplaced) events_->on_left_out();
}

template <class D>
Duration DetectorThread<D>::Busy() const {
  const std::int64_t since_ns = busy_since_ns_;
  return since_ns == 0 ? Duration::zero() : Duration(detector_thread::SteadyNs() - since_ns);
}

template <class D>
void DetectorThread<D>::Run(const typename D::Input& shot) {
  if (failures_ >= rules_.failures) return;  // it is given up
  DetectionResult<D> result = RunDetector(shot);
  failures_ = result.found ? 0 : failures_ + 1;
  const std::string why = result.found ? "" : result.found.error().message;
  loop_.Post([events = std::weak_ptr(events_), result = std::move(result)]() mutable {
    if (const auto alive = events.lock()) alive->on_result(std::move(result));
  });
  if (failures_ < rules_.failures) return;
  events_->on_detector_lost(
      detector_thread::Failed(std::to_string(failures_) + " pictures in a row: " + why));
}

template <class D>
DetectionResult<D> DetectorThread<D>::RunDetector(const typename D::Input& shot) {
  const std::int64_t begin_ns = detector_thread::SteadyNs();
  busy_since_ns_ = begin_ns;
  events_->checkpoint(rules_.hang);
  DetectionResult<D> result{
      shot.stamp_ns, shot.picture.width, shot.picture.height, Process(shot), {}};
  events_->checkpoint(detector_thread::kNoMore);
  busy_since_ns_ = 0;
  result.took = Duration(detector_thread::SteadyNs() - begin_ns);
  return result;
}

template <class D>
Result<typename D::Found> DetectorThread<D>::Process(const typename D::Input& shot) {
  const std::lock_guard lock(detector_mutex_);
  if (Result<> loaded = LoadLocked(); !loaded) return loaded.error();
  try {
    return detector_->Process(shot);
  } catch (const std::exception& thrown) {
    detector_.reset();
    return detector_thread::FailedBy(thrown);
  } catch (...) {
    detector_.reset();
    return detector_thread::Failed("the detector failed");
  }
}

}  // namespace musher::vision
