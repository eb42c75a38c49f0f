#include "musher/controller/storage/log_files.hpp"

#include <fcntl.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/controller/storage/log_parts.hpp"
#include "musher/controller/storage/log_rotation.hpp"
#include "musher/controller/storage/log_times.hpp"
#include "musher/controller/storage/private_folder.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

constexpr Duration kLogPeriod = Milliseconds(1000);
constexpr Duration kBusyPeriod = Milliseconds(100);
constexpr Duration kMarkPeriod = Milliseconds(100);
constexpr Duration kReportPeriod = Milliseconds(60'000);  // while a flood continues
constexpr int kLogNiceness = 10;

std::string Megabytes(std::int64_t bytes) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f MB", static_cast<double>(bytes) / 1e6);
  return text.data();
}

std::string NoteOfDrop(std::int64_t bytes, const std::string& why) {
  return "\n[musher: " + std::to_string(bytes) + " bytes dropped here: " + why + "]\n";
}

constexpr const char* kNoteOfCut =
    "[musher: earlier output is in the compressed parts; on this filesystem, lines printed during "
    "the rotation are missing]\n";

std::int64_t WallNow() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since_1970).count();
}

// Writes a compressed file; removes it on failure.
class PartWriter {
 public:
  explicit PartWriter(std::string path) : path_(std::move(path)), next_(path_ + ".new") {
    fd_ =
        UniqueFd(open(next_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644));
    const int own = fcntl(fd_.get(), F_DUPFD_CLOEXEC, 0);  // which gzclose() closes
    if (own >= 0) file_ = gzdopen(own, "wb1");
    if (own >= 0 && file_ == nullptr) close(own);
  }
  ~PartWriter() {
    if (file_ != nullptr) gzclose(file_);
    if (!done_) unlink(next_.c_str());
  }
  PartWriter(const PartWriter&) = delete;
  PartWriter& operator=(const PartWriter&) = delete;

  bool Write(std::string_view text) {
    if (file_ == nullptr || text.empty()) return file_ != nullptr;
    return gzwrite(file_, text.data(), static_cast<unsigned>(text.size())) > 0;
  }
  // Copies from `file` up to `end`; returns the position reached, -1 for an error.
  std::int64_t Copy(int file, std::int64_t begin, std::int64_t end) {
    std::array<char, 64 << 10> buffer{};
    std::int64_t at = begin;
    while (at < end) {
      const auto most = static_cast<std::size_t>(std::min<std::int64_t>(buffer.size(), end - at));
      const ssize_t got = pread(file, buffer.data(), most, at);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return -1;
      if (got == 0) return at;
      if (!Write({buffer.data(), static_cast<std::size_t>(got)})) return -1;
      at += got;
    }
    return at;
  }
  bool Finish() {
    const bool closed = file_ != nullptr && gzclose(std::exchange(file_, nullptr)) == Z_OK;
    if (!closed || fsync(fd_.get()) != 0) return false;
    if (std::rename(next_.c_str(), path_.c_str()) != 0) return false;
    done_ = true;
    const UniqueFd folder(open(fs::path(path_).parent_path().c_str(), O_RDONLY | O_CLOEXEC));
    return folder.valid() && fsync(folder.get()) == 0;
  }

 private:
  const std::string path_;
  const std::string next_;
  UniqueFd fd_;
  gzFile file_ = nullptr;
  bool done_ = false;
};

}  // namespace

// Only the disk thread uses the members, except the paths, which are constant, `outputs`,
// `troubles` and `busy`.
struct LogFiles::State {
  struct Log {
    LogFile file;
    LogMarker times;
    std::int64_t max_bytes = 0;  // its effective limit
    bool may_collapse = true;    // its filesystem supports it, as far as known
    bool no_room = false;        // a part could not be saved
    std::int64_t dropped = 0;    // bytes not yet reported
    std::optional<Time> reported;
  };

  std::vector<Log> logs;
  std::int64_t max_total_bytes = 0;
  bool unopened = false;  // a file cannot be opened, which was reported

  std::mutex mutex;  // guards the members below; never held during I/O
  std::map<std::string, std::shared_ptr<const UniqueFd>> outputs;
  std::vector<std::string> troubles;
  bool busy = false;

  explicit State(const LogFilesOptions& options) : max_total_bytes(options.max_total_bytes) {
    for (const LogFile& file : options.logs) {
      const auto bound = LogBound(file.max_bytes, max_total_bytes, options.logs.size());
      logs.push_back({file, LogMarker(file.path), bound, options.may_collapse, false, 0, {}});
    }
  }

  void Trouble(const std::string& text) {
    const std::lock_guard lock(mutex);
    troubles.push_back(text);
  }

  // Opens the files that should be open and are not; reopens removed files.
  void Open() {
    std::string failure;
    for (Log& log : logs) {
      if (!log.file.open) continue;
      std::shared_ptr<const UniqueFd> output;
      {
        const std::lock_guard lock(mutex);
        output = outputs[log.file.name];
      }
      if (output && IsAt(log.file.path, output->get())) continue;
      if (output) static_cast<void>(log.times.Begin());
      output = nullptr;
      auto opened = OpenOne(log.file.path);
      if (opened) {
        output = std::make_shared<const UniqueFd>(std::move(opened).value());
      } else if (failure.empty()) {
        failure = opened.error().message;
      }
      const std::lock_guard lock(mutex);
      outputs[log.file.name] = std::move(output);
    }
    const bool known = std::exchange(unopened, !failure.empty());
    if (unopened && !known) Trouble("actuator output is lost: " + failure);
  }

  static bool IsAt(const std::string& path, int fd) {
    struct stat named {};
    struct stat open_file {};
    return lstat(path.c_str(), &named) == 0 && fstat(fd, &open_file) == 0 &&
           named.st_dev == open_file.st_dev && named.st_ino == open_file.st_ino;
  }

  static Result<UniqueFd> OpenOne(const std::string& path) {
    if (IsLink(fs::path(path).parent_path())) return SystemError("can't write " + path, ELOOP);
    if (auto made = MakePrivateFolder(fs::path(path).parent_path()); !made) return made.error();
    if (auto own = CheckOwnFolder(fs::path(path).parent_path()); !own) return own.error();
    UniqueFd file(open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0644));
    if (!file.valid()) return SystemError("can't write " + path);
    return file;
  }

  // Marks that cannot be written leave lines without a time, which is no trouble of the robot.
  void Mark(std::int64_t wall_ns) {
    for (Log& log : logs) {
      if (const auto size = SizeOf(log)) static_cast<void>(log.times.Mark(*size, wall_ns));
    }
  }

  void Look() {
    Open();
    Mark(WallNow());
    bool took = false;
    std::vector<LogSizes> sizes;
    for (Log& log : logs) took |= Rotate(log);
    for (Log& log : logs) sizes.push_back(SizesOf(log));
    for (const auto& [log, number] : PartsBeyond(max_total_bytes, sizes)) {
      unlink(LogPartPath(logs[log].file.path, number).c_str());
    }
    const std::lock_guard lock(mutex);
    busy = took;
  }

  // nullopt: there is no such file, or only through a link that may not be one.
  static std::optional<std::int64_t> SizeOf(const Log& log) {
    struct stat info {};
    const char* path = log.file.path.c_str();
    const bool found = log.file.may_be_link ? stat(path, &info) == 0 : lstat(path, &info) == 0;
    if (!found || !S_ISREG(info.st_mode) || IsInLink(log)) return std::nullopt;
    return info.st_size;
  }
  // The controller's log is in the state folder, which may be a link.
  static bool IsInLink(const Log& log) {
    return log.file.open && IsLink(fs::path(log.file.path).parent_path());
  }

  LogSizes SizesOf(const Log& log) const {
    if (IsInLink(log)) return {log.max_bytes, 0, {}, log.no_room};
    return {log.max_bytes, SizeOf(log).value_or(0), LogPartsOf(log.file.path), log.no_room};
  }

  // Returns whether the live file was too large.
  bool Rotate(Log& log) {
    const LogSizes sizes = SizesOf(log);
    const LogActions actions = RotationOf(sizes);
    for (const std::uint64_t number : actions.remove) {
      unlink(LogPartPath(log.file.path, number).c_str());
    }
    if (actions.save == 0 && actions.drop == 0) {
      ReportDrop(log);
      return false;
    }
    const std::uint64_t next = sizes.parts.empty() ? 1 : sizes.parts.back().number + 1;
    const int links = log.file.may_be_link ? 0 : O_NOFOLLOW;
    const UniqueFd file(open(log.file.path.c_str(), O_RDWR | O_APPEND | O_CLOEXEC | links));
    const Result<> cut =
        file.valid() ? Cut(log, file.get(), actions, next) : Result<>(SystemError("can't open it"));
    // A drop without a save says nothing about the room for a part.
    const bool known = std::exchange(log.no_room, !cut || (log.no_room && actions.save == 0));
    if (!cut && !known) {
      Trouble("the log of " + log.file.name + " is not rotated: " + cut.error().message);
    }
    ReportDrop(log);
    return true;
  }

  Result<> Cut(Log& log, int file, const LogActions& actions, std::uint64_t number) {
    if (log.may_collapse) {
      const auto cut = Collapse(log, file, actions, number);
      if (!cut || cut.value()) return cut ? Ok() : Result<>(cut.error());
      log.may_collapse = false;
    }
    return CopyAndTruncate(log, file, actions, number);
  }

  // False: the filesystem does not support it, and nothing has changed.
  Result<bool> Collapse(Log& log, int file, LogActions actions, std::uint64_t number) {
    struct stat info {};
    if (fstat(file, &info) != 0) return SystemError("can't look at " + log.file.path);
    // Only whole blocks can be removed.
    const std::int64_t beyond = (actions.save + actions.drop) % info.st_blksize;
    (actions.drop >= beyond ? actions.drop : actions.save) -= beyond;
    if (actions.save + actions.drop <= 0) return true;
    if (auto saved = Save(log, file, actions, number, false); !saved) return saved.error();
    if (fallocate(file, FALLOC_FL_COLLAPSE_RANGE, 0, actions.save + actions.drop) != 0) {
      const int error = errno;
      unlink(LogPartPath(log.file.path, number).c_str());
      if (error == EOPNOTSUPP || error == EINVAL || error == ENOSYS) return false;
      return SystemError("can't shorten " + log.file.path, error);
    }
    CutTimes(log, actions.save, actions.drop, number);
    NoteDrop(log, file, actions);
    return true;
  }

  // Saves and truncates the whole file.
  Result<> CopyAndTruncate(Log& log, int file, LogActions actions, std::uint64_t number) {
    const bool to_the_end = actions.drop == 0;
    if (auto saved = Save(log, file, actions, number, to_the_end); !saved) return saved;
    struct stat info {};
    if (fstat(file, &info) == 0 && !to_the_end) actions.drop = info.st_size - actions.save;
    if (ftruncate(file, 0) != 0) return SystemError("can't shorten " + log.file.path);
    CutTimes(log, to_the_end ? info.st_size : actions.save, info.st_size, number);
    WriteAll(file, kNoteOfCut);
    NoteDrop(log, file, actions);
    return Ok();
  }

  static void CutTimes(Log& log, std::int64_t save, std::int64_t drop, std::uint64_t number) {
    std::vector<std::uint64_t> parts;
    for (const LogPart& part : LogPartsOf(log.file.path)) parts.push_back(part.number);
    static_cast<void>(log.times.Cut(save, drop, number, parts));
  }

  // Writes the part; `to_the_end`: with everything that was appended by then.
  Result<> Save(const Log& log, int file, const LogActions& actions, std::uint64_t number,
                bool to_the_end) {
    if (actions.save == 0) return Ok();
    const std::string path = LogPartPath(log.file.path, number);
    PartWriter part(path);
    bool written = part.Copy(file, 0, actions.save) == actions.save;
    if (to_the_end) written = written && part.Copy(file, actions.save, INT64_MAX) >= 0;
    if (actions.drop > 0) {
      written =
          written && part.Write(NoteOfDrop(actions.drop, "output exceeded the log rate limit"));
    }
    if (!written || !part.Finish()) return SystemError("can't write " + path);
    return Ok();
  }

  void NoteDrop(Log& log, int file, const LogActions& actions) {
    log.dropped += actions.drop;
    if (actions.drop > 0 && actions.save == 0) {
      WriteAll(file, NoteOfDrop(actions.drop, "could not be saved"));
    }
  }

  void ReportDrop(Log& log) {
    const Time now = std::chrono::steady_clock::now();
    if (log.dropped == 0 || (log.reported && now < *log.reported + kReportPeriod)) return;
    Trouble(
        "the log of " + log.file.name + ": " + Megabytes(std::exchange(log.dropped, 0)) +
        " dropped: " + (log.no_room ? "it cannot be saved" : "output exceeded the log rate limit"));
    log.reported = now;
  }
};

LogFiles::LogFiles(transport::EventLoop& loop, LogFilesOptions options)
    : loop_(loop),
      state_(std::make_shared<State>(options)),
      on_trouble_(std::move(options.on_trouble)),
      disk_(loop, {.name = "logs", .niceness = kLogNiceness}) {
  state_->Open();
  state_->Mark(WallNow());  // before a process prints
  changes_ = UniqueFd(inotify_init1(IN_CLOEXEC | IN_NONBLOCK));
  Watch();
  timer_ = loop_.At(loop_.Now(), [this] { LookLater(); });
  MarkLater();
}

LogFiles::~LogFiles() = default;

std::shared_ptr<const UniqueFd> LogFiles::Output(const std::string& name) const {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->outputs.find(name);
  return found == state_->outputs.end() ? nullptr : found->second;
}

void LogFiles::LookNow() {
  state_->Look();
  Report();
}

// Changes nothing for a file that is watched already. A file that was made again is not watched
// yet.
void LogFiles::Watch() {
  if (!changes_.valid()) return;
  for (const State::Log& log : state_->logs) {
    inotify_add_watch(changes_.get(), log.file.path.c_str(), IN_MODIFY);
  }
}

// Marks the next change at once, and the changes of a while after it together.
void LogFiles::MarkLater() {
  if (!changes_.valid()) return;
  growth_ = loop_.WhenReadable(changes_.get(), [this] {
    alignas(inotify_event) std::array<char, 4 << 10> buffer{};
    while (read(changes_.get(), buffer.data(), buffer.size()) > 0) {
    }
    disk_.Do("times", [state = state_, now = WallNow()] {
      state->Mark(now);
      return Ok();
    });
    growth_ = loop_.At(loop_.Now() + kMarkPeriod, [this] { MarkLater(); });
  });
}

void LogFiles::LookLater() {
  Watch();
  disk_.Do(
      "logs",
      [state = state_] {
        state->Look();
        return Ok();
      },
      [this](const Result<>&) {
        Report();
        bool busy = false;
        {
          const std::lock_guard lock(state_->mutex);
          busy = state_->busy;
        }
        timer_ = loop_.At(loop_.Now() + (busy ? kBusyPeriod : kLogPeriod), [this] { LookLater(); });
      });
}

void LogFiles::Report() {
  std::vector<std::string> troubles;
  {
    const std::lock_guard lock(state_->mutex);
    troubles = std::exchange(state_->troubles, {});
  }
  for (const std::string& trouble : troubles) {
    if (on_trouble_) on_trouble_(trouble);
  }
}

}  // namespace musher
