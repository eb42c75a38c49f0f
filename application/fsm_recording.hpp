#pragma once
// Records the machine of an application into a file (behavior/fsm/recorder.hpp), for
// fsm_replay_file.hpp. The file of the run before is kept once as FILE.before, so that a program
// that is restarted does not lose it, unless no machine was started in that run.
//
// A thread writes, so that a slow disk never delays a tick: what has come to it when the state
// changes, or when there are some kB. The file is synced once a second. A replay needs every line
// since the start, so the recording ends, which is logged, when it is as long as it may be, when
// the disk is too slow, and when it cannot be written to; the application runs on.
//
// Threads: those of the machine, one at a time. The destructor waits for the disk.

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/base/work_queue.hpp"
#include "musher/behavior/fsm/recorder.hpp"

namespace musher {

class RecordingFile;

class FsmRecording {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20;
  static constexpr std::size_t kMostPending = std::size_t{4} << 20;  // bytes that wait for the disk
  using Log = std::function<void(const std::string&)>;               // from any thread

  // Records `machine` from its start on. The machine is built, is not started, and outlives the
  // recording. `key`: the key of `file` in the application's config, which the Error names when the
  // file cannot be written.
  static Result<std::unique_ptr<FsmRecording>> Open(fsm::Machine& machine, const std::string& file,
                                                    std::string_view key, Log log,
                                                    std::size_t most_bytes = kMostBytes);

  ~FsmRecording();
  FsmRecording(const FsmRecording&) = delete;
  FsmRecording& operator=(const FsmRecording&) = delete;

  // For the inputs of the application.
  fsm::Recorder& recorder() { return recorder_; }

 private:
  FsmRecording(fsm::Machine& machine, std::size_t most_bytes, std::shared_ptr<RecordingFile> file,
               Log log);
  void Write(std::string_view line);
  void End(const std::string& why);
  void Give();

  const std::size_t most_bytes_;
  const Log log_;
  std::string buffer_;  // since the last Give()
  std::size_t bytes_ = 0;
  bool ended_ = false;
  std::shared_ptr<RecordingFile> file_;
  WorkQueue thread_{{.name = "fsm-record"}};
  fsm::Recorder recorder_;  // last: it writes from its construction on
};

}  // namespace musher
