#pragma once
// Sinks that write files on a thread of their own: one file, or a ring of segments of which the
// time around trouble is kept. A slow disk delays only that thread; samples that find its queue
// full are lost, and counted by the recorder.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/work_queue.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/view/record/recording_file.hpp"
#include "musher/view/record/ring.hpp"
#include "musher/view/record/sink.hpp"

namespace musher::view {

struct FileSinkOptions {
  std::string path;  // the file; of a ring the folder
  mcap::Compression compression = mcap::Compression::kLz4;
  std::uint64_t max_bytes = 0;  // of the file; 0: no limit
  std::uint64_t max_waiting = 256U << 20;
};

// What only the disk's thread uses.
struct DiskSide;

// Every second what is in memory goes to the kernel, so that a recorder that is killed loses at
// most that.
class FileSink : public Sink {
 public:
  // `on_full`: once, when nothing more is written: the disk is full, or the limit is reached.
  using OnFull = std::function<void(const std::string& why)>;

  static Result<std::unique_ptr<FileSink>> Open(transport::EventLoop& loop,
                                                const FileSinkOptions& options, OnFull on_full);
  ~FileSink() override;

  std::size_t AddChannel(const RecordedChannel& channel) override;
  bool Write(std::size_t channel, std::int64_t log_ns, msg::Bytes data) override;
  // Writes what waits and ends the file.
  Result<> Close();

 private:
  explicit FileSink(const FileSinkOptions& options);

  std::shared_ptr<DiskSide> disk_;
  std::size_t channels_ = 0;
  WorkQueue queue_;
  transport::LoopHandlePtr flush_;
};

class RingSink : public Sink {
 public:
  using OnKept = std::function<void(const std::string& sentence)>;

  // `options.path` is the folder of the kept files; the segments are in its folder "ring". Those of
  // a recorder that was killed are kept as a file. Other files of both folders are left alone.
  // What cannot be kept, as on a full disk, is tried again with each new segment. Fails if another
  // recorder that runs has its ring in this folder.
  static Result<std::unique_ptr<RingSink>> Open(transport::EventLoop& loop,
                                                const FileSinkOptions& options, RingOptions ring,
                                                std::function<std::int64_t()> wall_clock,
                                                OnKept on_kept);
  ~RingSink() override;

  std::size_t AddChannel(const RecordedChannel& channel) override;
  bool Write(std::size_t channel, std::int64_t log_ns, msg::Bytes data) override;
  void OnTrouble(const std::string& reason);
  // Waits until the disk has done all that it was given so far.
  void Drain() { queue_.Flush(); }
  // Keeps trouble that waits for what comes after it, and deletes the segments. Fails if something
  // is not kept; its segments stay then.
  Result<> Close();

 private:
  RingSink(transport::EventLoop& loop, const FileSinkOptions& options, RingOptions ring,
           std::function<std::int64_t()> wall_clock);

  void Do(const std::vector<RingAction>& actions);

  transport::EventLoop& loop_;
  std::shared_ptr<DiskSide> disk_;
  Ring ring_;
  std::function<std::int64_t()> wall_clock_;
  std::size_t channels_ = 0;
  WorkQueue queue_;
  transport::LoopHandlePtr tick_;
};

}  // namespace musher::view
