#include "musher/view/record/file_sink.hpp"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/view/record/merge.hpp"

namespace musher::view {
namespace {

namespace fs = std::filesystem;

constexpr Duration kFlushPeriod = std::chrono::seconds(1);
constexpr std::uint64_t kOverhead = 64;  // bytes of a waiting sample beside its data

}  // namespace

struct DiskSide {
  explicit DiskSide(FileSinkOptions file_options) : options(std::move(file_options)) {}

  FileSinkOptions options;
  std::function<void(const std::string&)> report;  // from the disk's thread
  std::vector<RecordedChannel> channels;
  std::unique_ptr<RecordingFile> file;
  std::map<std::size_t, std::pair<std::int64_t, msg::Bytes>> latched;  // last samples, of a ring
  std::atomic<bool> full = false;
  std::size_t max_kept = 0;

  void Full(const std::string& why) {
    if (!full.exchange(true) && report) report(why);
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

  std::string Segment(std::uint64_t number) const {
    std::string digits = std::to_string(number);
    digits.insert(0, 8 - std::min<std::size_t>(digits.size(), 8), '0');
    return options.path + "/ring/" + digits + ".mcap";
  }
  void Begin(std::uint64_t number, std::int64_t now_ns) {
    Check(Close());
    full = false;  // there may be room again
    auto opened = RecordingFile::Open(Segment(number), options.compression);
    if (!opened) return Full(opened.error().message);
    file = std::move(opened).value();
    for (const auto& [channel, sample] : latched) {
      Check(file->Write(channels[channel], channel, now_ns, std::min(sample.first, now_ns - 1),
                        sample.second));
    }
  }
  void Keep(const std::vector<std::string>& segments, const std::string& name) {
    const std::string out = options.path + "/" + name;
    const auto merged = MergeSegments(segments, out, options.compression);
    report(merged ? "kept " + out : "not kept: " + merged.error().message);
    std::vector<std::string> kept;
    std::error_code ignored;
    for (const fs::path& entry : EntriesOf(options.path)) {
      if (entry.extension() == ".mcap") kept.push_back(entry.string());
    }
    for (const std::string& old : OldestBeyond(kept, max_kept)) fs::remove(old, ignored);
  }
};

FileSink::FileSink(const FileSinkOptions& options)
    : disk_(std::make_shared<DiskSide>(options)), queue_(options.max_waiting) {}

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
    self->queue_.Do(0, [disk] {
      if (disk->file && !disk->full) disk->Check(disk->file->Flush());
    });
  });
  return sink;
}

std::size_t FileSink::AddChannel(const RecordedChannel& channel) {
  queue_.Do(0, [disk = disk_.get(), channel] { disk->channels.push_back(channel); });
  return channels_++;
}

bool FileSink::Write(std::size_t channel, std::int64_t log_ns, msg::Bytes data) {
  if (disk_->full) return false;
  const std::uint64_t bytes = data.size() + kOverhead;
  const auto shared = std::make_shared<msg::Bytes>(std::move(data));
  return queue_.Do(bytes, [disk = disk_.get(), channel, log_ns, shared] {
    disk->Write(channel, log_ns, *shared);
  });
}

Result<> FileSink::Close() {
  flush_.reset();
  queue_.Drain();
  return disk_->Close();
}

RingSink::RingSink(const FileSinkOptions& options, RingOptions ring,
                   std::function<std::int64_t()> wall_clock)
    : disk_(std::make_shared<DiskSide>(options)),
      ring_(ring),
      wall_clock_(std::move(wall_clock)),
      queue_(options.max_waiting) {
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
  fs::create_directories(options.path + "/ring", error);
  if (error) {
    return Error{kCodeParametersInvalid,
                 options.path + " cannot be used as a folder: " + error.message()};
  }
  std::unique_ptr<RingSink> sink(new RingSink(options, ring, std::move(wall_clock)));
  sink->disk_->report = [&loop, on_kept = std::move(on_kept)](const std::string& sentence) {
    loop.Post([on_kept, sentence] { on_kept(sentence); });
  };
  std::vector<std::string> left;
  for (const fs::path& entry : EntriesOf(options.path + "/ring")) left.push_back(entry.string());
  if (!left.empty()) {
    std::sort(left.begin(), left.end());
    sink->disk_->Keep(left, KeptName(sink->wall_clock_(), "recorder-restarted"));
    for (const std::string& old : left) fs::remove(old, error);
  }
  const auto tick = [self = sink.get()] {
    const std::int64_t now_ns = self->wall_clock_();
    self->Do(self->ring_.At(now_ns), now_ns);
    self->queue_.Do(0, [disk = self->disk_.get()] {
      if (disk->file && !disk->full) disk->Check(disk->file->Flush());
    });
  };
  tick();
  sink->tick_ = loop.Every(kFlushPeriod, tick);
  return sink;
}

std::size_t RingSink::AddChannel(const RecordedChannel& channel) {
  queue_.Do(0, [disk = disk_.get(), channel] { disk->channels.push_back(channel); });
  return channels_++;
}

bool RingSink::Write(std::size_t channel, std::int64_t log_ns, msg::Bytes data) {
  if (disk_->full) return false;
  const std::uint64_t bytes = data.size() + kOverhead;
  const auto shared = std::make_shared<msg::Bytes>(std::move(data));
  return queue_.Do(bytes, [disk = disk_.get(), channel, log_ns, shared] {
    disk->Write(channel, log_ns, *shared);
    if (disk->channels[channel].latched) disk->latched[channel] = {log_ns, *shared};
  });
}

void RingSink::OnTrouble(const std::string& reason) {
  ring_.OnTrouble(reason, wall_clock_());
}

void RingSink::Do(const std::vector<RingAction>& actions, std::int64_t now_ns) {
  for (const RingAction& action : actions) {
    DiskSide* disk = disk_.get();
    if (const auto* begin = std::get_if<BeginSegment>(&action)) {
      queue_.Do(0, [disk, number = begin->number, now_ns] { disk->Begin(number, now_ns); });
    } else if (const auto* old = std::get_if<DeleteSegment>(&action)) {
      queue_.Do(0, [disk, number = old->number] {
        std::error_code ignored;
        fs::remove(disk->Segment(number), ignored);
      });
    } else if (const auto* keep = std::get_if<KeepSegments>(&action)) {
      std::vector<std::string> segments;
      for (const std::uint64_t number : keep->numbers) segments.push_back(disk->Segment(number));
      queue_.Do(0, [disk, segments, name = KeptName(keep->trouble_ns, keep->reason)] {
        disk->Keep(segments, name);
      });
    }
  }
}

Result<> RingSink::Close() {
  if (!tick_) return Ok();
  tick_.reset();
  queue_.Drain();
  auto closed = disk_->Close();
  const std::int64_t now_ns = wall_clock_();
  Do(ring_.End(now_ns), now_ns);
  queue_.Drain();
  std::error_code ignored;
  fs::remove_all(disk_->options.path + "/ring", ignored);
  return closed;
}

}  // namespace musher::view
