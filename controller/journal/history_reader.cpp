#include "musher/controller/journal/history_reader.hpp"

#include <utility>

namespace musher {
namespace {

constexpr std::size_t kMostWaiting = 16;
constexpr Duration kFlushTimeout = std::chrono::seconds(1);

}  // namespace

void HistoryReader::Read(std::int64_t since_wall_ns, std::size_t limit, OnHistory done) {
  if (requests_.size() >= kMostWaiting) {
    return loop_.Post([done = std::move(done)] {
      done(Error{kCodeTargetBusy, "too many journal requests are waiting; try again later"});
    });
  }
  requests_.push_back({since_wall_ns, limit, std::move(done)});
  if (requests_.size() == 1) ReadNext();
}

void HistoryReader::ReadNext() {
  const Request& next = requests_.front();
  thread_ = std::jthread(
      [this, since = next.since_wall_ns, limit = next.limit, alive = std::weak_ptr<bool>(alive_)] {
        static_cast<void>(journal_.Flush(kFlushTimeout));
        auto reading = ReadJournal(journal_.path(), since, limit);
        loop_.Post([this, alive, reading = std::move(reading)] {
          if (alive.expired()) return;
          const OnHistory done = std::move(requests_.front().done);
          requests_.pop_front();
          if (!requests_.empty()) ReadNext();
          done(reading);
        });
      });
}

}  // namespace musher
