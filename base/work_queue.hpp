#pragma once
// A thread that runs work in order: what takes too long for a loop, or waits for a disk or a
// device.
//
//   WorkQueue photos({.name = "photos"});
//   photos.Do([picture] { WritePng(picture); });
//
// What may wait is a matter of the options and of the work:
//   bounded       WorkQueueOptions::most, the sum of Work::size: work beyond it is refused
//   latest only   Work::key: takes the place of waiting work with that key
//   later         Work::not_before: work behind it does not wait for it
//   again         DoUntilDone(): work that says when to try once more
//
// Threads: any. Work must not throw, and must not destroy its queue. The destructor waits for the
// work under way; see WorkQueueOptions for the rest.

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "musher/base/time.hpp"

namespace musher {

struct WorkQueueOptions {
  enum class AtEnd : std::uint8_t {
    kRun,  // what waits is run first, also if it is not due; nothing is tried again
    kDrop
  };

  std::string name = "work";  // of the thread; at most 15 bytes
  int niceness = 0;           // of the thread; unchanged if not permitted
  bool takes_signals = true;  // false: no signal is delivered to the thread
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();  // of the sizes of all work
  AtEnd at_end = AtEnd::kRun;
  // The end waits only so long and then leaves the thread running, for a disk that does not answer:
  // work must own what it uses. nullopt: until the thread has ended.
  std::optional<Duration> end_timeout{};
};

// How a piece of work waits.
struct Work {
  std::string key{};       // takes the place of waiting work with this key; empty: of none
  std::uint64_t size = 0;  // 0: is always accepted
  Time not_before{};
};

class WorkQueue {
 public:
  enum class Given : std::uint8_t {
    kAccepted,
    kReplaced,  // accepted; work of its key waited and does not run
    kRefused    // too much work waits or runs; never if nothing else does
  };

  explicit WorkQueue(WorkQueueOptions options);
  ~WorkQueue();
  WorkQueue(const WorkQueue&) = delete;
  WorkQueue& operator=(const WorkQueue&) = delete;

  Given Do(std::function<void()> work, Work how = {});
  // The same for work that may have to run again: it returns when, or nothing once it is done. It
  // does not run again if other work of its key was given meanwhile, or at the end.
  Given DoUntilDone(std::function<std::optional<Time>()> work, Work how = {});

  // Makes due what waits, and waits until all work given so far has run once (or was replaced), at
  // most `timeout`; returns whether it has. Not for work.
  bool Flush(std::optional<Duration> timeout = std::nullopt);

  // What the destructor does: no more work is accepted. Idempotent. Not for work.
  void End();

 private:
  struct Shared;  // with the thread

  const std::shared_ptr<Shared> shared_;
};

}  // namespace musher
