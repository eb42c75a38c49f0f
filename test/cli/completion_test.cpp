// What completion offers, by the program and through the shells' scripts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "musher/cli/commands/completion_scripts.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::completion_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;

// What is offered for the last of the words, without its meaning.
std::vector<std::string> Offered(std::vector<std::string> words) {
  words.insert(words.begin(), "complete");
  const Ran ran = RunProgram(words);
  EXPECT_EQ(ran.exit, 0);
  EXPECT_EQ(ran.err, "");
  std::istringstream lines(ran.out);
  std::vector<std::string> offered;
  for (std::string line; std::getline(lines, line);) {
    offered.push_back(line.substr(0, line.find('\t')));
  }
  return offered;
}

std::string Shell(const std::string& program, const TempFolder& folder, const std::string& script) {
  std::ofstream(folder / "script") << script;
  return testing::RunToEnd({"sh", "-c", program + " " + (folder / "script") + " 2>&1"}).out;
}

// A folder with files, and the shells' scripts in another.
class CompletionScripts : public ::testing::Test {
 protected:
  CompletionScripts() {
    for (const char* file : {"robot.toml", "my robot.toml", "other.txt", "tree.xml"}) {
      const std::ofstream made(files_ / file);
    }
    std::filesystem::create_directory(files_ / "sub");
    std::ofstream(scripts_ / "bash") << kBashCompletion;
    std::ofstream(scripts_ / "zsh") << kZshCompletion;
    std::ofstream(scripts_ / "fish") << kFishCompletion;
  }

  static bool Has(const std::string& shell) {
    return std::system(("command -v " + shell + " >/dev/null").c_str()) == 0;
  }

  // What the prompt of bash or zsh has after each line and the completion key. See at_prompt.
  std::string AtPrompt(const std::string& shell, const std::string& lines) const {
    return OutputOf(SourceDir() + "/test/cli/at_prompt " + shell + " " + (scripts_ / shell), lines);
  }

  // What fish offers, one completion on each line.
  std::string FishOffers(const std::string& line) const {
    return OutputOf(
        "fish --no-config -c 'source " + (scripts_ / "fish") + "; read -z line; complete -C $line'",
        line);
  }

 private:
  std::string OutputOf(const std::string& command, const std::string& input) const {
    std::ofstream(scripts_ / "input") << input;
    const std::string all = "cd " + files_.path() + " && PATH=" + BinDir() + ":$PATH " + command +
                            " < " + (scripts_ / "input") + " 2>&1";
    return testing::RunToEnd({"sh", "-c", all}).out;
  }

  const TempFolder files_;
  const TempFolder scripts_;
};

class Completion : public ::testing::Test {
 protected:
  Completion() { std::ofstream(config_) << kRobotToml << kCapability; }

  static constexpr const char* kCapability = "[capability.walk]\nactuators = [\"legs\"]\n";
  const TempFolder folder_;
  const std::string config_ = folder_ / "robot.toml";
};

TEST_F(Completion, OffersTheCommandsAndWhatEachIsFor) {
  EXPECT_THAT(Offered({""}), IsSupersetOf({"up", "set", "behavior", "keys", "help"}));
  EXPECT_THAT(Offered({"st"}), ElementsAre("status"));
  EXPECT_THAT(Offered({"keys", ""}), ElementsAre("init", "add", "revoke", "list"));
  EXPECT_THAT(Offered({"help", "res"}), ElementsAre("restart"));
  EXPECT_THAT(Offered({"complet"}), ElementsAre("completion")) << "people type no `complete`";
  EXPECT_EQ(RunProgram({"complete", "stat"}).out, "status\tShow the machine and its actuators\n");
}

TEST_F(Completion, OffersEveryOptionThatTheHelpShows) {
  EXPECT_THAT(Offered({"history", "--"}),
              IsSupersetOf({"--since", "--until", "--csv", "--follow", "--why", "--json"}));
  EXPECT_THAT(Offered({"down", "--w"}), ElementsAre("--without-controller"));
  EXPECT_THAT(Offered({"--vers"}), ElementsAre("--version"));
  EXPECT_THAT(Offered({"up", "--res"}), ElementsAre("--restarted")) << "none that is hidden";
  EXPECT_THAT(Offered({"ota", "bundle", "--min"}), ElementsAre("--min-version"));
  EXPECT_THAT(Offered({"set", "--", "--j"}), Not(Contains("--json")));
}

TEST_F(Completion, OffersTheWordsThatAnOptionTakes) {
  EXPECT_THAT(Offered({"status", "--transport", ""}), ElementsAre("local", "lan"));
  EXPECT_THAT(Offered({"keys", "add", "guest", "--role", "ob"}), ElementsAre("observer"));
  EXPECT_THAT(Offered({"graph", "--format=s"}), ElementsAre("--format=svg")) << "as zsh does";
  EXPECT_THAT(Offered({"graph", "--format", "=", "s"}), ElementsAre("svg")) << "as bash does";
  EXPECT_THAT(Offered({"low-power", ""}), ElementsAre("on", "off"));
  EXPECT_THAT(Offered({"history", "--event", "switch_do"}),
              ElementsAre("switch_done", "switch_done_degraded"));
  EXPECT_THAT(Offered({"history", "--lines", ""}), IsEmpty());
}

TEST_F(Completion, OffersTheNamesOfTheConfigOnTheLine) {
  EXPECT_THAT(Offered({"simulate", config_, "--home", ""}),
              ElementsAre("TearDown", "SelfCheck", "Active", "LowPower", "Error"));
  EXPECT_THAT(Offered({"simulate", config_, "--home", "Lo"}), ElementsAre("LowPower"));
  EXPECT_THAT(Offered({"replay", "--config", config_, ""}), ElementsAre(":files"));
}

TEST_F(Completion, LetsTheShellCompleteFiles) {
  EXPECT_THAT(Offered({"check", ""}), ElementsAre(":configs"));
  EXPECT_THAT(Offered({"check", "a.toml", ""}), ElementsAre(":configs"));
  EXPECT_THAT(Offered({"graph", ""}), ElementsAre(":configs", ":trees"));
  EXPECT_THAT(Offered({"tree", "check", "a.xml", ""}), ElementsAre(":trees"));
  EXPECT_THAT(Offered({"tree", "check", "--models", ""}), ElementsAre(":trees"));
  EXPECT_THAT(Offered({"ota", "install", ""}), ElementsAre(":folders"));
  EXPECT_THAT(Offered({"history", "--journal", ""}), ElementsAre(":files"));
  EXPECT_THAT(Offered({"up", "a.toml", ""}), IsEmpty());
}

TEST_F(Completion, WithoutAMachineOffersOnlyTheBuiltInStatesAndPrintsNothing) {
  const std::vector<std::string> nowhere = {"--namespace", "of_no_machine"};
  const auto offered = [&](std::vector<std::string> words) {
    words.insert(words.begin(), nowhere.begin(), nowhere.end());
    return Offered(std::move(words));
  };
  EXPECT_THAT(offered({"set", ""}), IsSupersetOf({"Active", "Protected", "OTA"}));
  EXPECT_THAT(offered({"set", "Set"}), IsEmpty()) << "SetUp cannot be commanded";
  EXPECT_THAT(offered({"set", "Active", ""}), IsEmpty());
  EXPECT_THAT(offered({"capabilities", ""}), IsEmpty());
}

TEST_F(CompletionScripts, ArePrintedByTheCommand) {
  EXPECT_EQ(RunProgram({"completion", "bash"}).out, kBashCompletion);
  EXPECT_EQ(RunProgram({"completion", "zsh"}).out, kZshCompletion);
  EXPECT_EQ(RunProgram({"completion", "fish"}).out, kFishCompletion);
  EXPECT_EQ(RunProgram({"completion", "tcsh"}).exit, 2);
}

const std::string kTyped = R"(musher stat
)" + BinDir() + R"(/musher se
musher --namespace of_no_machine set Pro
musher keys a
musher history --lin
musher status --transport=lo
musher check ro
musher check my
musher check my\ ro
musher check 'my
musher check "my
musher tree show tr
musher history --journal oth
musher replay --config=ro
musher ota install s
musher low-power *
musher check *
)";

const std::string kCompleted = R"(musher status 
)" + BinDir() + R"(/musher set 
musher --namespace of_no_machine set Protected 
musher keys add 
musher history --lines 
musher status --transport=local 
musher check robot.toml 
musher check my\ robot.toml 
musher check my\ robot.toml 
musher check 'my robot.toml' 
musher check "my robot.toml" 
musher tree show tree.xml 
musher history --journal other.txt 
musher replay --config=robot.toml 
musher ota install sub/
)";

TEST_F(CompletionScripts, CompleteAtThePromptOfBash) {
  if (!Has("zsh")) GTEST_SKIP() << "zsh, whose script types at the prompt, is not installed";
  EXPECT_EQ(AtPrompt("bash", kTyped), kCompleted +
                                          "musher low-power off  on  \n"
                                          "musher check my\\ robot.toml robot.toml sub \n");
  EXPECT_EQ(AtPrompt("bash", "musher check oth\n"), "musher check oth\n");
}

TEST_F(CompletionScripts, CompleteAtThePromptOfZsh) {
  if (!Has("zsh")) GTEST_SKIP() << "zsh is not installed";
  EXPECT_EQ(AtPrompt("zsh", kTyped), kCompleted +
                                         "musher low-power off on  \n"
                                         "musher check my\\ robot.toml robot.toml sub/\n");
}

TEST_F(CompletionScripts, CompleteInFish) {
  if (!Has("fish")) GTEST_SKIP() << "fish is not installed";
  EXPECT_EQ(FishOffers("musher stat"), "status\tShow the machine and its actuators\n");
  EXPECT_EQ(FishOffers(BinDir() + "/musher stat"), "status\tShow the machine and its actuators\n");
  EXPECT_EQ(FishOffers("musher --namespace of_no_machine set Pro"), "Protected\n");
  EXPECT_EQ(FishOffers("musher status --transport=l"), "--transport=lan\n--transport=local\n");
  EXPECT_EQ(FishOffers("musher check "), "my robot.toml\nrobot.toml\nsub/\n");
  EXPECT_EQ(FishOffers("musher check 'my"), "my robot.toml\n");
  EXPECT_EQ(FishOffers("musher tree show "), "sub/\ntree.xml\n");
  EXPECT_EQ(FishOffers("musher history --journal oth"), "other.txt\n");
  EXPECT_EQ(FishOffers("musher replay --config=ro"), "--config=robot.toml\n");
  EXPECT_EQ(FishOffers("musher ota install "), "sub/\n");
}

}  // namespace musher::cli::completion_test
