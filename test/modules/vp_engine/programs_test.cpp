// The programs on disk, their nodes with a fake robot, and the config.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "musher/base/files.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/modules/vp_engine/nodes.hpp"
#include "musher/modules/vp_engine/programs.hpp"
#include "musher/modules/vp_engine/vp_config.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::vp_engine::programs_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Shown(Programs& programs) {
  std::string text;
  for (const Program& each : programs.List()) {
    text += each.name + " " + std::string(Name(each.state)) +
            (each.message.empty() ? "" : ": " + each.message) + "\n";
  }
  return text;
}

class ProgramsTest : public ::testing::Test {
 protected:
  ProgramsTest() {
    std::filesystem::create_directories(folder_ / "examples");
    std::ofstream(folder_ / "examples/greet.xml") << "hello";
    EXPECT_TRUE(programs_.Open());
  }

  // As the actuator does it, which checks in a thread.
  Result<> Add(const std::string& name, const std::string& text) {
    const Result<std::string> path = programs_.BeginAdd(name, text);
    if (!path) return path.error();
    const std::string errors = Check(name, text);
    return programs_.EndAdd(name, text, errors,
                            errors.empty() ? Programs::Store(path.value(), text) : Ok());
  }
  static std::string Check(const std::string& name, const std::string& text) {
    return text == "wrong" ? name + ": first\n" + name + ": second" : "";
  }

  const TempFolder folder_;
  Programs programs_{folder_ / "own", folder_ / "examples", Check};
};

TEST_F(ProgramsTest, AreCheckedBeforeTheyAreStoredWithAllErrorsInTheMessage) {
  const auto wrong = Add("dance", "wrong");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message, "dance: first\ndance: second");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "own/dance.xml"));
  ASSERT_TRUE(Add("dance", "right"));
  EXPECT_FALSE(Add("dance", "wrong"));
  EXPECT_EQ(programs_.Text("dance").value(), "right");
  EXPECT_EQ(Shown(programs_), "dance ready\ngreet ready\n");
}

TEST_F(ProgramsTest, ThatAreBeingAddedAreNotAddedAgainRunOrRemovedMeanwhile) {
  ASSERT_TRUE(Add("dance", "right"));
  ASSERT_TRUE(programs_.BeginAdd("dance", "another"));
  EXPECT_THAT(programs_.BeginAdd("dance", "third").error().message, HasSubstr("is being added"));
  EXPECT_FALSE(programs_.Runnable("dance"));
  EXPECT_FALSE(programs_.Remove("dance"));
  ASSERT_TRUE(programs_.EndAdd("dance", "another", "", Ok()));
  EXPECT_TRUE(programs_.Runnable("dance"));
}

TEST_F(ProgramsTest, HaveNamesThatCanNotLeaveTheirFolder) {
  for (const std::string name : {"", "../greet", "a/b", ".hidden", "-x", "a b", "é"}) {
    EXPECT_FALSE(Add(name, "right")) << name;
    EXPECT_FALSE(programs_.Text(name)) << name;
    EXPECT_FALSE(programs_.Remove(name)) << name;
  }
  EXPECT_FALSE(IsProgramName(std::string(65, 'a')));
  EXPECT_TRUE(IsProgramName("walk-2_fast"));
  EXPECT_THAT(programs_.Text("gret").error().message, HasSubstr("did you mean 'greet'?"));
}

TEST_F(ProgramsTest, KeepTheStateOfEach) {
  ASSERT_TRUE(Add("dance", "right"));
  programs_.Started("dance");
  EXPECT_FALSE(Add("dance", "another"));
  EXPECT_FALSE(programs_.Remove("dance"));
  EXPECT_EQ(Shown(programs_), "dance running\ngreet ready\n");
  programs_.Ended(ProgramState::kFailed, "no floor");
  EXPECT_EQ(Shown(programs_), "dance failed: no floor\ngreet ready\n");
  ASSERT_TRUE(Add("dance", "another"));
  EXPECT_EQ(Shown(programs_), "dance ready\ngreet ready\n");
}

TEST_F(ProgramsTest, OfThePersonHideExamplesWhichAreNotDeleted) {
  EXPECT_THAT(programs_.Remove("greet").error().message, HasSubstr("is an example"));
  ASSERT_TRUE(Add("greet", "mine"));
  EXPECT_EQ(programs_.Text("greet").value(), "mine");
  ASSERT_TRUE(programs_.Remove("greet"));
  EXPECT_EQ(programs_.Text("greet").value(), "hello");
}

TEST_F(ProgramsTest, ThatWereMadeWrongByHandAreInvalidAndDoNotRun) {
  std::ofstream(folder_ / "own/bad.xml") << "wrong";
  EXPECT_EQ(Shown(programs_), "bad invalid: bad: first\nbad: second\ngreet ready\n");
  EXPECT_FALSE(programs_.Runnable("bad"));
  EXPECT_TRUE(programs_.Runnable("greet"));
}

// Ends each call as the test says.
class FakeRobot : public Robot {
 public:
  Call Speak(const std::string& text) override { return Begin("say " + text); }
  Call Move(const MotionOrder& order) override {
    return Begin("move " + std::to_string(order.id) + " for " + std::to_string(order.duration_ms));
  }
  Call Light(const LightOrder& order) override {
    return Begin("light " + std::to_string(order.target) + (order.on ? " on" : " off"));
  }
  std::optional<Result<>> EndOf(Call) override { return end; }
  void Forget(Call call) override { log.push_back("forget " + std::to_string(call)); }

  std::vector<std::string> log;
  std::optional<Result<>> end;

 private:
  Call Begin(const std::string& what) {
    log.push_back(what);
    return log.size();
  }
};

class ANode : public ::testing::Test {
 protected:
  tree::Tree& Make(const std::string& content) {
    const tree::Reading read = tree::ReadTree(
        "<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\">" + content + "</BehaviorTree></root>",
        "t.xml");
    EXPECT_TRUE(AddNodes(factory_, robot_));
    tree::Built built = tree::Build(read.document, factory_);
    for (const Diagnostic& each : built.diagnostics) ADD_FAILURE() << FormatDiagnostic(each);
    tree_ = std::move(built.tree);
    return *tree_;
  }
  tree::Status At(int ms) {
    const auto ticked = tree_->TickOnce(Time{} + Milliseconds(ms));
    EXPECT_TRUE(ticked) << ticked.error().message;
    return ticked ? ticked.value() : tree::Status::kIdle;
  }

  FakeRobot robot_;
  tree::Factory factory_;
  std::unique_ptr<tree::Tree> tree_;
};

TEST_F(ANode, OfACallRunsUntilTheRobotHasDoneItAndReportsWhyItHasNot) {
  Make("<Say text=\"Hello\" error=\"{error}\"/>");
  EXPECT_EQ(At(0), tree::Status::kRunning);
  robot_.end = Ok();
  EXPECT_EQ(At(20), tree::Status::kSuccess);
  robot_.end = Error{5021, "interrupted"};
  EXPECT_EQ(At(40), tree::Status::kFailure);
  EXPECT_EQ(tree_->board().Get<std::string>("error").value(), "interrupted");
  EXPECT_THAT(robot_.log, ElementsAre("say Hello", "say Hello"));
}

TEST_F(ANode, OfACallForgetsItWhenItIsHalted) {
  Make("<MotionResult motion_id=\"303\" duration_ms=\"500\"/>");
  EXPECT_EQ(At(0), tree::Status::kRunning);
  EXPECT_TRUE(tree_->Halt(Time{}));
  EXPECT_THAT(robot_.log, ElementsAre("move 303 for 500", "forget 1"));
}

TEST_F(ANode, OfALightNamesItsTargetsWhenItIsWrong) {
  Make("<Led target=\"foot\" green=\"255\"/>");
  const auto ticked = tree_->TickOnce(Time{});
  ASSERT_FALSE(ticked);
  EXPECT_THAT(ticked.error().message, HasSubstr("expected head, tail or mini, found 'foot'"));
}

TEST_F(ANode, WaitsSecondsOfTheTreesTime) {
  Make("<WaitSeconds seconds=\"0.1\"/>");
  EXPECT_EQ(At(0), tree::Status::kRunning);
  EXPECT_EQ(At(99), tree::Status::kRunning);
  EXPECT_EQ(At(100), tree::Status::kSuccess);
}

TEST(VpConfig, OfTheProductIsValidAndItsExamplesAreBuilt) {
  const Parsed<VpConfig> read = ReadVpFile(SourceDir() + "/config/vp_engine/vp_engine.toml");
  ASSERT_TRUE(read.config) << FormatDiagnostic(read.diagnostics.front());
  FakeRobot robot;
  tree::Factory factory;
  ASSERT_TRUE(AddNodes(factory, robot));
  int count = 0;
  for (const auto& file : EntriesOf(read.config->examples)) {
    ++count;
    const tree::Reading program = tree::ReadTreeFile(file.string());
    const tree::Built built = tree::Build(program.document, factory);
    for (const Diagnostic& each : built.diagnostics) {
      EXPECT_NE(each.severity, Severity::kError) << FormatDiagnostic(each);
    }
  }
  EXPECT_EQ(count, 2);
}

TEST(VpConfig, ReportsAllErrorsAtOnce) {
  const Parsed<VpConfig> read = ReadVpText(
      "folder = \"\"\nrate_hz = 0\n[services]\nspeech = \"a b\"\nmoton = \"x\"\n", "v.toml");
  EXPECT_FALSE(read.config);
  ASSERT_EQ(read.diagnostics.size(), 4U);
  EXPECT_THAT(FormatDiagnostic(read.diagnostics[3]), HasSubstr("did you mean \"motion\"?"));
}

TEST(VpConfig, RecordsAndLetsGroot2HoldNodesOnRequestOnly) {
  const Parsed<VpConfig> bare = ReadVpText("", "v.toml");
  EXPECT_EQ(bare.config.value().record, "");
  EXPECT_FALSE(bare.config.value().groot2_hooks);
  const Parsed<VpConfig> read =
      ReadVpText("groot2_hooks = true\nrecord = \"v.tree\"\nrecord_mib = 2\n", "v.toml");
  EXPECT_TRUE(read.config.value().groot2_hooks);
  EXPECT_EQ(read.config.value().record, "v.tree");
  EXPECT_EQ(read.config.value().record_mib, 2U);
  EXPECT_FALSE(ReadVpText("record_mib = 0\n", "v.toml").config);
}

}  // namespace musher::vp_engine::programs_test
