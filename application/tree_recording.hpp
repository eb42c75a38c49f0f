#pragma once
// Records the trees of an actuator into a file (behavior/tree/recorder.hpp), for `musher tree
// replay`.
//
// A thread writes, so that a slow disk never delays a tick: lines beyond kMostPending that wait for
// it are left out, and the recording says so. FILE is at most half as long as Options::most_bytes
// and the lines of one tick; then it becomes FILE.before, as the recording of an earlier run does,
// and a new one begins with the tree and its present state. The file is synced once a second: a
// power cut takes away the last second. Once it cannot be written to, which is logged, nothing more
// is recorded; the application runs on.
//
// Threads: the loop's; Open() and the destructor those of the actuator. The destructor waits for
// the disk.

#include <functional>
#include <memory>
#include <string>

#include "musher/application/tree_report.hpp"
#include "musher/base/result.hpp"
#include "musher/base/work_queue.hpp"
#include "musher/behavior/tree/recorder.hpp"

namespace musher {

class RecordingFile;

struct TreeRecordingOptions {
  std::string file{};  // relative to state_dir of the state config; empty: none
  std::size_t most_bytes = std::size_t{16} << 20;
};

class TreeRecording {
 public:
  static constexpr std::size_t kMostPending = std::size_t{1} << 20;  // bytes
  using Log = std::function<void(const std::string&)>;               // from any thread

  static Result<std::unique_ptr<TreeRecording>> Open(const std::string& actuator,
                                                     const TreeRecordingOptions& options, Log log);
  ~TreeRecording();
  TreeRecording(const TreeRecording&) = delete;
  TreeRecording& operator=(const TreeRecording&) = delete;

  // The tree of `view` from now on. It and what `view` refers to must exist until End().
  void Begin(const TreeView& view, const tree::Factory& factory);
  void End();
  // After each tick, pause and halt.
  void Note(const TreeView& view);

 private:
  TreeRecording(std::string actuator, std::size_t most_bytes, std::shared_ptr<RecordingFile> file,
                Log log);
  void Flush();
  void BeginFile();
  bool Fits();
  void Give();

  const std::string actuator_;
  const std::size_t most_in_file_;
  const Log log_;
  std::string buffer_;       // since the last Give()
  std::size_t written_ = 0;  // to the present file
  std::uint64_t lost_ = 0;   // lines
  std::shared_ptr<tree::Recorder> recorder_;
  std::shared_ptr<RecordingFile> file_;
  WorkQueue thread_{{.name = "tree-record"}};  // last: it uses the file
};

}  // namespace musher
