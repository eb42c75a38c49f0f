#pragma once
// A journal in a folder of its own, and what it said about trouble.

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "musher/controller/journal/journal_reader.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher {

inline constexpr Duration kFlushTimeout = Milliseconds(20000);
inline constexpr std::size_t kAll = 1000000;

class JournalTest : public ::testing::Test {
 protected:
  static JournalEntry Entry(std::int64_t wall_ns, std::string message = "") {
    JournalEntry entry;
    entry.wall_ns = wall_ns;
    entry.kind = "switch";
    entry.message = std::move(message);
    return entry;
  }

  // Retries only when flushed, so that a test decides when.
  JournalOptions Options() {
    JournalOptions options;
    options.retry_period = Milliseconds(3600000);
    options.on_moved = [this](const std::string& text) { Note(text); };
    options.on_writing = [this](const Result<>& written) {
      if (!written) Note(written.error().message);
    };
    return options;
  }

  // A directory where the file should be cannot be opened, and only this process can repair it.
  void BlockThePath() { std::filesystem::create_directory(path_); }
  void ClearThePath() { std::filesystem::remove(path_); }

  std::vector<std::string> Troubles() {
    const std::lock_guard lock(mutex_);
    return troubles_;
  }

  std::vector<JournalEntry> Read(std::int64_t since_wall_ns = 0, std::size_t limit = kAll) const {
    auto reading = ReadJournal(path_, since_wall_ns, limit);
    if (!reading) {
      ADD_FAILURE() << reading.error().message;
      return {};
    }
    EXPECT_EQ(reading.value().damage, "");
    return std::move(reading).value().entries;
  }

  static std::vector<std::int64_t> Times(const std::vector<JournalEntry>& entries) {
    std::vector<std::int64_t> times;
    times.reserve(entries.size());
    for (const auto& entry : entries) times.push_back(entry.wall_ns);
    return times;
  }

  TempFolder folder_;
  const std::string path_ = folder_ / "journal.sqlite";

 private:
  void Note(const std::string& text) {
    const std::lock_guard lock(mutex_);
    troubles_.push_back(text);
  }

  std::mutex mutex_;
  std::vector<std::string> troubles_;
};

}  // namespace musher
