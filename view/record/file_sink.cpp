#include "musher/view/record/file_sink.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <mutex>
#include <set>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/view/record/merge.hpp"

namespace musher::view {
namespace {

namespace fs = std::filesystem;

constexpr Duration kFlushPeriod = std::chrono::seconds(1);
constexpr std::uint64_t kOverhead = 64;  // bytes of a waiting sample beside its data

WorkQueueOptions DiskThread(std::uint64_t max_waiting_bytes) {
  return {.name = "record-disk", .most = max_waiting_bytes};
}

// The lock of a ring's folder, held by its recorder as long as it runs; not valid if the file
// system has none. Fails if another recorder holds it: each would delete the segments of the other.
Result<UniqueFd> LockRing(const std::string& folder, const std::string& path) {
  while (true) {
    UniqueFd fd(open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644));
    struct flock whole {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    const bool locked = fd.valid() && fcntl(fd.get(), F_OFD_SETLK, &whole) == 0;
    if (!locked && fd.valid() && errno == EAGAIN) {
      return Error{kCodeTargetBusy, "another recorder has its ring in " + folder +
                                        "; give this one another folder: -o FOLDER"};
    }
    if (!locked) return UniqueFd();
    struct stat ours {};
    struct stat there {};
    const bool same = fstat(fd.get(), &ours) == 0 && lstat(path.c_str(), &there) == 0 &&
                      ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
    if (same) return fd;  // else the last holder has removed it since it was opened
  }
}

bool IsGiven(WorkQueue::Given given) {
  return given != WorkQueue::Given::kRefused;
}

}  // namespace

struct DiskSide {
  explicit DiskSide(FileSinkOptions file_options) : options(std::move(file_options)) {}

  FileSinkOptions options;
  std::function<void(const std::string&)> report;  // from the disk's thread
  std::vector<RecordedChannel> channels;
  std::unique_ptr<RecordingFile> file;
  std::map<std::size_t, std::pair<std::int64_t, msg::Bytes>> latched;  // last samples, of a ring
  std::atomic<bool> full = false;

  void Full(const std::string& why) {
    if (full.exchange(true)) return;
    if (segment != 0) cut[segment] = why;
    if (report) report(why);
  }
  void Check(const Result<>& result) {
    if (!result) Full(result.error().message);
  }
  void Write(std::size_t channel, std::int64_t log_ns, const msg::Bytes& data) {
    if (full || !file) return;
    Check(file->Write(channels[channel], channel, log_ns, log_ns, data));
    if (options.max_bytes != 0 && file->bytes() >= options.max_bytes) {
      Full(options.path + " has reached its --max-size");
    }
  }
  Result<> Close() {
    if (!file) return Ok();
    const auto last = std::exchange(file, nullptr);
    return last->Close();
  }

  // What is to be kept and is not yet: its segments stay until it is.
  struct Unkept {
    std::vector<std::uint64_t> numbers;
    std::string name;
    std::string why;
  };

  std::size_t max_kept = 0;
  std::uint64_t segment = 0;                 // the current one of a ring
  std::map<std::uint64_t, std::string> cut;  // segments that the disk did not take, and why
  std::set<std::uint64_t> ours;              // segments on the disk
  std::set<std::uint64_t> old;               // of these, no longer in the ring
  std::vector<Unkept> unkept;
  std::vector<std::string> kept;  // file names, in the order in which this recorder has kept them
  bool folder_is_ours = false;
  UniqueFd lock;        // of the folder of a ring
  std::string failure;  // the first thing of which not all is kept

  std::string Folder() const { return options.path + "/ring"; }
  std::string LockFile() const { return Folder() + "/.lock"; }
  std::string Segment(std::uint64_t number) const { return Folder() + "/" + SegmentName(number); }
  void Begin(std::uint64_t number, std::int64_t wall_ns) {
    Check(Close());
    segment = number;
    full = false;  // there may be room again
    auto opened = RecordingFile::Open(Segment(number), options.compression);
    if (!opened) {
      Full(opened.error().message);
    } else {
      file = std::move(opened).value();
      ours.insert(number);
      for (const auto& [channel, sample] : latched) {
        Check(file->Write(channels[channel], channel, wall_ns, std::min(sample.first, wall_ns - 1),
                          sample.second));
      }
    }
    KeepAll();
  }
  void Drop(const std::set<std::uint64_t>& numbers) {
    old.insert(numbers.begin(), numbers.end());
    std::erase_if(old, [this](std::uint64_t number) {
      const bool needed = std::any_of(unkept.begin(), unkept.end(), [number](const Unkept& each) {
        return std::find(each.numbers.begin(), each.numbers.end(), number) != each.numbers.end();
      });
      if (needed) return false;
      std::error_code ignored;
      if (ours.erase(number) > 0) fs::remove(Segment(number), ignored);
      cut.erase(number);
      return true;
    });
  }
  void Keep(std::vector<std::uint64_t> numbers, const std::string& name) {
    unkept.push_back({std::move(numbers), name, ""});
    KeepAll();
    if (unkept.size() > max_kept) {
      Fail("not kept, since " + std::to_string(max_kept) +
           " others wait for the disk as well: " + unkept.front().name);
      unkept.erase(unkept.begin());
    }
    Drop({});
  }
  // Also what an earlier attempt could not keep.
  void KeepAll() {
    const std::size_t before = unkept.size();
    std::erase_if(unkept, [this](Unkept& each) {
      const std::string out = FreeName(each.name);
      std::vector<std::string> segments;
      for (const std::uint64_t number : each.numbers) segments.push_back(Segment(number));
      const auto merged = MergeSegments(segments, out, options.compression);
      if (!merged) {
        if (each.why.empty()) {
          report("not kept yet: " + merged.error().message + "; what it needs stays in " +
                 Folder());
        }
        each.why = merged.error().message;
        return false;
      }
      report("kept " + out);
      for (const std::uint64_t number : each.numbers) {
        if (cut.contains(number)) {
          Fail(out + " lacks a part: " + cut[number]);
          break;
        }
      }
      kept.push_back(fs::path(out).filename());
      MakeRoom();
      return true;
    });
    if (unkept.size() < before) Drop({});
  }
  // A clock that was set back may name two files alike.
  std::string FreeName(const std::string& name) const {
    const std::string path = options.path + "/" + name;
    const std::string stem = path.substr(0, path.size() - std::string(".mcap").size());
    std::string free = path;
    std::error_code error;
    for (int n = 2; fs::exists(fs::symlink_status(free, error)); ++n) {
      free = stem + "_" + std::to_string(n) + ".mcap";
    }
    return free;
  }
  // Deletes the oldest kept files beyond the limit. Those of this recorder are the newest, whatever
  // the wall clock says in their names: without an RTC it begins in 1970. Other files are the
  // user's.
  void MakeRoom() {
    std::error_code ignored;
    const fs::path folder = options.path;
    std::erase_if(kept,
                  [&](const std::string& name) { return !fs::exists(folder / name, ignored); });
    std::vector<std::string> earlier;
    for (const fs::path& entry : EntriesOf(folder)) {
      const std::string name = entry.filename();
      const bool by_this = std::ranges::count(kept, name) != 0;
      if (!by_this && IsKeptName(name) && IsByMusher(entry.string())) earlier.push_back(name);
    }
    const std::size_t most = std::max<std::size_t>(max_kept, 1);
    const std::size_t room = most - std::min(most, kept.size());
    for (const std::string& name : OldestBeyond(earlier, room)) fs::remove(folder / name, ignored);
    while (kept.size() > most) {
      fs::remove(folder / kept.front(), ignored);
      kept.erase(kept.begin());
    }
  }
  void Fail(const std::string& what) {
    report(what);
    if (failure.empty()) failure = what;
  }
  // Deletes the segments, but those of what could not be kept.
  Result<> End() {
    Drop(ours);
    for (const Unkept& each : unkept) {
      Fail(each.name + " is not kept: " + each.why + "; its segments are in " + Folder() +
           ", from which the next recorder keeps them");
    }
    std::error_code ignored;
    if (lock.valid()) fs::remove(LockFile(), ignored);
    lock = {};
    if (folder_is_ours) fs::remove(Folder(), ignored);  // if it is empty
    if (failure.empty()) return Ok();
    return Error{kCodeFailed, failure};
  }
};

FileSink::FileSink(const FileSinkOptions& options)
    : disk_(std::make_shared<DiskSide>(options)), queue_(DiskThread(options.max_waiting)) {}

FileSink::~FileSink() {
  static_cast<void>(Close());
}

Result<std::unique_ptr<FileSink>> FileSink::Open(transport::EventLoop& loop,
                                                 const FileSinkOptions& options, OnFull on_full) {
  auto file = RecordingFile::Open(options.path, options.compression);
  if (!file) return file.error();
  std::unique_ptr<FileSink> sink(new FileSink(options));
  DiskSide* disk = sink->disk_.get();
  disk->file = std::move(file).value();
  disk->report = [&loop, on_full = std::move(on_full)](const std::string& why) {
    loop.Post([on_full, why] { on_full(why); });
  };
  sink->flush_ = loop.Every(kFlushPeriod, [self = sink.get(), disk] {
    self->queue_.Do([disk] {
      if (disk->file && !disk->full) disk->Check(disk->file->Flush());
    });
  });
  return sink;
}

std::size_t FileSink::AddChannel(const RecordedChannel& channel) {
  queue_.Do([disk = disk_.get(), channel] { disk->channels.push_back(channel); });
  return channels_++;
}

bool FileSink::Write(std::size_t channel, std::int64_t log_ns, msg::Bytes data) {
  if (disk_->full) return false;
  const std::uint64_t bytes = data.size() + kOverhead;
  const auto shared = std::make_shared<msg::Bytes>(std::move(data));
  return IsGiven(queue_.Do(
      [disk = disk_.get(), channel, log_ns, shared] { disk->Write(channel, log_ns, *shared); },
      {.size = bytes}));
}

Result<> FileSink::Close() {
  flush_.reset();
  queue_.Flush();
  return disk_->Close();
}

RingSink::RingSink(transport::EventLoop& loop, const FileSinkOptions& options, RingOptions ring,
                   std::function<std::int64_t()> wall_clock)
    : loop_(loop),
      disk_(std::make_shared<DiskSide>(options)),
      ring_(ring),
      wall_clock_(std::move(wall_clock)),
      queue_(DiskThread(options.max_waiting)) {
  disk_->max_kept = ring.max_kept;
}

RingSink::~RingSink() {
  static_cast<void>(Close());
}

Result<std::unique_ptr<RingSink>> RingSink::Open(transport::EventLoop& loop,
                                                 const FileSinkOptions& options, RingOptions ring,
                                                 std::function<std::int64_t()> wall_clock,
                                                 OnKept on_kept) {
  std::error_code error;
  const bool created = fs::create_directories(options.path + "/ring", error);
  if (error) {
    return Error{kCodeParametersInvalid,
                 options.path + " cannot be used as a folder: " + error.message()};
  }
  std::unique_ptr<RingSink> sink(new RingSink(loop, options, ring, std::move(wall_clock)));
  DiskSide* disk = sink->disk_.get();
  auto lock = LockRing(options.path, disk->LockFile());
  if (!lock) return lock.error();
  disk->lock = std::move(lock).value();
  disk->report = [&loop, on_kept = std::move(on_kept)](const std::string& sentence) {
    loop.Post([on_kept, sentence] { on_kept(sentence); });
  };
  // Of a recorder that was killed, or could not keep them. Other files are the user's.
  std::vector<std::uint64_t> left;
  std::uint64_t last = 0;
  for (const fs::path& entry : EntriesOf(disk->Folder())) {
    const std::uint64_t number = SegmentNumber(entry.filename().string());
    last = std::max(last, number);
    if (number != 0 && IsByMusher(entry.string())) left.push_back(number);
  }
  std::sort(left.begin(), left.end());
  disk->folder_is_ours = created || !left.empty();
  sink->ring_ = Ring(ring, last + 1);
  if (!left.empty()) {
    disk->ours.insert(left.begin(), left.end());
    disk->Keep(left, KeptName(sink->wall_clock_(), "recorder-restarted"));
    disk->Drop(disk->ours);
  }
  const auto tick = [self = sink.get()] {
    self->Do(self->ring_.At(self->loop_.Now()));
    self->queue_.Do([disk = self->disk_.get()] {
      if (disk->file && !disk->full) disk->Check(disk->file->Flush());
    });
  };
  tick();
  sink->tick_ = loop.Every(kFlushPeriod, tick);
  return sink;
}

std::size_t RingSink::AddChannel(const RecordedChannel& channel) {
  queue_.Do([disk = disk_.get(), channel] { disk->channels.push_back(channel); });
  return channels_++;
}

bool RingSink::Write(std::size_t channel, std::int64_t log_ns, msg::Bytes data) {
  if (disk_->full) return false;
  const std::uint64_t bytes = data.size() + kOverhead;
  const auto shared = std::make_shared<msg::Bytes>(std::move(data));
  return IsGiven(queue_.Do(
      [disk = disk_.get(), channel, log_ns, shared] {
        disk->Write(channel, log_ns, *shared);
        if (disk->channels[channel].latched) disk->latched[channel] = {log_ns, *shared};
      },
      {.size = bytes}));
}

void RingSink::OnTrouble(const std::string& reason) {
  ring_.OnTrouble(reason, loop_.Now(), wall_clock_());
}

void RingSink::Do(const std::vector<RingAction>& actions) {
  for (const RingAction& action : actions) {
    DiskSide* disk = disk_.get();
    if (const auto* begin = std::get_if<BeginSegment>(&action)) {
      queue_.Do([disk, number = begin->number, wall_ns = wall_clock_()] {
        disk->Begin(number, wall_ns);
      });
    } else if (const auto* past = std::get_if<DeleteSegment>(&action)) {
      queue_.Do([disk, number = past->number] { disk->Drop({number}); });
    } else if (const auto* keep = std::get_if<KeepSegments>(&action)) {
      queue_.Do([disk, numbers = keep->numbers, name = KeptName(keep->trouble_ns, keep->reason)] {
        disk->Keep(numbers, name);
      });
    }
  }
}

Result<> RingSink::Close() {
  if (!tick_) return Ok();
  tick_.reset();
  queue_.Flush();
  disk_->Check(disk_->Close());
  Do(ring_.End(loop_.Now()));
  queue_.Flush();
  return disk_->End();
}

}  // namespace musher::view
