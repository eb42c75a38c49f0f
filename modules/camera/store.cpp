#include "musher/modules/camera/store.hpp"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <optional>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/work_queue.hpp"
#include "musher/modules/camera/camera_code.hpp"
#include "musher/modules/camera/media.hpp"
#include "musher/modules/camera/service_core.hpp"

namespace musher::camera {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLeastFreeBytes = 16U << 20;
constexpr std::size_t kMostWaiting = 60;  // pictures, some 50 MB

Error Failure(const std::string& what, KeyCode key = KeyCode::kFailed) {
  return {CameraCode(key), what};
}

// The work itself, on the store's thread.
class Shelf {
 public:
  explicit Shelf(std::string folder) : folder_(std::move(folder)) {}

  Result<std::string> Save(msg::Image& picture, const NewFile& file) const {
    auto path = NewPath(file);
    if (!path) return path;
    auto media = LoadMedia();
    if (!media) return media.error();
    // A reader sees a whole picture or none.
    const std::string part = folder_ + "/.part-" + fs::path(path.value()).filename().string();
    std::error_code failed;
    if (Result<> saved = media.value()->Save(picture, part); !saved) {
      fs::remove(part, failed);
      return saved.error();
    }
    fs::rename(part, path.value(), failed);
    if (failed) return Failure(path.value() + ": " + failed.message());
    return path;
  }

  Result<std::string> BeginVideo(msg::Image& first, const NewFile& file, double rate_hz) {
    auto path = NewPath(file);
    if (!path) return path;
    auto media = LoadMedia();
    if (!media) return media.error();
    auto recorder = media.value()->Record(path.value(), first.width, first.height, rate_hz);
    if (!recorder) return recorder.error();
    recorder_ = std::move(recorder).value();
    path_ = path.value();
    fault_.reset();
    AddFrame(first);
    return path;
  }

  void AddFrame(msg::Image& picture) {
    if (!recorder_ || fault_) return;
    Result<> written = CheckSpace();
    if (written) written = recorder_->Write(picture);
    if (!written) fault_ = written.error();
  }

  Result<std::string> EndVideo() {
    const std::unique_ptr<Recorder> recorder = std::move(recorder_);
    if (!recorder) return Failure("nothing is being recorded");
    Result<> closed = recorder->Close();
    if (fault_) return *fault_;
    if (!closed) return closed.error();
    return path_;
  }

  Result<std::vector<std::string>> List() const {
    std::vector<std::string> files;
    std::error_code failed;
    if (!fs::exists(folder_, failed)) return files;
    for (const fs::path& entry : EntriesOf(folder_, failed)) {
      const std::string name = entry.filename();
      std::error_code removed;
      const bool is_file = fs::symlink_status(entry, removed).type() == fs::file_type::regular;
      if (!FaultOfName(name) && is_file) {
        files.push_back(name);
      }
    }
    if (failed) return Failure(folder_ + ": " + failed.message());
    std::sort(files.begin(), files.end());
    return files;
  }

  Result<> Delete(const std::string& file) const {
    const fs::path path = fs::path(folder_) / file;
    std::error_code failed;
    if (recorder_ && path == path_) {
      return Failure(file + " is being recorded", KeyCode::kTargetBusy);
    }
    // No symbolic links, and no folders.
    if (fs::symlink_status(path, failed).type() != fs::file_type::regular) {
      return Failure("there is no file " + file, KeyCode::kParametersInvalid);
    }
    if (!fs::remove(path, failed)) return Failure(file + ": " + failed.message());
    return Ok();
  }

 private:
  Result<std::string> NewPath(const NewFile& file) const {
    std::error_code failed;
    fs::create_directories(folder_, failed);
    if (failed) return Failure(folder_ + ": " + failed.message());
    if (Result<> room = CheckSpace(); !room) return room.error();
    const fs::path name = file.name;
    fs::path path = fs::path(folder_) / name;
    for (int count = 2; fs::symlink_status(path, failed).type() != fs::file_type::not_found;
         ++count) {
      if (failed) return Failure(path.string() + ": " + failed.message());
      if (!file.counts_on) {
        return Failure("there is a " + file.name + " already", KeyCode::kParametersInvalid);
      }
      path.replace_filename(name.stem().string() + "_" + std::to_string(count) +
                            name.extension().string());
    }
    return path.string();
  }

  Result<> CheckSpace() const {
    std::error_code failed;
    const fs::space_info space = fs::space(folder_, failed);
    if (failed) return Failure(folder_ + ": " + failed.message());
    if (space.available >= kLeastFreeBytes) return Ok();
    return Failure(folder_ + ": the disk is full");
  }

  const std::string folder_;
  std::unique_ptr<Recorder> recorder_;
  std::string path_;  // of the video
  std::optional<Error> fault_;
};

class ThreadStore : public Store {
 public:
  ThreadStore(transport::EventLoop& loop, std::string folder)
      : loop_(loop),
        shelf_(std::move(folder)),
        thread_({.name = "camera-store", .most = kMostWaiting}) {}
  ThreadStore(const ThreadStore&) = delete;
  ThreadStore& operator=(const ThreadStore&) = delete;
  ~ThreadStore() override {
    {
      const std::lock_guard lock(mutex_);
      alive_.reset();
    }
    thread_.Do([this] { static_cast<void>(shelf_.EndVideo()); });
  }

  void Save(msg::Image picture, const NewFile& file, Done<std::string> done) override {
    Do<std::string>(
        [this, picture = std::move(picture), file]() mutable { return shelf_.Save(picture, file); },
        std::move(done));
  }
  void BeginVideo(msg::Image first, const NewFile& file, double rate_hz,
                  Done<std::string> done) override {
    Do<std::string>([this, first = std::move(first), file,
                     rate_hz]() mutable { return shelf_.BeginVideo(first, file, rate_hz); },
                    std::move(done));
  }
  void AddFrame(msg::Image picture) override {
    thread_.Do([this, picture = std::move(picture)]() mutable { shelf_.AddFrame(picture); },
               {.size = 1});
  }
  void EndVideo(Done<std::string> done) override {
    Do<std::string>([this] { return shelf_.EndVideo(); }, std::move(done));
  }
  void List(Done<std::vector<std::string>> done) override {
    Do<std::vector<std::string>>([this] { return shelf_.List(); }, std::move(done));
  }
  void Delete(const std::string& file, Done<void> done) override {
    Do<void>([this, file] { return shelf_.Delete(file); }, std::move(done));
  }

 private:
  template <class T, class Work>
  void Do(Work work, Done<T> done) {
    thread_.Do([this, work = std::move(work), done = std::move(done)]() mutable {
      const Result<T> result = work();
      const std::lock_guard posting(mutex_);
      if (!alive_) return;  // the loop may be destroyed, too
      loop_.Post([alive = std::weak_ptr(alive_), done = std::move(done), result] {
        if (alive.lock()) done(result);
      });
    });
  }

  transport::EventLoop& loop_;
  Shelf shelf_;
  std::mutex mutex_;  // guards what follows
  std::shared_ptr<int> alive_ = std::make_shared<int>();
  WorkQueue thread_;  // last: it uses the rest
};

}  // namespace

std::unique_ptr<Store> MakeStore(transport::EventLoop& loop, const std::string& folder) {
  return std::make_unique<ThreadStore>(loop, folder);
}

}  // namespace musher::camera
