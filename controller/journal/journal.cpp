#include "musher/controller/journal/journal.hpp"

#include <atomic>
#include <chrono>
#include <deque>
#include <iterator>
#include <mutex>
#include <type_traits>
#include <utility>

#include "musher/base/work_queue.hpp"
#include "musher/controller/journal/journal_file.hpp"

namespace musher {

// What waits, and the attempts to write it. `mutex_` guards all members below it; only the thread
// uses those above it.
class Journal::Writer : public std::enable_shared_from_this<Journal::Writer> {
 public:
  Writer(std::string path, JournalOptions options);

  void Start();
  // Writes what waits and ends the thread, but waits only `stop_timeout` for it. No callback runs
  // after it.
  void Stop();
  const std::string& path() const { return path_; }

  void Append(JournalItem item) noexcept;
  bool WantsSnapshot() noexcept { return wants_snapshot_.exchange(false); }
  bool Flush(Duration timeout);
  UnwrittenEntries Unwritten();

 private:
  using Lock = std::unique_lock<std::mutex>;

  void Turn(Duration after);
  Time TakeTurn();
  void Finish();
  bool Attempt();
  template <typename... Arguments>
  void Notify(std::function<void(Arguments...)> JournalOptions::*callback,
              const std::type_identity_t<Arguments>&... arguments);
  bool Write(std::deque<JournalItem>& batch, std::uint64_t lost);
  void OnWritten();
  void OnFailed(const std::string& why);
  void PutBack(std::deque<JournalItem> batch);
  void DropOldest();

  const std::string path_;
  JournalOptions options_;
  std::mutex callbacks_;  // of the options: held while one runs
  JournalFile file_;
  bool begun_ = false;
  bool in_trouble_ = false;
  bool removed_ = false;               // the file was, and no entry records it yet
  bool noted_ = false;                 // the state of writing is in the note beside the file
  std::optional<JournalGap> earlier_;  // that a controller before this one has left
  std::atomic<bool> wants_snapshot_ = false;

  std::mutex mutex_;
  std::deque<JournalItem> waiting_;
  std::uint64_t lost_ = 0;
  std::uint64_t attempts_begun_ = 0;
  std::uint64_t attempts_ended_ = 0;
  bool last_attempt_worked_ = true;
  std::optional<JournalGap> gap_;      // while writing fails
  bool write_is_due_ = false;          // the next turn of the thread writes
  std::shared_ptr<WorkQueue> thread_;  // of the journal; none once it is destroyed
};

namespace {

// Time for collecting entries before a write: most switches end within it, so that all their
// entries go into one transaction.
constexpr Duration kGatherTime = Milliseconds(5);
// Journal writes have a lower priority than the work of a switch.
constexpr int kNiceness = 10;
constexpr const char* kTurn = "turn";  // the key of the thread's work

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

void Journal::Writer::Start() {
  const Lock lock(mutex_);
  thread_ = std::make_shared<WorkQueue>(WorkQueueOptions{.name = "journal",
                                                         .niceness = kNiceness,
                                                         .takes_signals = false,
                                                         .end_timeout = options_.stop_timeout});
  Turn(Duration::zero());
}

void Journal::Writer::Stop() {
  std::shared_ptr<WorkQueue> thread;
  {
    const Lock lock(mutex_);
    thread = std::exchange(thread_, nullptr);
  }
  thread->Do([writer = shared_from_this()] { writer->Finish(); }, {.key = kTurn});
  thread->End();
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
    if (!write_is_due_ && thread_) {
      Turn(kGatherTime);
      write_is_due_ = true;
    }
  } catch (const std::bad_alloc&) {
    ++lost_;
  }
}

bool Journal::Writer::Flush(Duration timeout) {
  const Time end = std::chrono::steady_clock::now() + timeout;
  Lock lock(mutex_);
  if (waiting_.empty() && attempts_begun_ == attempts_ended_) return last_attempt_worked_;
  // A running attempt has already taken its entries; later ones are written by the next.
  const std::uint64_t enough = attempts_begun_ + (waiting_.empty() ? 0 : 1);
  while (attempts_ended_ < enough) {
    const std::shared_ptr<WorkQueue> thread = thread_;
    lock.unlock();
    if (!thread || !thread->Flush(end - std::chrono::steady_clock::now())) return false;
    lock.lock();
  }
  return last_attempt_worked_;
}

// With the lock: the thread's next turn. It replaces the one that waits.
void Journal::Writer::Turn(Duration after) {
  thread_->DoUntilDone([writer = shared_from_this()] { return std::optional(writer->TakeTurn()); },
                       {.key = kTurn, .not_before = std::chrono::steady_clock::now() + after});
}

// Writes what waits, or looks whether the file is still there; returns the time of the next turn.
Time Journal::Writer::TakeTurn() {
  if (!std::exchange(begun_, true)) earlier_ = ReadGap(path_);
  bool due = false;
  {
    const Lock lock(mutex_);
    due = write_is_due_;
  }
  if (!due) removed_ |= file_.CloseIfRemoved();
  const bool worked = (!due && !removed_) || Attempt();
  const Time now = std::chrono::steady_clock::now();
  const Lock lock(mutex_);
  if (!worked) {
    write_is_due_ = true;
    return now + options_.retry_period;
  }
  if (due) write_is_due_ = !waiting_.empty();
  return now + (write_is_due_ ? kGatherTime : options_.look_period);
}

// The last turn.
void Journal::Writer::Finish() {
  if (!std::exchange(begun_, true)) earlier_ = ReadGap(path_);
  const auto has_work = [this] {
    const Lock lock(mutex_);
    return !waiting_.empty() || lost_ > 0;
  };
  while (has_work() && Attempt()) continue;
  file_.Close();
}

// Returns whether all that waited is written.
bool Journal::Writer::Attempt() {
  Lock lock(mutex_);
  auto batch = std::exchange(waiting_, {});
  const auto lost = std::exchange(lost_, 0);
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
  return worked;
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
  writer_->Start();
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
