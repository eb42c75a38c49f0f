#pragma once
// A small file that is replaced from a loop, which must not wait for a disk: it may hold a robot.
//
//   SavedFile place("/var/lib/dog/place");
//   if (const Result<> saved = place.Replace(text); !saved) Log(saved.error());
//
// A thread writes it, which the loop awaits for 100 ms. On a disk that takes longer, the last
// content is written once the disk answers.
//
// Threads: one at a time.

#include <memory>
#include <optional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/base/work_queue.hpp"

namespace musher {

class SavedFile {
 public:
  // kRemoved: an older content would be wrong.
  enum class AfterFailure { kKept, kRemoved };

  explicit SavedFile(std::string path, AfterFailure after = AfterFailure::kKept);

  // Makes its folder, too. Fails with the reason, and where the disk has not answered yet.
  Result<> Replace(std::string content);
  void Remove();

 private:
  struct State;  // with the thread

  Result<> Do(std::function<Result<>()> work);

  const std::string path_;
  const AfterFailure after_;
  const std::shared_ptr<State> state_;
  std::optional<WorkQueue> queue_;  // from the first call on
};

}  // namespace musher
