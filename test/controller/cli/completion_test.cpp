// What completion offers, by the program and through the shells' scripts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "musher/controller/cli/commands/completion_scripts.hpp"
#include "musher/test/controller/cli/program.hpp"
#include "musher/test/controller/cli/robot.hpp"
#include "musher/test/support/paths.hpp"
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
  FILE* pipe = popen((program + " " + (folder / "script") + " 2>&1").c_str(), "r");
  std::string text;
  std::array<char, 4096> part{};
  while (std::fgets(part.data(), part.size(), pipe) != nullptr) text += part.data();
  pclose(pipe);
  return text;
}

// What bash offers after these words, the last of them unfinished.
std::string BashOffers(const std::string& words) {
  const TempFolder folder;
  return Shell("bash", folder,
               std::string(kBashCompletion) + "\ncd " + folder.path() + "\nPATH=" + BinDir() +
                   ":$PATH\ntouch robot.toml 'my robot.toml' other.txt t.xml\nCOMP_WORDS=(" +
                   words +
                   ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_musher musher\n"
                   "printf '%s|' \"${COMPREPLY[@]}\"\n");
}

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
  EXPECT_THAT(Offered({"history", "--limit", ""}), IsEmpty());
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

TEST(CompletionScripts, ArePrintedByTheCommand) {
  EXPECT_EQ(RunProgram({"completion", "bash"}).out, kBashCompletion);
  EXPECT_EQ(RunProgram({"completion", "zsh"}).out, kZshCompletion);
  EXPECT_EQ(RunProgram({"completion", "fish"}).out, kFishCompletion);
  EXPECT_EQ(RunProgram({"completion", "tcsh"}).exit, 2);
}

TEST(CompletionScripts, CompleteInBash) {
  EXPECT_EQ(BashOffers("musher st"), "status |");
  EXPECT_EQ(BashOffers("musher --namespace of_no_machine set Pro"), "Protected |");
  EXPECT_EQ(BashOffers("musher check ''"), R"(my\ robot.toml |robot.toml |)");
  EXPECT_EQ(BashOffers("musher tree show ''"), "t.xml |");
  EXPECT_EQ(BashOffers("musher history --lim"), "--limit |");
  EXPECT_EQ(BashOffers("musher keys a"), "add |");
  EXPECT_EQ(BashOffers("musher status --transport l"), "local |lan |");
  EXPECT_EQ(BashOffers("musher status --transport = l"), "local |lan |");
  EXPECT_EQ(BashOffers("musher status --transport ="), "local |lan |");
}

TEST(CompletionScripts, CompleteInFish) {
  if (std::system("command -v fish >/dev/null") != 0) GTEST_SKIP() << "there is no fish here";
  const TempFolder folder;
  EXPECT_EQ(Shell("fish", folder,
                  "set PATH " + BinDir() + " $PATH\n" + kFishCompletion +
                      "\ncomplete -C 'musher stat'\n"),
            "status\tShow the machine and its actuators\n");
}

TEST(CompletionScripts, AreCorrectForZsh) {
  if (std::system("command -v zsh >/dev/null") != 0) GTEST_SKIP() << "there is no zsh here";
  const TempFolder folder;
  EXPECT_EQ(Shell("zsh -n", folder, kZshCompletion), "");
}

TEST(CompletionScripts, CompleteInZsh) {
  if (std::system("command -v zsh >/dev/null") != 0) GTEST_SKIP() << "there is no zsh here";
  const TempFolder folder;
  // zsh completes at a prompt only: its functions that show what is offered print it here.
  const std::string prompt = "PATH=" + BinDir() +
                             ":$PATH\ncompdef() { }\n_describe() { print -l -- ${(P)2} }\n" +
                             kZshCompletion;
  EXPECT_EQ(Shell("zsh -f", folder, prompt + "\nwords=(musher stat) CURRENT=2\n_musher\n"),
            "status:Show the machine and its actuators\n");
  EXPECT_EQ(
      Shell("zsh -f", folder,
            prompt + "\n_files() { print files $@ }\nwords=(musher check '') CURRENT=3\n_musher\n"),
      "files -g *.toml\n");
}

}  // namespace musher::cli::completion_test
