#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

#include "musher/modules/camera/media.hpp"
#include "musher/modules/camera/source.hpp"

namespace musher::camera {
namespace {

constexpr double kVideoHz = 25;  // of a video without a rate
constexpr double kFolderHz = 1;

// Shared by the thread and the loop; outlives the source while the thread is still in its device.
class Mailbox : public std::enable_shared_from_this<Mailbox> {
 public:
  Mailbox(transport::EventLoop& loop, SourceEvents events)
      : loop_(loop), events_(std::move(events)) {}

  // On the loop: from then on nothing is delivered, and the loop is not used any more.
  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

  // All of the following on the thread.
  bool closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }
  // False when the source was destroyed meanwhile.
  bool WaitUntil(Time when) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_until(lock, when, [this] { return closed_; });
  }
  void Put(msg::Image picture) {
    const std::lock_guard lock(mutex_);
    const bool waits = std::exchange(picture_, std::move(picture)).has_value();
    if (!closed_ && !waits) Post();
  }
  // The last call; no error: the end.
  void End(std::optional<Error> error) {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    error_ = std::move(error);
    if (!closed_) Post();
  }

 private:
  // With the lock held: the loop exists as long as this is not closed.
  void Post() {
    loop_.Post([self = shared_from_this()] { self->Deliver(); });
  }

  void Deliver() {
    std::unique_lock lock(mutex_);
    if (closed_) return;
    std::optional<msg::Image> picture = std::exchange(picture_, std::nullopt);
    const bool ended = ended_;
    const std::optional<Error> error = error_;
    lock.unlock();
    const auto self = shared_from_this();  // a callback may destroy the source
    if (picture) events_.on_frame(std::move(*picture));
    if (!ended || closed()) return;
    error ? events_.on_failed(*error) : events_.on_ended();
  }

  transport::EventLoop& loop_;
  const SourceEvents events_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool closed_ = false;
  std::optional<msg::Image> picture_;  // not taken yet
  bool ended_ = false;
  std::optional<Error> error_;
};

Result<std::unique_ptr<PictureReader>> Open(const CameraConfig& camera) {
  const Result<Media*> media = LoadMedia();
  if (!media) return media.error();
  switch (camera.source) {
    case SourceKind::kVideo:
      return media.value()->OpenVideo(camera.from);
    case SourceKind::kFolder:
      return media.value()->OpenFolder(camera.from);
    default:
      return media.value()->OpenDevice(
          camera.from, {camera.format.width_px, camera.format.height_px, camera.rate_hz});
  }
}

// Paces a source that has no pace of its own.
Duration Period(const CameraConfig& camera, const PictureReader& reader) {
  if (camera.source == SourceKind::kDevice) return Duration::zero();
  const double own = reader.rate_hz() > 0                   ? reader.rate_hz()
                     : camera.source == SourceKind::kFolder ? kFolderHz
                                                            : kVideoHz;
  const double rate_hz =
      camera.source == SourceKind::kFolder && camera.rate_hz > 0 ? camera.rate_hz : own;
  return Duration(static_cast<std::int64_t>(1e9 / rate_hz));
}

// The error that ended it; nothing at the end of the pictures.
std::optional<Error> Capture(const CameraConfig& camera, Mailbox& mailbox) {
  auto opened = Open(camera);
  if (!opened) return opened.error();
  PictureReader& reader = *opened.value();
  const Duration period = Period(camera, reader);
  Time next = std::chrono::steady_clock::now();
  while (!mailbox.closed()) {
    auto picture = reader.Next();
    if (!picture) return picture.error();
    if (!picture.value()) {
      if (!camera.loops) return std::nullopt;
      if (Result<> again = reader.Rewind(); !again) return again.error();
      continue;
    }
    if (!mailbox.WaitUntil(next)) break;
    mailbox.Put(std::move(*picture.value()));
    next = std::max(next + period, std::chrono::steady_clock::now() - period);
  }
  return std::nullopt;
}

class CaptureSource : public Source {
 public:
  explicit CaptureSource(std::shared_ptr<Mailbox> mailbox) : mailbox_(std::move(mailbox)) {}
  CaptureSource(const CaptureSource&) = delete;
  CaptureSource& operator=(const CaptureSource&) = delete;
  ~CaptureSource() override { mailbox_->Close(); }

 private:
  std::shared_ptr<Mailbox> mailbox_;
};

}  // namespace

std::unique_ptr<Source> OpenCapture(transport::EventLoop& loop, CaptureThreads& threads,
                                    const CameraConfig& camera, SourceEvents events) {
  auto mailbox = std::make_shared<Mailbox>(loop, std::move(events));
  threads.Start([mailbox, camera] { mailbox->End(Capture(camera, *mailbox)); });
  return std::make_unique<CaptureSource>(mailbox);
}

}  // namespace musher::camera
