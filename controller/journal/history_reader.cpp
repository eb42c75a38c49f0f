#include "musher/controller/journal/history_reader.hpp"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "musher/base/words.hpp"

namespace musher {
namespace {

constexpr std::size_t kMostWaiting = 16;
constexpr Duration kFlushTimeout = std::chrono::seconds(1);
constexpr Duration kEndTimeout = std::chrono::seconds(2);  // of the destructor

std::string DescribeGap(const UnwrittenEntries& unwritten) {
  if (!unwritten.gap) return "the disk is slow: the newest entries may be missing";
  std::string text = "the journal is not on disk since " + unwritten.gap->Text() + "; " +
                     Counted(unwritten.entries.size(), "entry", "entries") + " in memory only";
  if (unwritten.lost == 0) return text;
  return text + ", " + std::to_string(unwritten.lost) + " older ones and inputs are lost";
}

}  // namespace

struct HistoryReader::Shared {
  std::mutex mutex;
  std::condition_variable ended;
  transport::EventLoop* loop = nullptr;  // none once the reader is destroyed
  bool reading = false;
};

HistoryReader::HistoryReader(transport::EventLoop& loop, const Journal& journal)
    : loop_(loop), journal_(journal.access()), shared_(std::make_shared<Shared>()) {
  shared_->loop = &loop;
}

HistoryReader::~HistoryReader() {
  std::unique_lock lock(shared_->mutex);
  shared_->ended.wait_for(lock, kEndTimeout, [this] { return !shared_->reading; });
  shared_->loop = nullptr;
}

Result<JournalReading> WithUnwritten(Result<JournalReading> reading,
                                     const UnwrittenEntries& unwritten, std::int64_t since_wall_ns,
                                     std::size_t limit) {
  if (!reading && unwritten.entries.empty()) return reading;
  const std::string trouble = reading ? reading.value().damage : reading.error().message;
  JournalReading all;
  if (reading) all = std::move(reading).value();
  all.damage = DescribeGap(unwritten) + (trouble.empty() ? "" : "; " + trouble);
  for (const JournalEntry& entry : unwritten.entries) {
    if (entry.wall_ns >= since_wall_ns) all.entries.push_back(entry);
  }
  const std::size_t count = all.entries.size();
  const std::size_t too_many = count - std::min(count, limit);
  all.entries.erase(all.entries.begin(),
                    all.entries.begin() + static_cast<std::ptrdiff_t>(too_many));
  return all;
}

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
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->reading = true;
  }
  std::thread([this, shared = shared_, journal = journal_, since = next.since_wall_ns,
               limit = next.limit] {
    const bool written = journal.Flush(kFlushTimeout);
    auto reading = ReadJournal(journal.path(), since, limit);
    if (!written) reading = WithUnwritten(std::move(reading), journal.Unwritten(), since, limit);
    const std::lock_guard lock(shared->mutex);
    shared->reading = false;
    shared->ended.notify_all();
    if (shared->loop == nullptr) return;
    shared->loop->Post([this, weak = std::weak_ptr(shared), reading = std::move(reading)] {
      const auto alive = weak.lock();
      if (alive && alive->loop != nullptr) OnRead(reading);
    });
  }).detach();
}

void HistoryReader::OnRead(const Result<JournalReading>& reading) {
  const OnHistory done = std::move(requests_.front().done);
  requests_.pop_front();
  if (!requests_.empty()) ReadNext();
  done(reading);
}

}  // namespace musher
