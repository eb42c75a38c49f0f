#include "musher/behavior/tree/recorder.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "musher/base/checksum.hpp"
#include "musher/behavior/recording_line.hpp"
#include "musher/behavior/tree/write_tree.hpp"

namespace musher::tree {
namespace {

constexpr std::size_t kChecksum = 10;  // " #" and eight digits

std::string ChecksumOf(std::string_view line, const RecordingChain& chain) {
  const std::uint64_t hash = Fnv1a(chain + std::string(line));
  std::string text = " #00000000";
  std::array<char, 8> digits{};
  const auto* const end = std::to_chars(digits.data(), digits.data() + digits.size(),
                                        static_cast<std::uint32_t>(hash ^ (hash >> 32)), 16)
                              .ptr;
  const auto count = static_cast<std::size_t>(end - digits.data());
  text.replace(text.size() - count, count, digits.data(), count);
  return text;
}

// At most so many bytes, without a part of a character at the end.
std::string Cut(std::string text) {
  if (text.size() <= Recorder::kMostValue) return text;
  std::size_t end = Recorder::kMostValue;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  text.resize(end);
  return text + "…";
}

}  // namespace

void EndRecordingLine(std::string& line, RecordingChain& chain) {
  chain = ChecksumOf(line, chain);
  line += chain;
  line += '\n';
}

std::optional<std::string_view> WithoutChecksum(std::string_view line, RecordingChain& chain) {
  if (line.size() < kChecksum) return std::nullopt;
  const std::string_view text = line.substr(0, line.size() - kChecksum);
  std::string checksum = ChecksumOf(text, chain);
  if (line.substr(text.size()) != checksum) return std::nullopt;
  chain = std::move(checksum);
  return text;
}

void Recorder::Head(std::string_view actuator) {
  chain_.clear();
  std::string line(kRecordingFormat);
  AppendWord(line, actuator);
  Write(std::move(line));
}

void Recorder::Begin(Recorded recorded, std::uint64_t wall_us) {
  recorded_ = std::move(recorded);
  const Tree& tree = *recorded_.tree;
  last_ = {};
  state_ = {};
  std::string line = "tree";
  AppendNumber(line, recorded_.revision);
  AppendWord(line, tree.name());
  AppendWord(line,
             WriteTree(tree, *recorded_.document, {.with_ids = true, .models = recorded_.factory}));
  description_ = {std::move(line)};
  for (NodeId id = 0; id < tree.size(); ++id) {
    const NodeInfo& info = tree.info(id);
    line = "node";
    AppendWord(line, info.name);
    AppendWord(line, info.id);
    AppendWord(line, Name(info.kind));
    AppendWord(line, info.parent == kNoNode ? "-1" : std::to_string(info.parent));
    description_.push_back(line);
  }
  BeginAgain(wall_us);
}

void Recorder::BeginAgain(std::uint64_t wall_us) {
  if (recorded_.tree == nullptr) return;
  state_.wall_us = wall_us;
  for (const std::string& line : description_) Write(line);
  for (NodeId id = 0; id < recorded_.tree->size(); ++id) {
    const Status status = recorded_.tree->status(id);
    if (status == Status::kIdle) continue;
    std::string line = "is";
    AppendTime(line, last_);
    AppendNumber(line, id);
    AppendWord(line, Name(status));
    Write(std::move(line));
  }
  FindEntries();
  WriteEntries(true);
  WriteState();
}

void Recorder::Note(const State& state) {
  if (recorded_.tree == nullptr) return;
  static_cast<void>(Now(state.at));
  const bool more = Keys() != keys_;
  if (more) FindEntries();
  WriteEntries(more);
  const State before = std::exchange(state_, state);
  const bool due = state.ticking && last_ >= state_at_ + kStatePeriod;
  if (due || state.ticking != before.ticking || state.result != before.result) WriteState();
  if (state.fault == before.fault) return;
  std::string line = "fault";
  AppendTime(line, last_);
  AppendWord(line, Cut(state_.fault));
  Write(std::move(line));
}

void Recorder::Lost(std::uint64_t lines) {
  chain_.clear();
  std::string line(kLostLine);
  AppendTime(line, last_);
  AppendNumber(line, lines);
  Write(std::move(line));
}

void Recorder::OnChange(const Change& change) {
  if (recorded_.tree == nullptr) return;
  std::string line = "change";
  AppendTime(line, Now(change.at));
  AppendNumber(line, change.node);
  AppendWord(line, Name(change.from));
  AppendWord(line, Name(change.to));
  Write(std::move(line));
}

void Recorder::FindEntries() {
  entries_.clear();
  boards_.clear();
  Tree& tree = *recorded_.tree;
  for (NodeId id = 0; id < tree.size(); ++id) {
    Board& board = tree.board(id);
    if (std::ranges::find(boards_, &board) != boards_.end()) continue;
    boards_.push_back(&board);
    const NodeInfo& info = tree.info(id);
    const std::string path = info.parent == kNoNode ? "" : tree.Path(info.parent);
    for (const std::string& key : board.Keys()) {
      entries_.push_back({path, key, board.Find(key), 0, ""});
    }
  }
  keys_ = Keys();
}

std::size_t Recorder::Keys() const {
  std::size_t keys = 0;
  for (const Board* board : boards_) keys += board->size();
  return keys;
}

void Recorder::WriteEntries(bool all) {
  for (Watched& each : entries_) {
    if (!all && each.entry->sequence == each.sequence) continue;
    each.sequence = each.entry->sequence;
    const Value& value = each.entry->value;
    std::string text = value.empty() ? "" : Cut(value.Shown());
    if (text == each.text && !all) continue;
    each.text = std::move(text);
    std::string line = "set";
    AppendTime(line, last_);
    AppendWord(line, each.board);
    AppendWord(line, each.key);
    AppendWord(line, value.empty() ? "" : value.type()->name);
    AppendWord(line, each.text);
    Write(std::move(line));
  }
}

void Recorder::WriteState() {
  state_at_ = last_;
  std::string line = "state";
  AppendTime(line, last_);
  AppendWord(line, state_.ticking ? "ticking" : "paused");
  AppendWord(line, Name(state_.result));
  AppendNumber(line, state_.wall_us);
  Write(std::move(line));
}

void Recorder::Write(std::string line) {
  EndRecordingLine(line, chain_);
  sink_(line);
}

// Never before the last one.
Duration Recorder::Now(Time at) {
  last_ = std::max(last_, recorded_.time(at));
  return last_;
}

}  // namespace musher::tree
