// Reads the lines of a recording. The last one may be incomplete, if power was lost.

#include <algorithm>
#include <array>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/behavior/recording_line.hpp"
#include "musher/behavior/tree/recorder.hpp"
#include "musher/behavior/tree/recording.hpp"

namespace musher::tree {
namespace {

using Event = RecordedEvent;
using Kind = Event::Kind;

constexpr std::string_view kUnchainedFormat = "musher-tree-recording 1 ";  // of earlier versions
constexpr std::uint64_t kMostWallUs = std::uint64_t{1} << 60;
constexpr std::array<std::string_view, 8> kLines = {"tree",   "node",  "is",    "set",
                                                    "change", "state", "fault", "lost"};
constexpr std::array<Status, 5> kStatuses = {Status::kIdle, Status::kRunning, Status::kSuccess,
                                             Status::kFailure, Status::kSkipped};

Status StatusFrom(RecordingLine& line) {
  const std::string word = line.Word();
  const auto* const found =
      std::ranges::find_if(kStatuses, [&](Status status) { return Name(status) == word; });
  if (found == kStatuses.end()) line.Fail("'" + word + "' is not a status of a node");
  return *found;
}

class TreeRecordingReader {
 public:
  TreeRecordingReader(std::string_view text, const std::string& file) : text_(text) {
    recording_.file = file;
  }

  Recording Read() && {
    const bool any = NextLine();
    chained_ = line_text_.starts_with(std::string(kRecordingFormat) + " ");
    if (!any || (!chained_ && !line_text_.starts_with(kUnchainedFormat))) {
      RecordingLine(line_text_, recording_.file, 1)
          .Fail("the recording of a tree begins with \"" + std::string(kRecordingFormat) +
                "\" and the name of an actuator");
    }
    RecordingLine head = Checked();
    head.Word();
    head.Word();
    recording_.actuator = head.Word();
    head.End();
    while (NextLine()) ReadLine();
    if (!text_.empty()) recording_.cut_at = number_;
    return std::move(recording_);
  }

 private:
  // Takes a complete line.
  bool NextLine() {
    ++number_;
    const std::size_t end = text_.find('\n');
    line_text_ = text_.substr(0, end);
    if (end == std::string_view::npos) return false;
    text_.remove_prefix(end + 1);
    return true;
  }

  RecordingLine Checked() {
    if (!chained_ || line_text_.starts_with(std::string(kLostLine) + " ")) chain_.clear();
    const auto text = WithoutChecksum(line_text_, chain_);
    if (!text) {
      RecordingLine(line_text_, recording_.file, number_)
          .Fail(
              "the line is damaged, or lines before it are missing, doubled or at another place: "
              "it does not match its checksum");
    }
    return {*text, recording_.file, number_};
  }

  void ReadLine() {
    RecordingLine line = Checked();
    const std::string word = line.Word();
    if (word == "tree") {
      BeginTree(line);
    } else if (std::ranges::find(kLines, word) == kLines.end()) {
      line.Fail(word + " is not a kind of line" + DidYouMean(word, kLines));
    } else if (recording_.trees.empty()) {
      line.Fail("a tree is missing before this line");
    } else if (word == "node") {
      AddNode(line);
    } else {
      AddEvent(line, word);
    }
    line.End();
  }

  void BeginTree(RecordingLine& line) {
    RecordedTree tree;
    tree.revision = static_cast<std::uint32_t>(line.Number(UINT32_MAX));
    tree.name = line.Word();
    tree.xml = line.Word();
    recording_.trees.push_back(std::move(tree));
    statuses_.clear();
    last_ = {};
  }

  void AddNode(RecordingLine& line) {
    RecordedTree& tree = recording_.trees.back();
    if (!tree.events.empty()) line.Fail("a node after the first event of its tree");
    RecordedNode node{line.Word(), line.Word(), line.Word(), std::nullopt};
    if (tree.nodes.empty()) {
      if (line.Word() != "-1") line.Fail("the first node is the root; expected -1");
    } else {
      node.parent = static_cast<NodeId>(line.Number(tree.nodes.size() - 1));
    }
    tree.nodes.push_back(std::move(node));
    statuses_.push_back(Status::kIdle);
  }

  void AddEvent(RecordingLine& line, const std::string& word) {
    Event event;
    event.at = line.Seconds();
    if (event.at < last_) line.Fail("the time is before that of the line above");
    last_ = event.at;
    if (word == "is" || word == "change") {
      ReadChange(line, word == "is", event);
    } else if (word == "set") {
      event.kind = Kind::kSet;
      event.board = line.Word();
      event.key = line.Word();
      event.type = line.Word();
      event.text = line.Word();
    } else if (word == "state") {
      event.kind = Kind::kState;
      const std::string state = line.Word();
      if (state != "ticking" && state != "paused") line.Fail("expected ticking or paused");
      event.ticking = state == "ticking";
      event.result = StatusFrom(line);
      event.wall_us = line.Number(kMostWallUs);
    } else if (word == "fault") {
      event.kind = Kind::kFault;
      event.text = line.Word();
    } else {
      event.kind = Kind::kLost;
      event.lines = line.Number(UINT64_MAX);
    }
    recording_.trees.back().events.push_back(std::move(event));
  }

  void ReadChange(RecordingLine& line, bool is, Event& event) {
    event.kind = is ? Kind::kIs : Kind::kChange;
    if (statuses_.empty()) line.Fail("the tree has no nodes");
    const auto node = static_cast<NodeId>(line.Number(statuses_.size() - 1));
    const Status from = is ? Status::kIdle : StatusFrom(line);
    if (from != statuses_[node]) {
      line.Fail("node " + std::to_string(node) + " is " + std::string(Name(statuses_[node])) +
                " here; a line is missing");
    }
    const Status to = StatusFrom(line);
    event.change = {kRecordedOrigin + event.at, node, from, to};
    statuses_[node] = to;
  }

  std::string_view text_;  // what is left
  std::string_view line_text_;
  int number_ = 0;
  bool chained_ = true;
  RecordingChain chain_;
  Recording recording_;
  std::vector<Status> statuses_;  // of the present tree
  Duration last_{};
};

}  // namespace

Result<Recording> ReadRecording(std::string_view text, const std::string& file) {
  try {
    return TreeRecordingReader(text, file).Read();
  } catch (Error& fault) {
    return std::move(fault);
  }
}

}  // namespace musher::tree
