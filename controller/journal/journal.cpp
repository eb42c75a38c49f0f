#include "musher/controller/journal/journal.hpp"

#include <pthread.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <iterator>
#include <mutex>
#include <thread>
#include <type_traits>
#include <utility>

#include "musher/controller/journal/journal_file.hpp"

namespace musher {

// The queue and the thread that empties it. `mutex_` guards all members below it; only the thread
// uses those above it.
class Journal::Writer {
 public:
  Writer(std::string path, JournalOptions options);

  static void Start(const std::shared_ptr<Writer>& writer);
  // Ends the thread, but waits only `stop_timeout` for it. No callback runs after it.
  void Stop();
  const std::string& path() const { return path_; }

  void Append(JournalItem item) noexcept;
  bool WantsSnapshot() noexcept { return wants_snapshot_.exchange(false); }
  bool Flush(Duration timeout);
  UnwrittenEntries Unwritten();

 private:
  using Lock = std::unique_lock<std::mutex>;

  void Run();
  void WriteUntilStopped();
  template <typename... Arguments>
  void Notify(std::function<void(Arguments...)> JournalOptions::*callback,
              const std::type_identity_t<Arguments>&... arguments);
  void WaitForWork(Lock& lock);
  bool Write(std::deque<JournalItem>& batch, std::uint64_t lost);
  void OnWritten();
  void OnFailed(const std::string& why);
  void PutBack(std::deque<JournalItem> batch);
  void DropOldest();

  const std::string path_;
  JournalOptions options_;
  std::mutex callbacks_;  // of the options: held while one runs
  JournalFile file_;
  bool in_trouble_ = false;
  bool removed_ = false;               // the file was, and no entry records it yet
  bool noted_ = false;                 // the state of writing is in the note beside the file
  std::optional<JournalGap> earlier_;  // that a controller before this one has left
  std::atomic<bool> wants_snapshot_ = false;

  std::mutex mutex_;
  std::condition_variable work_;       // the writer waits on it
  std::condition_variable attempted_;  // Flush() waits on it
  std::deque<JournalItem> waiting_;
  std::uint64_t lost_ = 0;
  std::uint64_t attempts_begun_ = 0;
  std::uint64_t attempts_ended_ = 0;
  bool last_attempt_worked_ = true;
  std::optional<JournalGap> gap_;  // while writing fails
  bool hurry_ = false;             // try now, before the retry period is over
  bool stop_ = false;
  bool ended_ = false;
  bool gathering_ = false;  // the writer needs no notification of more entries
};

namespace {

// Time for collecting entries before a write: most switches end within it, so that all their
// entries go into one transaction.
constexpr Duration kGatherTime = Milliseconds(5);
// Journal writes have a lower priority than the work of a switch.
constexpr int kNiceness = 10;

std::int64_t WallNs() {
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::nanoseconds(wall).count();
}

JournalEntry OwnEntry() {
  const auto steady = std::chrono::steady_clock::now().time_since_epoch();
  JournalEntry entry;
  entry.wall_ns = WallNs();
  entry.steady_ns = std::chrono::nanoseconds(steady).count();
  entry.kind = "journal";
  entry.code = kCodeFailed;
  return entry;
}

JournalEntry GapEntry(const JournalGap& gap) {
  JournalEntry entry = OwnEntry();
  entry.message =
      "entries are missing before this one: the controller before this one ended while it could "
      "not write the journal, since " +
      gap.Text();
  return entry;
}

JournalEntry RemovedEntry() {
  JournalEntry entry = OwnEntry();
  entry.message =
      "entries are missing before this one: the journal's file was removed while it was written, "
      "or another volume was mounted there";
  return entry;
}

JournalEntry LostEntry(std::uint64_t lost) {
  JournalEntry entry = OwnEntry();
  entry.message =
      "entries and inputs lost before this one because the queue was full: " + std::to_string(lost);
  entry.data = "{\"lost\":" + std::to_string(lost) + "}";
  return entry;
}

}  // namespace

Journal::Writer::Writer(std::string path, JournalOptions options)
    : path_(std::move(path)),
      options_(std::move(options)),
      file_(path_, options_.max_bytes,
            [this](const auto& text) { Notify(&JournalOptions::on_moved, "journal: " + text); }) {}

// No signal is delivered to the thread.
void Journal::Writer::Start(const std::shared_ptr<Writer>& writer) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread([writer] { writer->Run(); }).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void Journal::Writer::Stop() {
  {
    Lock lock(mutex_);
    stop_ = true;
    work_.notify_one();
    attempted_.wait_for(lock, options_.stop_timeout, [this] { return ended_; });
  }
  const std::lock_guard lock(callbacks_);
  options_.on_moved = nullptr;
  options_.on_writing = nullptr;
}

template <typename... Arguments>
void Journal::Writer::Notify(std::function<void(Arguments...)> JournalOptions::*callback,
                             const std::type_identity_t<Arguments>&... arguments) {
  const std::lock_guard lock(callbacks_);
  if (options_.*callback) (options_.*callback)(arguments...);
}

void Journal::Writer::Append(JournalItem item) noexcept {
  const Lock lock(mutex_);
  try {
    waiting_.push_back(std::move(item));
    DropOldest();
  } catch (const std::bad_alloc&) {
    ++lost_;
  }
  if (!gathering_) work_.notify_one();
}

bool Journal::Writer::Flush(Duration timeout) {
  Lock lock(mutex_);
  if (waiting_.empty() && attempts_begun_ == attempts_ended_) return last_attempt_worked_;
  // A running attempt has already taken its entries; later ones are written by the next.
  const std::uint64_t enough = attempts_begun_ + (waiting_.empty() ? 0 : 1);
  hurry_ = true;
  work_.notify_one();
  const bool in_time =
      attempted_.wait_for(lock, timeout, [&] { return attempts_ended_ >= enough; });
  return in_time && last_attempt_worked_;
}

void Journal::Writer::Run() {
  WriteUntilStopped();
  file_.Close();
  const Lock lock(mutex_);
  ended_ = true;
  attempted_.notify_all();
}

void Journal::Writer::WriteUntilStopped() {
  setpriority(PRIO_PROCESS, 0, kNiceness);  // of this thread; unchanged if not permitted
  earlier_ = ReadGap(path_);
  Lock lock(mutex_);
  while (true) {
    WaitForWork(lock);
    if (stop_ && waiting_.empty() && lost_ == 0) return;
    auto batch = std::exchange(waiting_, {});
    const auto lost = std::exchange(lost_, 0);
    hurry_ = false;
    ++attempts_begun_;
    lock.unlock();
    const bool worked = Write(batch, lost);
    lock.lock();
    if (!worked) {
      lost_ += lost;
      PutBack(std::move(batch));
    }
    last_attempt_worked_ = worked;
    ++attempts_ended_;
    attempted_.notify_all();
    if (stop_ && (!worked || waiting_.empty())) return;
  }
}

// Returns when there is something to write and it is time to try, or to stop.
void Journal::Writer::WaitForWork(Lock& lock) {
  if (in_trouble_) {
    work_.wait_for(lock, options_.retry_period, [&] { return stop_ || hurry_; });
  }
  const auto has_work = [&] { return stop_ || !waiting_.empty(); };
  while (!work_.wait_for(lock, options_.look_period, has_work)) {
    lock.unlock();
    removed_ |= file_.CloseIfRemoved();
    lock.lock();
    if (removed_) return;
  }
  gathering_ = true;
  work_.wait_for(lock, kGatherTime, [&] { return stop_ || hurry_; });
  gathering_ = false;
}

// Without the lock.
bool Journal::Writer::Write(std::deque<JournalItem>& batch, std::uint64_t lost) {
  removed_ |= file_.CloseIfRemoved();
  const std::size_t own = (earlier_ ? 1 : 0) + (removed_ ? 1 : 0) + (lost > 0 ? 1 : 0);
  if (lost > 0) batch.push_front(LostEntry(lost));
  if (removed_) {
    batch.push_front(RemovedEntry());
    noted_ = false;  // its file went as well
  }
  if (earlier_) batch.push_front(GapEntry(*earlier_));
  bool worked = true;
  try {
    const auto written = file_.Write(batch, lost);
    const bool begun = written != JournalFile::Written::kAll || removed_;
    if (lost > 0 || begun) wants_snapshot_ = true;
    removed_ = written == JournalFile::Written::kBegunAgain;
    OnWritten();
  } catch (const std::exception& trouble) {
    OnFailed(trouble.what());
    worked = false;
  }
  batch.erase(batch.begin(), batch.begin() + static_cast<std::ptrdiff_t>(own));
  return worked;
}

void Journal::Writer::OnWritten() {
  earlier_.reset();
  // The first time, this takes the room for a later note.
  if (!noted_) noted_ = WriteGap(path_, std::nullopt).ok();
  if (!std::exchange(in_trouble_, false)) return;
  {
    const Lock lock(mutex_);
    gap_.reset();
  }
  Notify(&JournalOptions::on_writing, Ok());
}

void Journal::Writer::OnFailed(const std::string& why) {
  if (std::exchange(in_trouble_, true)) return;
  const JournalGap gap = earlier_.value_or(JournalGap{WallNs(), why});
  static_cast<void>(WriteGap(path_, gap));  // on a broken disk there is no note
  noted_ = false;
  {
    const Lock lock(mutex_);
    gap_ = gap;
  }
  Notify(&JournalOptions::on_writing, Error{kCodeFailed, why});
}

UnwrittenEntries Journal::Writer::Unwritten() {
  const Lock lock(mutex_);
  UnwrittenEntries unwritten{{}, lost_, gap_};
  for (const JournalItem& item : waiting_) {
    if (const auto* entry = std::get_if<JournalEntry>(&item)) unwritten.entries.push_back(*entry);
  }
  return unwritten;
}

void Journal::Writer::PutBack(std::deque<JournalItem> batch) {
  batch.insert(batch.end(), std::make_move_iterator(waiting_.begin()),
               std::make_move_iterator(waiting_.end()));
  waiting_ = std::move(batch);
  DropOldest();
}

void Journal::Writer::DropOldest() {
  while (waiting_.size() > options_.max_waiting) {
    waiting_.pop_front();
    ++lost_;
  }
}

const std::string& Journal::Access::path() const {
  return writer_->path();
}

bool Journal::Access::Flush(Duration timeout) const {
  return writer_->Flush(timeout);
}

UnwrittenEntries Journal::Access::Unwritten() const {
  return writer_->Unwritten();
}

Journal::Journal(std::string path, JournalOptions options)
    : path_(std::move(path)), writer_(std::make_shared<Writer>(path_, std::move(options))) {
  Writer::Start(writer_);
}

Journal::~Journal() {
  writer_->Stop();
}

void Journal::Append(JournalItem item) noexcept {
  writer_->Append(std::move(item));
}

bool Journal::WantsSnapshot() noexcept {
  return writer_->WantsSnapshot();
}

}  // namespace musher
