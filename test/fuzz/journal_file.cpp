// A journal whose file is damaged: some bytes differ, its end is missing. The reader returns the
// remaining rows or an error; it never returns a row that was not written.

#include <fstream>
#include <iterator>
#include <set>

#include "musher/controller/journal/journal_reader.hpp"
#include "musher/test/controller/recorded_robot.hpp"
#include "musher/test/fuzz/folder.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::fuzz {
namespace {

constexpr std::size_t kItems = 60;

struct Whole {
  Whole() {
    std::vector<JournalItem> items = RecordedLife();
    items.resize(std::min(items.size(), kItems));
    const std::string path = folder.path() + "/whole.sqlite";
    {
      Journal journal(path, {});
      for (JournalItem& item : items) {
        if (const auto* entry = std::get_if<JournalEntry>(&item)) messages.insert(entry->message);
        journal.Append(std::move(item));
      }
      Require(journal.Flush(std::chrono::seconds(60)), "the journal is written");
    }
    std::ifstream file(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  }

  Folder folder;
  std::set<std::string> messages;
  std::string bytes;
};

}  // namespace
}  // namespace musher::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace musher;
  static const fuzz::Whole whole;
  fuzz::Input input(data, size);
  std::string bytes = whole.bytes;
  const std::size_t missing = input.Take<std::uint16_t>();
  if (missing != 0) bytes.resize(bytes.size() - std::min(bytes.size(), missing * 7));
  while (!input.empty() && !bytes.empty()) {
    const std::size_t at = input.Take<std::uint32_t>() % bytes.size();
    const std::string_view patch = input.Text(bytes.size() - at);
    bytes.replace(at, patch.size(), patch);
  }
  const std::string path = whole.folder.Write("damaged.sqlite", bytes);
  const auto reading = ReadJournal(path, INT64_MIN, 10'000);
  fuzz::Require(reading.ok() || !reading.error().message.empty(), "either rows or an error");
  if (reading.ok()) {
    for (const JournalEntry& entry : reading.value().entries) {
      fuzz::Require(whole.messages.count(entry.message) > 0, "only written rows are returned");
    }
  }
  const auto recording = ReadRecording(path);
  fuzz::Require(recording.ok() || !recording.error().message.empty(), "either rows or an error");
  return 0;
}
