// The recording of a tree, and its playback.

#include "musher/behavior/tree/recording.hpp"

#include <random>

#include "musher/behavior/tree/recorder.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::recording_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::uint64_t kWallUs = 1'772'366'405'000'000;
constexpr const char* kRest = R"(<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence>
      <Say name="first" does="RS"/>
      <Script code="steps := 1"/>
      <SubTree ID="Rest" name="rest" long="7"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Rest"><Say name="second" does="RRF"/></BehaviorTree>
</root>
)";

struct Recorded : testing::Test, Logged {
  Recorded() {
    recorder->Head("patrol");
    Begin(kRest);
  }
  void Begin(const char* xml) {
    document = ReadTree(xml, "t.xml").document;
    tree = Build(document, factory).tree;
    recorder->Begin({.tree = tree.get(),
                     .document = &document,
                     .factory = &factory,
                     .revision = 3,
                     .time = [](Time at) { return at.time_since_epoch(); }},
                    kWallUs);
    tree->Listen(recorder);
  }
  void TickOnce() {
    const Result<Status> result = tree->TickExactlyOnce(At(100 * ticks));
    recorder->Note({.at = At(100 * ticks),
                    .wall_us = kWallUs + 100'000U * static_cast<std::uint64_t>(ticks),
                    .ticking = true,
                    .result = result ? result.value() : Status::kFailure,
                    .fault = result ? "" : result.error().message});
    ++ticks;
  }
  // Five ticks: the tree fails in the fourth, and begins again.
  void Run() {
    for (int i = 0; i < 5; ++i) TickOnce();
  }
  Recording Read() const {
    const Result<Recording> read = ReadRecording(text, "p.tree");
    EXPECT_TRUE(read) << read.error().message;
    return read ? read.value() : Recording{};
  }
  std::string Refused(const std::string& wrong) const {
    const Result<Recording> read = ReadRecording(wrong, "p.tree");
    return read ? "" : read.error().message;
  }
  // The line that begins so, with its end.
  std::string Line(const std::string& begin) const {
    const std::size_t at = text.find("\n" + begin) + 1;
    return text.substr(at, text.find('\n', at) + 1 - at);
  }
  // `text` with another line, of the right checksum, in place of one.
  std::string With(const std::string& line, const std::string& other) const {
    std::string all = text;
    const std::size_t at = all.find(line);
    RecordingChain chain = all.substr(at - 11, 10);  // of the line above
    std::string changed = other;
    EndRecordingLine(changed, chain);
    return all.replace(at, line.size(), changed);
  }

  std::string text;
  Document document;
  std::unique_ptr<Tree> tree;
  std::shared_ptr<Recorder> recorder =
      std::make_shared<Recorder>([this](std::string_view lines) { text += lines; });
  int ticks = 0;
};

TEST_F(Recorded, HasTheTreeItsChangesAndItsEntries) {
  Run();
  const Recording recording = Read();
  EXPECT_EQ(recording.actuator, "patrol");
  EXPECT_FALSE(recording.cut_at);
  ASSERT_EQ(recording.trees.size(), 1U);
  const RecordedTree& recorded = recording.trees.front();
  EXPECT_EQ(recorded.name, "Main");
  EXPECT_EQ(recorded.revision, 3U);
  EXPECT_THAT(recorded.xml, HasSubstr("<Say name=\"first\" does=\"RS\" _uid=\"2\"/>"));
  ASSERT_EQ(recorded.nodes.size(), 5U);
  EXPECT_EQ(recorded.nodes[4].name, "second");
  EXPECT_EQ(recorded.nodes[4].type, "Say");
  EXPECT_EQ(recorded.nodes[4].parent, 3U);
  EXPECT_EQ(recorded.nodes[3].kind, "SubTree");
  EXPECT_EQ(recorded.End(), Milliseconds(400));
  EXPECT_THAT(text, AllOf(StartsWith("musher-tree-recording 2 patrol #"),
                          HasSubstr("\nset 0 \"Main/Sequence/rest\" long number 7 #"),
                          HasSubstr("\nset 0.1 \"\" steps number 1 #"),
                          HasSubstr("\nchange 0.1 1 RUNNING SUCCESS #"),
                          HasSubstr("\nchange 0.3 1 SUCCESS IDLE #"),
                          HasSubstr("\nstate 0 ticking RUNNING 1772366405000000 #")));
}

TEST_F(Recorded, HasWholeNumbersAsWholeNumbers) {
  Begin(R"(<root BTCPP_format="4"><BehaviorTree ID="Large">
    <Script code="steps := 100000"/></BehaviorTree></root>)");
  TickOnce();
  EXPECT_THAT(text, HasSubstr("\" steps number 100000 #"));
}

TEST_F(Recorded, ShowsHowLongANodeRanUntilACrash) {
  text.clear();
  recorder->Head("patrol");
  Begin(R"(<root BTCPP_format="4"><BehaviorTree ID="Long">
    <Say name="stuck" does="RRRRRRRRRRRRRRRRRRRRRRRRRRRRRRRR"/></BehaviorTree></root>)");
  for (int i = 0; i < 26; ++i) TickOnce();
  const Recording recording = Read();
  ASSERT_EQ(recording.trees.size(), 1U);
  EXPECT_EQ(recording.trees.front().End(), Milliseconds(2000));  // the last second, of 2.5 s
}

TEST_F(Recorded, IsPlayedAsTheTreeWas) {
  std::vector<std::vector<Status>> was;
  for (int i = 0; i < 9; ++i) {
    TickOnce();
    was.emplace_back();
    for (NodeId id = 0; id < tree->size(); ++id) was.back().push_back(tree->status(id));
  }
  const Recording recording = Read();
  Playback playback(recording.trees.front());
  for (int i = 0; i < 9; ++i) {
    playback.To(Milliseconds(100 * i));
    for (NodeId id = 0; id < tree->size(); ++id) EXPECT_EQ(playback.status(id), was[i][id]) << i;
  }
  for (NodeId id = 0; id < tree->size(); ++id) {
    EXPECT_EQ(playback.runs(id).starts, tree->runs(id).starts) << id;
    EXPECT_EQ(playback.Spent(id), tree->Spent(id, At(800))) << id;
  }
  EXPECT_EQ(playback.entries().at(1).key, "long");
  EXPECT_EQ(playback.entries().at(0).value, "1");
  EXPECT_TRUE(playback.ticking());
  EXPECT_EQ(playback.result(), Status::kRunning);
  EXPECT_EQ(playback.WallAt(Milliseconds(800)), kWallUs + 800'000);
}

TEST_F(Recorded, GoesOnWithThePresentStateInANewFile) {
  TickOnce();
  text.clear();
  recorder->Head("patrol");
  recorder->BeginAgain(kWallUs);
  TickOnce();
  const Recording recording = Read();
  Playback playback(recording.trees.front());
  playback.To({});
  EXPECT_EQ(playback.status(1), Status::kRunning);
  EXPECT_EQ(playback.status(0), Status::kRunning);
  playback.To(Milliseconds(100));
  EXPECT_EQ(playback.status(1), Status::kSuccess);
}

TEST_F(Recorded, ThatIsCutAnywhereIsReadUpToThere) {
  Run();
  const std::size_t whole = Read().trees.front().events.size();
  const std::size_t head = text.find('\n') + 1;
  for (std::size_t size = head; size < text.size(); ++size) {
    const Result<Recording> read = ReadRecording(text.substr(0, size), "p.tree");
    ASSERT_TRUE(read) << size << read.error().message;
    EXPECT_EQ(read.value().cut_at.has_value(), text[size - 1] != '\n') << size;
    if (!read.value().trees.empty()) {
      EXPECT_LE(read.value().trees.front().events.size(), whole);
    }
  }
  const Result<Recording> zeros = ReadRecording(text + std::string(100, '\0'), "p.tree");
  ASSERT_TRUE(zeros) << "blocks that were never written";
  EXPECT_EQ(zeros.value().cut_at, std::ranges::count(text, '\n') + 1);
  EXPECT_EQ(zeros.value().trees.front().events.size(), whole);
}

TEST_F(Recorded, ThatIsDamagedOrForeignIsRefusedWithThePlace) {
  Run();
  EXPECT_THAT(Refused(""), StartsWith("p.tree:1:1: error: the recording of a tree begins with"));
  EXPECT_THAT(Refused("musher-tree-recording 12 show\n"),
              StartsWith("p.tree:1:1: error: the recording of a tree begins with"));
  EXPECT_THAT(Refused("musher-fsm-recording 1 show\n"), StartsWith("p.tree:1:1: error: "));
  EXPECT_THAT(Refused(text.substr(0, 30)), StartsWith("p.tree:1:1: error: "));
  std::string flipped = text;
  flipped[flipped.find("\nchange 0.1 ") + 9] = '2';
  EXPECT_THAT(Refused(flipped),
              AllOf(StartsWith("p.tree:"),
                    HasSubstr(":1: error: the line is damaged, or lines before it are missing")));
  const std::string change = Line("change 0.1 1 RUNNING SUCCESS");
  std::string missing = text;
  missing.erase(missing.find(change), change.size());
  EXPECT_THAT(Refused(missing),
              HasSubstr("lines before it are missing, doubled or at another place"));
  EXPECT_THAT(Refused(With(change, "change 0.1 9 RUNNING SUCCESS")),
              HasSubstr(":12: error: invalid number 9; expected 0 to 4"));
  EXPECT_THAT(Refused(With(change, "change 0.1 1 RUNNING DONE")),
              HasSubstr(":22: error: 'DONE' is not a status of a node"));
  EXPECT_THAT(Refused(With(change, "change -1 1 RUNNING SUCCESS")),
              HasSubstr(":8: error: the time is before that of the line above"));
  EXPECT_THAT(Refused(With(change, "chance 0.1 1 RUNNING SUCCESS")),
              HasSubstr("error: chance is not a kind of line; did you mean 'change'?"));
}

// Lines of `text`, each with its end.
std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line + "\n");
  return lines;
}
std::string Joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

TEST_F(Recorded, WhoseLinesAreMissingDoubledOrSwappedIsRefused) {
  Run();
  const std::vector<std::string> lines = LinesOf(text);
  ASSERT_GT(lines.size(), 20U);
  for (std::size_t at = 1; at + 1 < lines.size(); ++at) {
    std::vector<std::string> missing = lines;
    missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(at));
    EXPECT_THAT(Refused(Joined(missing)), HasSubstr("lines before it are missing")) << lines[at];
    std::vector<std::string> doubled = lines;
    doubled.insert(doubled.begin() + static_cast<std::ptrdiff_t>(at), lines[at]);
    EXPECT_THAT(Refused(Joined(doubled)), HasSubstr("lines before it are missing")) << lines[at];
    std::vector<std::string> swapped = lines;
    std::swap(swapped[at], swapped[at + 1]);
    EXPECT_THAT(Refused(Joined(swapped)), HasSubstr("lines before it are missing")) << lines[at];
  }
}

TEST_F(Recorded, BeginsAnotherChainWhereLinesWereLost) {
  TickOnce();
  const std::size_t before = text.size();
  TickOnce();
  text.resize(before);  // never written
  recorder->Lost(3);
  recorder->BeginAgain(kWallUs);
  TickOnce();
  EXPECT_EQ(Read().trees.size(), 2U);
}

TEST_F(Recorded, OfAnEarlierVersionIsReadWithoutAChain) {
  Run();
  std::string old;
  for (std::string line : LinesOf(text)) {
    line.resize(line.size() - 11);
    if (old.empty()) line.replace(line.find(" 2 "), 3, " 1 ");
    RecordingChain none;
    EndRecordingLine(line, none);
    old += line;
  }
  EXPECT_EQ(Refused(old), "");
}

TEST_F(Recorded, ValuesAreCutAtTheEndOfACharacter) {
  ASSERT_TRUE(tree->board().Set("long_text", "x" + std::string(400, 'y')));
  std::string wide;
  for (int i = 0; i < 300; ++i) wide += "ü";
  ASSERT_TRUE(tree->board().Set("wide", "x" + wide));
  TickOnce();
  const Recording recording = Read();
  std::map<std::string, std::string> values;
  for (const RecordedEvent& event : recording.trees.front().events) values[event.key] = event.text;
  EXPECT_EQ(values["long_text"].size(), 403U);
  EXPECT_EQ(values["wide"], "'x" + wide.substr(0, 498) + "…");
}

TEST_F(Recorded, BecomesALogOfBehaviorTreeCpp) {
  Run();
  const Recording recording = Read();
  const Result<std::string> log = WriteBtlog(recording.trees.front());
  ASSERT_TRUE(log);
  const std::string& bytes = log.value();
  const auto number = [&](std::size_t at, int size) {
    std::uint64_t value = 0;
    for (int i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 19), std::string("BTCPP4-FileLogger2\x01"));
  const std::uint64_t xml = number(19, 4);
  EXPECT_EQ(bytes.substr(23, xml), recording.trees.front().xml);
  EXPECT_EQ(number(23 + xml, 8), kWallUs);
  std::vector<std::array<std::uint64_t, 3>> made;
  for (std::size_t at = 31 + xml; at < bytes.size(); at += 9) {
    made.push_back({number(at, 6), number(at + 6, 2), number(at + 8, 1)});
  }
  ASSERT_GT(made.size(), 6U);
  using Made = std::array<std::uint64_t, 3>;
  EXPECT_THAT((std::vector<Made>(made.begin(), made.begin() + 4)),
              ElementsAre(Made{0, 2, 1}, Made{0, 1, 1}, Made{100'000, 2, 2}, Made{100'000, 3, 2}));
  EXPECT_EQ(bytes.size(), 31 + xml + 9 * made.size());
}

// A damaged recording is refused with its place, or is one that can be played to its end.
TEST_F(Recorded, AThousandMutationsAreRefusedWithThePlaceOrPlayed) {
  Run();
  std::mt19937 random(20260301);
  const auto any = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  int refused = 0;
  for (int i = 0; i < 1000; ++i) {
    std::string mutated = text;
    for (std::size_t edits = 1 + any(4); edits > 0 && !mutated.empty(); --edits) {
      const std::size_t at = any(mutated.size());
      const std::size_t length = std::min(mutated.size() - at, 1 + any(80));
      switch (any(4)) {
        case 0:
          mutated[at] = static_cast<char>(any(256));
          break;
        case 1:
          mutated.erase(at, length);
          break;
        case 2:
          mutated.insert(at, mutated.substr(any(mutated.size()), length));
          break;
        default:
          mutated.resize(at);
      }
    }
    // Half of them with right checksums, so that what is behind those is reached, too.
    if (i % 2 == 0) {
      std::string fixed;
      std::istringstream lines(mutated);
      RecordingChain chain;
      for (std::string line; std::getline(lines, line);) {
        line.resize(line.size() - std::min<std::size_t>(line.size(), 10));
        EndRecordingLine(line, chain);
        fixed += line;
      }
      mutated = fixed;
    }
    const Result<Recording> read = ReadRecording(mutated, "p.tree");
    if (!read) {
      ++refused;
      EXPECT_THAT(read.error().message, ::testing::MatchesRegex("p.tree:[0-9]+:[0-9]+: error: .+"));
      continue;
    }
    for (const RecordedTree& each : read.value().trees) {
      Playback playback(each);
      while (playback.Step()) {
      }
      EXPECT_TRUE(WriteBtlog(each));
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_LT(refused, 1000) << "some are only shorter";
}

}  // namespace musher::tree::recording_test
