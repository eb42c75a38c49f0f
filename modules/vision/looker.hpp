#pragma once
// Looks for faces beside the loop: a picture takes a detector some milliseconds or many.
//
// A picture that is not begun when the next one is given is left out. A detector that throws is
// replaced by a new one; one that fails `failures` times in a row is given up.
//
// Threads: Load() and Busy() from any; Look() on the loop, where results come out.

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

  // Makes the detector, unless it is there. Fails with what is wrong with it.
  virtual Result<> Load() = 0;

  // The newest picture; on_result, of Begin(), has its result later.
  virtual void Look(std::int64_t stamp_ns, msg::Image picture) = 0;

  // For how long the detector has been at the same picture; zero: it is at none.
  virtual Duration Busy() const = 0;
};

struct LookThreadEvents {
  std::function<void(LookResult)> on_result;  // on the loop
  std::function<void()> on_left_out;          // on the loop: a newer picture took its place
  std::function<void(Duration)> checkpoint;   // on the thread: see MachineActuator
  std::function<void(const Error&)> on_detector_lost;  // on the thread, its last word
};

class LookThread : public Looker {
 public:
  struct Rules {
    Duration hang = Milliseconds(5000);  // a picture takes less, or the detector hangs
    int failures = 5;                    // in a row: the detector is lost
  };

  // The loop must outlive it, and nothing comes out once it is dropped.
  LookThread(transport::EventLoop& loop, DetectorMaker maker, const Rules& rules,
             LookThreadEvents events);
  // Waits for a picture that it is at.
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
  // Shared with what is posted to the loop, which may come after this is gone.
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
