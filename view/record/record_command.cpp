// musher-record record: topics, the journal and trouble into a file or a ring of files.

#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <utility>

#include "musher/base/date_text.hpp"
#include "musher/base/host.hpp"
#include "musher/base/words.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/dds/topic_watch.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/view/record/commands.hpp"
#include "musher/view/record/file_sink.hpp"
#include "musher/view/record/journal_recorder.hpp"
#include "musher/view/record/playback.hpp"
#include "musher/view/record/recorded_text.hpp"
#include "musher/view/record/schema.hpp"
#include "musher/view/record/topic_recorder.hpp"
#include "musher/view/record/trouble.hpp"
#include "musher/view/topics/reader_qos.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::view {
namespace {

constexpr Duration kLastSamples = Milliseconds(20);
constexpr Duration kSilentClose = std::chrono::seconds(2);
constexpr Duration kSignalPeriod = Milliseconds(100);

std::int64_t WallNow() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

mcap::Compression CompressionFrom(const std::string& name) {
  if (name == "none") return mcap::Compression::kNone;
  return name == "zstd" ? mcap::Compression::kZstd : mcap::Compression::kLz4;
}

std::string DefaultName() {
  return FormatLocal(WholeSeconds(WallNow()), "musher_%Y-%m-%d_%H-%M-%S.mcap");
}

// A recording under way.
class Session {
 public:
  Session(transport::EventLoop& loop, const RecordOptions& options)
      : loop_(loop), options_(options) {}

  Result<> Start();
  // `signals`: of EndSignals().
  int End(int signals);

 private:
  Result<> OpenSink();
  Result<> WatchMachine();
  void OnFound(const transport::DiscoveredEndpoint& endpoint);
  void Trouble(const std::string& reason);
  std::uint64_t SizeNow() const;
  std::string SizeOf(double seconds) const;
  void ShowProgress();
  Result<> Close(int signals);

  transport::EventLoop& loop_;
  const RecordOptions& options_;
  int exit_ = 0;
  bool said_unknown_ = false;
  bool said_whose_trouble_ = false;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<FileSink> file_;
  std::unique_ptr<RingSink> ring_;
  Sink* sink_ = nullptr;
  TroubleWatch trouble_;
  std::unique_ptr<TopicRecorder> topics_;
  std::unique_ptr<JournalRecorder> journal_;
  std::unique_ptr<transport::TopicWatch> watch_;
  transport::LoopHandlePtr limit_;
  std::string path_;  // of the file; empty: a ring
  Time began_;
  std::uint64_t shown_bytes_ = 0;
  transport::LoopHandlePtr progress_;  // on a terminal
};

Result<> Session::Start() {
  auto choice = TopicChoice::Of(options_.topics, options_.exclude, options_.where.name_space);
  if (!choice) return choice.error();
  Duration duration{};
  if (!options_.duration.empty()) {
    const auto parsed = DurationFrom(options_.duration);
    if (!parsed) return parsed.error();
    duration = parsed.value();
  }
  auto node = JoinDomain(loop_, options_.where);
  if (!node) return node.error();
  node_ = std::move(node).value();
  if (auto opened = OpenSink(); !opened) return opened;
  topics_ = std::make_unique<TopicRecorder>(*node_, std::move(choice).value(), *sink_, WallNow,
                                            [](const std::string& sentence) { Print(sentence); });
  auto watch = transport::WatchTopics(
      *node_, [this](const transport::DiscoveredEndpoint& endpoint) { OnFound(endpoint); },
      [this](transport::EndpointId id) { topics_->OnLost(id); });
  if (!watch) return watch.error();
  watch_ = std::move(watch).value();
  if (auto watching = WatchMachine(); !watching) return watching;
  if (duration > Duration{}) {
    limit_ = loop_.At(loop_.Now() + duration, [this] { loop_.Stop(); });
  }
  return Ok();
}

Result<> Session::OpenSink() {
  FileSinkOptions file;
  file.path = options_.output.empty() ? DefaultName() : options_.output;
  file.compression = CompressionFrom(options_.compression);
  if (!options_.max_size.empty()) {
    const auto bytes = BytesFrom(options_.max_size);
    if (!bytes) return bytes.error();
    file.max_bytes = bytes.value();
  }
  if (options_.ring.empty()) {
    auto sink = FileSink::Open(loop_, file, [this](const std::string& why) {
      Print("the recording ends: " + why);
      exit_ = why.find("--max-size") == std::string::npos ? 1 : 0;
      loop_.Stop();
    });
    if (!sink) return sink.error();
    file_ = std::move(sink).value();
    sink_ = file_.get();
    path_ = file.path;
    began_ = loop_.Now();
    if (OnTerminal()) {
      progress_ = loop_.Every(std::chrono::seconds(1), [this] { ShowProgress(); });
    }
    Print("recording into " + file.path + "; Ctrl-C ends it");
    return Ok();
  }
  RingOptions ring;
  const auto length = DurationFrom(options_.ring);
  if (!length) return length.error();
  ring.length = length.value();
  ring.max_kept = options_.keep;
  if (options_.output.empty()) file.path = "musher_ring";
  file.max_bytes = 0;
  auto sink = RingSink::Open(loop_, file, ring, WallNow,
                             [](const std::string& sentence) { Print(sentence); });
  if (!sink) return sink.error();
  ring_ = std::move(sink).value();
  sink_ = ring_.get();
  Print("the last " + options_.ring + " are in a ring; trouble is kept in " + file.path);
  return Ok();
}

Result<> Session::WatchMachine() {
  JournalRecorder::Events events;
  events.on_event = [this](const std::string& event) {
    if (const auto reason = TroubleOf(event)) Trouble(*reason);
  };
  events.on_status = [this](const msg::MachineStatus& status) {
    if (ring_ && !std::exchange(said_whose_trouble_, true)) {
      Print("trouble of " + (status.machine.empty() ? "the machine" : status.machine) + " is kept");
    }
    if (const auto reason = trouble_.On(status)) Trouble(*reason);
  };
  auto journal = JournalRecorder::Make(*node_, options_.where.name_space, HostId(), *sink_,
                                       WallNow(), std::move(events));
  if (!journal) return journal.error();
  journal_ = std::move(journal).value();
  return Ok();
}

void Session::OnFound(const transport::DiscoveredEndpoint& endpoint) {
  if (!endpoint.writer) return;
  const std::size_t before = topics_->topics();
  topics_->OnFound({endpoint.id, endpoint.topic, endpoint.type, QosOf(endpoint)});
  const bool is_new = topics_->topics() > before;
  if (is_new && SchemaText(endpoint.type).empty() && !std::exchange(said_unknown_, true)) {
    Print("the type " + RosType(endpoint.type) + " of " + RosTopic(endpoint.topic) +
          " is unknown to Musher; such topics are recorded without a schema");
  }
}

void Session::Trouble(const std::string& reason) {
  if (!ring_) return;
  Print("trouble: " + reason);
  ring_->OnTrouble(reason);
}

std::uint64_t Session::SizeNow() const {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path_, error);
  return error ? 0 : size;
}

// Of the whole recording: "; 12.3 MB in 10.2 s, 1.2 MB/s". Of a ring, whose size is bounded,
// nothing.
std::string Session::SizeOf(double seconds) const {
  if (path_.empty()) return "";
  const std::uint64_t bytes = SizeNow();
  return "; " + RecordedText(bytes, seconds, static_cast<double>(bytes) / std::max(seconds, 0.001));
}

// What is on disk; the rate is that of the last second.
void Session::ShowProgress() {
  const std::uint64_t bytes = SizeNow();
  const std::uint64_t more = bytes - std::min(bytes, std::exchange(shown_bytes_, bytes));
  ShowLine(RecordedText(bytes, ToSeconds(loop_.Now() - began_), static_cast<double>(more)));
}

// Writes what waits and ends the file, on a thread of its own: a disk that hangs may hold that one
// for ever. This one does nothing else meanwhile but take a second signal.
Result<> Session::Close(int signals) {
  signalfd_siginfo info{};
  while (read(signals, &info, sizeof info) > 0) continue;  // those that have ended the recording
  auto closed =
      std::async(std::launch::async, [this] { return file_ ? file_->Close() : ring_->Close(); });
  if (closed.wait_for(kSilentClose) == std::future_status::ready) return closed.get();
  Print("waits for its disk to take the rest; a second Ctrl-C ends it without");
  while (closed.wait_for(kSignalPeriod) != std::future_status::ready) {
    if (read(signals, &info, sizeof info) <= 0) continue;
    Print("ended before its disk had taken everything");
    std::_Exit(1);
  }
  return closed.get();
}

int Session::End(int signals) {
  progress_.reset();
  const double seconds = ToSeconds(loop_.Now() - began_);
  // Samples that arrived before the end are recorded, later ones neither recorded nor counted.
  static_cast<void>(loop_.RunUntil([] { return false; }, loop_.Now() + kLastSamples));
  watch_.reset();
  topics_->Stop();
  const std::uint64_t of_journal = journal_->entries();
  std::uint64_t lost = journal_->lost();
  journal_.reset();
  const auto closed = Close(signals);
  // What the disk's thread has reported meanwhile.
  static_cast<void>(loop_.RunUntil([] { return false; }, loop_.Now() + Milliseconds(1)));
  if (!closed && exit_ == 0) exit_ = Fail(closed.error(), 1);
  std::uint64_t messages = 0;
  const auto counts = topics_->Counts();
  for (const auto& [topic, count] : counts) {
    messages += count.messages;
    lost += count.lost;
    if (count.lost > 0) Print(topic + ": " + std::to_string(count.lost) + " lost");
  }
  for (const std::string& pattern : topics_->choice().Unmatched()) {
    Print("no topic matched " + pattern);
  }
  Print(Counted(counts.size(), "topic") + ", " + Counted(messages, "message") + ", " +
        Counted(of_journal, "entry", "entries") + " of the journal, " + std::to_string(lost) +
        " lost" + SizeOf(seconds));
  return exit_;
}

}  // namespace

int RunRecord(const RecordOptions& options) {
  const auto signals = EndSignals();
  if (!signals) return Fail(signals.error(), 1);
  transport::LinuxEventLoop loop;
  Session session(loop, options);
  if (auto started = session.Start(); !started) return Fail(started.error());
  const auto ending = loop.WhenReadable(signals.value().get(), [&loop] { loop.Stop(); });
  loop.Run();
  return session.End(signals.value().get());
}

}  // namespace musher::view
