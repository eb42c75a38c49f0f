#pragma once
// Records the machine of an application into a file (behavior/fsm/recorder.hpp), for
// fsm_replay_file.hpp. The file of the run before is kept once as FILE.before, so that a program
// that is restarted does not lose it.
//
// The file is flushed when the state changes. Once it cannot be written to, which is logged, all
// later lines are lost; the application runs on.
//
// Threads: those of the machine, one at a time.

#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/behavior/fsm/recorder.hpp"

namespace musher {

class FsmRecording {
 public:
  using Log = std::function<void(const std::string&)>;

  // Records `machine` from its start on. The machine is built, is not started, and outlives the
  // recording. `key`: the key of `file` in the application's config, which the Error names when the
  // file cannot be written.
  static Result<std::unique_ptr<FsmRecording>> Open(fsm::Machine& machine, const std::string& file,
                                                    std::string_view key, Log log);

  // For the inputs of the application.
  fsm::Recorder& recorder() { return recorder_; }

 private:
  FsmRecording(fsm::Machine& machine, std::ofstream stream, Log log);
  void Write(std::string_view line);

  std::ofstream stream_;
  const Log log_;
  fsm::Recorder recorder_;  // last: it writes from its construction on
};

}  // namespace musher
