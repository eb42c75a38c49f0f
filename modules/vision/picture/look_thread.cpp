#include "musher/modules/vision/picture/look_thread.hpp"

#include <chrono>
#include <exception>
#include <string>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/modules/vision/course/course_processor.hpp"
#include "musher/modules/vision/faces/detector.hpp"

namespace musher::vision {
namespace {

constexpr Duration kNoMore = Duration::max();  // as MachineActuator::Checkpoint() has it

std::int64_t SteadyNs() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}

Error Failed(const std::string& what) {
  return {MakeCode(ModuleCode::kFace, KeyCode::kDeviceError), what};
}

Error FailedBy(const std::exception& thrown) {
  const std::string why = thrown.what();
  return Failed("the detector failed: " + why.substr(0, why.find('\n')));
}

}  // namespace

template <class D>
LookThread<D>::LookThread(transport::EventLoop& loop, Maker maker, const LookRules& rules,
                          LookThreadEvents<D> events)
    : loop_(loop),
      maker_(std::move(maker)),
      rules_(rules),
      events_(std::make_shared<const LookThreadEvents<D>>(std::move(events))),
      thread_([this] { Run(); }) {}

template <class D>
LookThread<D>::~LookThread() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  given_changed_.notify_one();
  thread_.join();
}

template <class D>
Result<> LookThread<D>::Load() {
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
Result<> LookThread<D>::LoadLocked() {
  if (detector_) return Ok();
  try {
    auto made = maker_();
    if (!made) return made.error();
    detector_ = std::move(made).value();
    return Ok();
  } catch (const std::exception& thrown) {
    return FailedBy(thrown);
  }
}

template <class D>
void LookThread<D>::Look(typename D::Input shot) {
  bool left_out = false;
  {
    const std::lock_guard lock(mutex_);
    left_out = given_.has_value();
    given_ = std::move(shot);
  }
  given_changed_.notify_one();
  if (left_out) events_->on_left_out();
}

template <class D>
Duration LookThread<D>::Busy() const {
  const std::int64_t since_ns = busy_since_ns_;
  return since_ns == 0 ? Duration::zero() : Duration(SteadyNs() - since_ns);
}

template <class D>
void LookThread<D>::Run() {
  int failures = 0;
  std::unique_lock lock(mutex_);
  while (true) {
    given_changed_.wait(lock, [this] { return ending_ || given_.has_value(); });
    if (ending_) return;
    const typename D::Input shot = std::move(*std::exchange(given_, std::nullopt));
    lock.unlock();
    LookResult<D> result = LookAt(shot);
    failures = result.found ? 0 : failures + 1;
    const std::string why = result.found ? "" : result.found.error().message;
    loop_.Post([events = std::weak_ptr(events_), result = std::move(result)]() mutable {
      if (const auto alive = events.lock()) alive->on_result(std::move(result));
    });
    if (failures >= rules_.failures) {
      return events_->on_detector_lost(
          Failed(std::to_string(failures) + " pictures in a row: " + why));
    }
    lock.lock();
  }
}

template <class D>
LookResult<D> LookThread<D>::LookAt(const typename D::Input& shot) {
  const std::int64_t begin_ns = SteadyNs();
  busy_since_ns_ = begin_ns;
  events_->checkpoint(rules_.hang);
  LookResult<D> result{shot.stamp_ns, shot.picture.width, shot.picture.height, Process(shot), {}};
  events_->checkpoint(kNoMore);
  busy_since_ns_ = 0;
  result.took = Duration(SteadyNs() - begin_ns);
  return result;
}

template <class D>
Result<typename D::Found> LookThread<D>::Process(const typename D::Input& shot) {
  const std::lock_guard lock(detector_mutex_);
  if (Result<> loaded = LoadLocked(); !loaded) return loaded.error();
  try {
    return detector_->Process(shot);
  } catch (const std::exception& thrown) {
    detector_.reset();
    return FailedBy(thrown);
  } catch (...) {
    detector_.reset();
    return Failed("the detector failed");
  }
}

template class LookThread<Detector>;
template class LookThread<CourseProcessor>;

}  // namespace musher::vision
