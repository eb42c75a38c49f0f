#include "musher/view/live/host_search.hpp"

#include <mutex>
#include <utility>

namespace musher::view {
namespace {

constexpr Duration kEndTimeout = Milliseconds(200);  // of the process, while a search hangs

WorkQueueOptions QueueOptions() {
  WorkQueueOptions options;
  options.name = "host-search";
  options.takes_signals = false;
  options.at_end = WorkQueueOptions::AtEnd::kDrop;
  options.end_timeout = kEndTimeout;
  return options;
}

}  // namespace

struct HostSearch::Loop {
  std::mutex mutex;
  transport::EventLoop* loop;

  explicit Loop(transport::EventLoop& of) : loop(&of) {}
  bool IsOpen() {
    const std::lock_guard lock(mutex);
    return loop != nullptr;
  }
};

HostSearch::HostSearch(transport::EventLoop& loop, std::function<Machines()> find)
    : find_(std::move(find)), loop_(std::make_shared<Loop>(loop)), queue_(QueueOptions()) {}

HostSearch::~HostSearch() {
  const std::lock_guard lock(loop_->mutex);
  loop_->loop = nullptr;
}

void HostSearch::Begin(std::function<void(Machines)> on_found) {
  queue_.Do([find = find_, shared = loop_, on_found = std::move(on_found)]() mutable {
    Machines machines = find();
    const auto report = [shared, on_found = std::move(on_found), machines = std::move(machines)] {
      if (shared->IsOpen()) on_found(machines);
    };
    const std::lock_guard lock(shared->mutex);
    if (shared->loop != nullptr) shared->loop->Post(report);
  });
}

}  // namespace musher::view
