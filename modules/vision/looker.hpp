#pragma once
// Detects faces beside the loop: a detector takes some milliseconds for a picture, or many.
//
// A picture that is not begun when the next one arrives is dropped. A detector that throws is
// replaced by a new one; after `failures` failures in a row it is given up.
//
// Threads: Load() and Busy() from any; Look() on the loop, where the results are delivered.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "musher/modules/vision/detector.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::vision {

struct LookResult {
  std::int64_t stamp_ns = 0;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  Result<std::vector<FaceBox>> faces;  // or how the detector failed
  Duration took{};
};

class Looker {
 public:
  virtual ~Looker() = default;

  // Creates the detector, unless it exists. Fails with the reason.
  virtual Result<> Load() = 0;

  // The newest picture; on_result gets its result later.
  virtual void Look(std::int64_t stamp_ns, msg::Image picture) = 0;

  // How long the detector has been processing the same picture; zero: none.
  virtual Duration Busy() const = 0;
};

struct LookThreadEvents {
  std::function<void(LookResult)> on_result;  // on the loop
  std::function<void()> on_left_out;          // on the loop: a newer picture took its place
  std::function<void(Duration)> checkpoint;   // on the thread: see MachineActuator
  std::function<void(const Error&)> on_detector_lost;  // on the thread, as its last call
};

class LookThread : public Looker {
 public:
  struct Rules {
    Duration hang = Milliseconds(5000);  // a picture that takes longer: the detector hangs
    int failures = 5;                    // in a row, after which the detector is lost
  };

  // The loop must outlive it; no callbacks after its destruction.
  LookThread(transport::EventLoop& loop, DetectorMaker maker, const Rules& rules,
             LookThreadEvents events);
  // Waits for a picture that is being processed.
  ~LookThread() override;
  LookThread(const LookThread&) = delete;
  LookThread& operator=(const LookThread&) = delete;

  Result<> Load() override;
  void Look(std::int64_t stamp_ns, msg::Image picture) override;
  Duration Busy() const override;

 private:
  struct Given {
    std::int64_t stamp_ns = 0;
    msg::Image picture;
  };
  void Run();
  LookResult LookAt(const Given& given);
  Result<std::vector<FaceBox>> Detect(const msg::Image& picture);
  Result<> LoadLocked();

  transport::EventLoop& loop_;
  const DetectorMaker maker_;
  const Rules rules_;
  // Shared with work posted to the loop, which may run after the destruction.
  const std::shared_ptr<const LookThreadEvents> events_;
  std::atomic<std::int64_t> busy_since_ns_ = 0;  // of the steady clock; 0: not busy
  std::mutex detector_mutex_;                    // guards detector_; held while it is used
  std::unique_ptr<Detector> detector_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable given_changed_;
  std::optional<Given> given_;
  bool ending_ = false;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace musher::vision
