#pragma once
// A detector on a thread of its own.
//
// A picture that is not begun when the next one arrives is dropped. A detector that throws is
// replaced by a new one; after `failures` failures in a row it is given up.
//
// Instantiated in look_thread.cpp for each kind of detector.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "musher/modules/vision/picture/looker.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::vision {

template <class D>
struct LookThreadEvents {
  std::function<void(LookResult<D>)> on_result;  // on the loop
  std::function<void()> on_left_out;             // on the loop: a newer picture took its place
  std::function<void(Duration)> checkpoint;      // on the thread: see MachineActuator
  std::function<void(const Error&)> on_detector_lost;  // on the thread, as its last call
};

template <class D>
class LookThread : public Looker<D> {
 public:
  using Maker = std::function<Result<std::unique_ptr<D>>()>;  // called on the thread and in Load()

  // The loop must outlive it; no callbacks after its destruction.
  LookThread(transport::EventLoop& loop, Maker maker, const LookRules& rules,
             LookThreadEvents<D> events);
  // Waits for a picture that is being processed.
  ~LookThread() override;
  LookThread(const LookThread&) = delete;
  LookThread& operator=(const LookThread&) = delete;

  Result<> Load() override;
  void Look(typename D::Input shot) override;
  Duration Busy() const override;

 private:
  void Run();
  LookResult<D> LookAt(const typename D::Input& shot);
  Result<typename D::Found> Process(const typename D::Input& shot);
  Result<> LoadLocked();

  transport::EventLoop& loop_;
  const Maker maker_;
  const LookRules rules_;
  // Shared with work posted to the loop, which may run after the destruction.
  const std::shared_ptr<const LookThreadEvents<D>> events_;
  std::atomic<std::int64_t> busy_since_ns_ = 0;  // of the steady clock; 0: not busy
  std::mutex detector_mutex_;                    // guards detector_; held while it is used
  std::unique_ptr<D> detector_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable given_changed_;
  std::optional<typename D::Input> given_;
  bool ending_ = false;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace musher::vision
