#include "musher/test/house/text_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "musher/test/house/build_rules.hpp"

namespace musher::house::text_rules_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

SourceFile Cpp(const std::string& text) {
  return {"a.cpp", text};
}

TEST(TextRules, FindClocksThreadsSocketsAndTheEnvironment) {
  for (const char* text :
       {"auto t = std::chrono::steady_clock::now();", "std::thread t;", "#include <mutex>",
        "int fd = socket(AF_UNIX, 0, 0);", "auto* home = std::getenv(\"HOME\");"}) {
    EXPECT_THAT(Impurities(Cpp(text)), SizeIs(1)) << text;
  }
}

TEST(TextRules, FindASentenceThatRefersBackTwice) {
  EXPECT_THAT(ChainedReferences(Cpp("// The place of the writer; of a new one that of a\n"
                                    "// lost one, or the one that is silent.\n")),
              ElementsAre("a.cpp:1: refers back twice: of a new one that of a lost one, or the one "
                          "that is silent"));
  EXPECT_THAT(ChainedReferences(Cpp("// One that runs.\nint a;  // that of the other\n")),
              IsEmpty());
  EXPECT_THAT(ChainedReferences(Cpp("// That of a. Those of b: one that is c.\n")), IsEmpty());
}

TEST(TextRules, FindCommentsWithoutASubject) {
  EXPECT_THAT(UnnamedSubjects(Cpp("  // Of a unit, by its name.\nstd::string PathOf();\n")),
              ElementsAre("a.cpp:1: names no subject: Of a unit, by its name."));
  EXPECT_THAT(UnnamedSubjects(Cpp("// Those that wait.\n\n// One that runs.\n// Who asks.\n")),
              SizeIs(2));
  EXPECT_THAT(
      UnnamedSubjects(Cpp("// The paths of a unit, in order:\n// Of one start the first.\n"
                          "int a;  // of a unit\n// One of several publishers is silent.\n")),
      IsEmpty());
}

TEST(TextRules, LetCommentsSpeakOfClocks) {
  EXPECT_THAT(Impurities(Cpp("// not ::now()\nint a;  // std::thread\n/* #include\n<mutex> */")),
              IsEmpty());
}

TEST(TextRules, FindSleeps) {
  EXPECT_THAT(Sleeps(Cpp("\nstd::this_thread::sleep_for(d);")),
              ElementsAre("a.cpp:2: sleep_for waits for a time instead of an event"));
  EXPECT_THAT(Sleeps(Cpp("  usleep(1000);")), SizeIs(1));
  EXPECT_THAT(Sleeps(Cpp("run({\"sleep\", \"5\"});")), IsEmpty());
}

TEST(TextRules, FindCallsThatOutliveTheirController) {
  EXPECT_THAT(UnwatchedCalls(Cpp("link->Call<msg::RestartActuator>(\"restart_actuator\", {});")),
              SizeIs(1));
  EXPECT_THAT(UnwatchedCalls(Cpp("transport::MakeClient<msg::SetState>(node, name);")), SizeIs(1));
  EXPECT_THAT(UnwatchedCalls(Cpp("reply = self._call(\"restart_actuator\", RestartActuator)")),
              SizeIs(1));
  EXPECT_THAT(UnwatchedCalls(Cpp("link->Call<msg::GetStatus>(\"get_status\", {});")), IsEmpty());
  EXPECT_THAT(UnwatchedCalls(Cpp("LeaderCall<msg::SetState>::Make(node);")), IsEmpty());
}

TEST(TextRules, FindIteratorsThatThrow) {
  EXPECT_THAT(ThrowingIterators(Cpp("std::string text{std::istreambuf_iterator<char>(in), {}};")),
              SizeIs(1));
  EXPECT_THAT(ThrowingIterators(Cpp("for (auto& e : fs::directory_iterator(a, error)) {")),
              SizeIs(1));
  EXPECT_THAT(ThrowingIterators(Cpp("fs::directory_iterator entry(folder, error);")), IsEmpty());
}

TEST(TextRules, FindMethodsThatCouldDoAnything) {
  EXPECT_THAT(VagueMethods(Cpp("  void Hang(ActuatorIndex i, bool silent);")), SizeIs(1));
  EXPECT_THAT(VagueMethods(Cpp("Result<std::vector<Segment>> Mission::Rest(Time now) const {")),
              SizeIs(1));
  EXPECT_THAT(VagueMethods(Cpp("  virtual void Tend() = 0;")), SizeIs(1));
  EXPECT_THAT(VagueMethods(Cpp("  const Room& Room() const;")), SizeIs(1));
  EXPECT_THAT(VagueMethods(Cpp("  Settle();\n  return Settle();\n  if (on) Say(text);")),
              IsEmpty());
  EXPECT_THAT(VagueMethods(Cpp("  void MarkHung();\n  bool HasRest();\n  // to Hang()")),
              IsEmpty());
  EXPECT_THAT(VagueMethods(Cpp("  Say(tree::Setup& setup, Robot& robot)")), IsEmpty());
}

TEST(TextRules, FindTypesThatAreNamedByWhatGoesOn) {
  EXPECT_THAT(GerundTypes(Cpp("struct Stopping {\n  int a;\n};")),
              ElementsAre("a.cpp:1: Stopping is what goes on; name the thing: Decision, Builder, "
                          "PendingCall"));
  EXPECT_THAT(GerundTypes(Cpp("  class SlowDeciding final : Base {")), SizeIs(1));
  EXPECT_THAT(GerundTypes(Cpp("template <class T>\nenum class Ending : int { kA };")), SizeIs(1));
  EXPECT_THAT(GerundTypes(Cpp("using Waiting = std::map<int, Call>;")), SizeIs(1));
  EXPECT_THAT(GerundTypes(Cpp("struct PendingCall {\nclass JournalRecording;\nclass IsString {")),
              IsEmpty());
  EXPECT_THAT(GerundTypes(Cpp("struct [[nodiscard]] Ending {\nclass alignas(8) Ending {")),
              SizeIs(2));
  EXPECT_THAT(GerundTypes(Cpp("class PowerSaving {\nclass Binding : StepPart {")), IsEmpty());
  EXPECT_THAT(GerundTypes(Cpp("class TimeSaving {\nclass LateBinding : StepPart {")), SizeIs(2))
      << "the word is excepted in one name alone";
  EXPECT_THAT(GerundTypes(Cpp("class Waiting : public fsm::State {")), IsEmpty());
  EXPECT_THAT(GerundTypes(Cpp("using testing::Pending;\nint Stopping();\n// class Ending")),
              IsEmpty());
}

TEST(TextRules, FindLeftovers) {
  EXPECT_THAT(Leftovers(Cpp(std::string("// TO") + "DO: later")), SizeIs(1));
  EXPECT_THAT(Leftovers(Cpp("int to_do = 1;")), IsEmpty());
}

TEST(TextRules, FindWordsThatTheFieldDoesNotSearchFor) {
  const auto words = ReadPrivateWords("# a comment: no word\nzebra: horse\n");
  EXPECT_THAT(PrivateWords(Cpp("// The zebra runs."), words), SizeIs(1));
  EXPECT_THAT(PrivateWords(Cpp("int zebra_count = 1;"), words), SizeIs(1));
  EXPECT_THAT(PrivateWords(Cpp("void FeedTheZebraNow();"), words), SizeIs(1));
  EXPECT_THAT(PrivateWords({"docs/guide.md", "Zebra"}, words), SizeIs(1));
  EXPECT_THAT(PrivateWords(Cpp("// Zebras have no zebrafish."), words), IsEmpty());
  EXPECT_THAT(PrivateWords({"docs/zebra_guide.md", ""}, words), SizeIs(1));
}

TEST(TextRules, FindPhrasesThatTheFieldDoesNotSearchFor) {
  const auto words = ReadPrivateWords("fly off: take off\n");
  for (const char* text : {"// It may fly off.", "kFlyOffSignal", "fly_off", "// Fly\toff"}) {
    EXPECT_THAT(PrivateWords(Cpp(text), words), SizeIs(1)) << text;
  }
  EXPECT_THAT(PrivateWords(Cpp("// It may fly; its light is off."), words), IsEmpty());
}

TEST(TextRules, KeepTheNamesOfFileFormats) {
  const auto words = ReadPrivateWords("zebra: horse\n\"zebra\": a name that stays\n");
  EXPECT_THAT(PrivateWords(Cpp("Field{\"zebra\", &Horse::name}"), words), IsEmpty());
  EXPECT_THAT(PrivateWords(Cpp("Field{\"zebra\", &zebra}"), words), SizeIs(1));
}

TEST(TextRules, FindHeadersWithoutPragmaOnce) {
  EXPECT_THAT(MissingPragmaOnce({"a.hpp", "#pragma once\n"}), IsEmpty());
  EXPECT_THAT(MissingPragmaOnce({"a.hpp", "// #pragma once\n"}), SizeIs(1));
}

TEST(TextRules, FindScriptsThatCannotBeRun) {
  EXPECT_THAT(NotExecutable({"scripts/a", "#!/bin/sh\n", false}), SizeIs(1));
  EXPECT_THAT(NotExecutable({"scripts/a", "#!/bin/sh\n", true}), IsEmpty());
  EXPECT_THAT(NotExecutable({"README.md", "text", false}), IsEmpty());
}

TEST(TextRules, KeepStringsAndLineNumbersWhenCommentsGo) {
  EXPECT_EQ(WithoutComments("a /* b\n c */ d // e\nf"), "a \n d \nf");
  EXPECT_EQ(WithoutComments("url = \"http://x\"; // y"), "url = \"http://x\"; ");
  EXPECT_EQ(WithoutComments("n = 1'000; // y"), "n = 1'000; ");
}

TEST(BuildRules, FindFilesThatNoTargetBuilds) {
  const std::vector<SourceFile> tree = {
      {"a/CMakeLists.txt", "add_library(a one.cpp b/two.cpp c/*.cpp)  # three.cpp\n"},
      {"a/b/two.cpp", ""},
      {"a/c/d/four.cpp", ""},
      {"a/c/two.cpp", ""},
      {"a/one.cpp", ""},
      {"a/three.cpp", ""},
      {"test/CMakeLists.txt", "musher_test(t SOURCES t_test.cpp ../a/one.cpp)"},
      {"test/t_test.cpp", ""}};
  EXPECT_THAT(DeadFiles(tree), ElementsAre("a/c/d/four.cpp: is in no CMake target",
                                           "a/three.cpp: is in no CMake target"));
}

}  // namespace musher::house::text_rules_test
