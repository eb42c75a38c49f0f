#pragma once
// Trees for tests: a tree from a text, and nodes that log what is called.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"

namespace musher::tree {

inline std::string Texts(const std::vector<Diagnostic>& diagnostics) {
  std::string text;
  for (const Diagnostic& each : diagnostics) text += FormatDiagnostic(each) + "\n";
  return text;
}

// A whole document around the content of one tree.
inline std::string Main(const std::string& content) {
  return "<root BTCPP_format=\"4\">\n<BehaviorTree ID=\"Main\">\n" + content +
         "\n</BehaviorTree>\n</root>\n";
}

// The diagnostics of reading and building, a line each.
inline std::string Findings(const std::string& xml, const Factory& factory = {}) {
  const Reading reading = ReadTree(xml, "t.xml");
  if (!reading.ok()) return Texts(reading.diagnostics);
  return Texts(reading.diagnostics) + Texts(Build(reading.document, factory).diagnostics);
}

inline std::unique_ptr<Tree> MakeTree(const std::string& xml, const Factory& factory = {}) {
  const Reading reading = ReadTree(xml, "t.xml");
  EXPECT_TRUE(reading.ok()) << Texts(reading.diagnostics);
  Built built = Build(reading.document, factory);
  EXPECT_NE(built.tree, nullptr) << Texts(built.diagnostics);
  return std::move(built.tree);
}

inline Time At(std::int64_t ms) {
  return Time(Milliseconds(ms));
}

// The results of a tick, a letter each: S, F, R, - (skipped), ! (failed).
inline char Letter(const Result<Status>& result) {
  if (!result) return '!';
  constexpr std::string_view kLetters = "IRSF-";
  return kLetters[static_cast<std::size_t>(result.value())];
}
// Ticks at 0 ms, 10 ms, ...
inline std::string Ticks(Tree& tree, int times, int first = 0) {
  std::string letters;
  for (int i = first; i < first + times; ++i) letters += Letter(tree.TickExactlyOnce(At(10 * i)));
  return letters;
}

// <Say name="a" does="RRS"/>: what each tick returns; after the last letter from the beginning.
// Logs "a" for a tick, "a!" for a halt.
class Say : public StatefulAction {
 public:
  Say(Setup& setup, std::string& log)
      : name_(setup.name()), does_(setup.Input<std::string>("does")), log_(log) {}

 private:
  Status OnStart(const Tick&) override { return Do("^"); }
  Status OnRunning(const Tick&) override { return Do(""); }
  void OnHalted(const Tick&) override { log_ += name_ + "! "; }

  Status Do(const std::string& how) {
    const std::string& does = does_.Get();
    const char letter = does[at_++ % does.size()];
    log_ += name_ + how + " ";
    if (letter == '!') throw std::runtime_error("it broke");
    if (letter == 'S') return Status::kSuccess;
    return letter == 'F' ? Status::kFailure : letter == '-' ? Status::kSkipped : Status::kRunning;
  }

  const std::string name_;
  InPort<std::string> does_;
  std::string& log_;
  std::size_t at_ = 0;
};

struct Logged {
  std::string log;
  Factory factory;

  Logged() { EXPECT_TRUE(factory.Add<Say>("Say", log)); }
  std::string Take() { return std::exchange(log, ""); }
};

// An element of Say with further attributes.
inline std::string Leaf(const std::string& name, const std::string& does,
                        const std::string& more = "") {
  return "<Say name=\"" + name + "\" does=\"" + does + "\" " + more + "/>";
}

struct TickedTree : ::testing::Test, Logged {
  // The results of so many ticks, 10 ms apart, then the log.
  std::string Run(const std::string& content, int ticks) {
    tree = MakeTree(Main(content), factory);
    const std::string letters = Ticks(*tree, ticks);
    return letters + " " + Take();
  }
  std::unique_ptr<Tree> tree;
};

}  // namespace musher::tree
