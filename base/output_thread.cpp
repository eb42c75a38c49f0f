#include "musher/base/output_thread.hpp"

#include <unistd.h>

#include <cstdlib>
#include <system_error>

#include "musher/base/files.hpp"

namespace musher {
namespace {

constexpr Duration kLongestWait = Milliseconds(100);
constexpr Duration kLongestEnd = Milliseconds(1000);
constexpr std::uint64_t kMostWaiting = 1 << 20;  // bytes

// Never destroyed: what ends last may still write.
OutputThread& NewOutput(int descriptor) {
  return *new OutputThread(descriptor);  // NOLINT(cppcoreguidelines-owning-memory)
}

std::string NoteOfDropped(std::uint64_t bytes) {
  return "\n[musher: " + std::to_string(bytes) + " bytes dropped here: the disk did not answer]\n";
}

}  // namespace

OutputThread::OutputThread(int descriptor) : descriptor_(descriptor), process_(getpid()) {
  try {
    queue_.emplace(
        WorkQueueOptions{.name = "output", .takes_signals = false, .most = kMostWaiting});
  } catch (const std::system_error&) {
    return;
  }
}

void OutputThread::Write(std::string text) {
  if (!queue_ || getpid() != process_) {
    static_cast<void>(WriteAll(descriptor_, text));
    return;
  }
  const std::uint64_t dropped = dropped_.exchange(0);
  if (dropped > 0) text.insert(0, NoteOfDropped(dropped));
  const std::uint64_t size = text.size();
  ++waiting_;
  const auto given = queue_->Do(
      [this, text = std::move(text)] {
        static_cast<void>(WriteAll(descriptor_, text));
        if (--waiting_ == 0) late_ = false;
      },
      {.size = size});
  if (given == WorkQueue::Given::kRefused) {
    --waiting_;
    dropped_ += dropped > 0 ? dropped + size - NoteOfDropped(dropped).size() : size;
    return;
  }
  if (!late_ && !queue_->Flush(kLongestWait)) late_ = true;
}

void OutputThread::Flush(Duration most) {
  if (queue_ && getpid() == process_) queue_->Flush(most);
}

OutputThread& StandardOutput() {
  static OutputThread& output = [&]() -> OutputThread& {
    std::atexit([] { StandardOutput().Flush(kLongestEnd); });
    return NewOutput(STDOUT_FILENO);
  }();
  return output;
}

OutputThread& StandardError() {
  static OutputThread& output = [&]() -> OutputThread& {
    std::atexit([] { StandardError().Flush(kLongestEnd); });
    return NewOutput(STDERR_FILENO);
  }();
  return output;
}

}  // namespace musher
