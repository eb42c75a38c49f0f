// The finished searches of a proof in their file.

#include "musher/cli/machine/kept_searches.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::kept_searches_test {

using search::ProvedTask;
using ::testing::HasSubstr;

ProvedTask Finished(const search::ProofTask& task, std::size_t states) {
  ProvedTask one;
  one.task = task;
  one.figures = {1, states, 3 * states, 2, 1.5};
  one.finished = true;
  return one;
}

const search::ProofTask kStart{{}, {}, 0};
const search::ProofTask kUp{State("LowPower"), State("Active"), 1};

TEST(KeptText, IsReadAsItWasWritten) {
  ProvedTask up = Finished(kUp, 5'000'000'000);
  up.rule_coverage = {{7, 6, 5}, {7, 7, 0}};
  up.timed_coverage = {{4, 3}};
  ProvedTask start = Finished(kStart, 12);
  start.rule_coverage.resize(2);
  start.timed_coverage.resize(1);
  const auto read = ReadKept(KeptText("key", {start, up}), "key", {2, 1});
  ASSERT_TRUE(read);
  ASSERT_EQ(read.value().size(), 2U);
  EXPECT_TRUE(read.value()[0].task.IsStart());
  const ProvedTask& second = read.value()[1];
  EXPECT_EQ(second.task, kUp);
  EXPECT_EQ(second.figures.pairs, 1U);
  EXPECT_EQ(second.figures.nodes, 5'000'000'000U);
  EXPECT_EQ(second.figures.transitions, 15'000'000'000U);
  EXPECT_EQ(second.figures.leaves, 2U);
  EXPECT_EQ(second.figures.seconds, 1.5);
  EXPECT_TRUE(second.finished && second.earlier);
  ASSERT_EQ(second.rule_coverage.size(), 2U);
  EXPECT_EQ(second.rule_coverage[0].forbidden, 5U);
  EXPECT_EQ(second.rule_coverage[1].condition, 7U);
  ASSERT_EQ(second.timed_coverage.size(), 1U);
  EXPECT_EQ(second.timed_coverage[0].begun, 4U);
  EXPECT_EQ(second.timed_coverage[0].met, 3U);
}

TEST(KeptText, DoesNotCountWithAChangedOrAMissingByte) {
  const std::string text = KeptText("key", {Finished(kStart, 12), Finished(kUp, 34)});
  ASSERT_TRUE(ReadKept(text, "key", {}));
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    EXPECT_FALSE(ReadKept(changed, "key", {})) << i;
    EXPECT_FALSE(ReadKept(text.substr(0, i), "key", {})) << i;
    EXPECT_FALSE(ReadKept(text.substr(0, i) + text.substr(i + 1), "key", {})) << i;
  }
}

TEST(KeptText, OfAnotherProofDoesNotCount) {
  const std::string text = KeptText("key", {Finished(kUp, 34)});
  EXPECT_THAT(ReadKept(text, "other", {}).error().message,
              HasSubstr("of another config, other rules or another build of Musher"));
  EXPECT_FALSE(ReadKept(text, "key", {1, 0})) << "it has no figures of a rule";
  EXPECT_FALSE(ReadKept(text, "key", {0, 1})) << "nor of one with a time";
  EXPECT_THAT(ReadKept("musher prove 3\n", "key", {}).error().message,
              HasSubstr("those of another version"));
}

class Keeping : public ::testing::Test {
 protected:
  Keeping() {
    setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1);
    config_.hash = "0123456789abcdef";
  }
  ~Keeping() override { unsetenv("XDG_CACHE_HOME"); }

  KeptSearches Opened() const {
    auto kept = KeptSearches::Open(config_, proof_);
    EXPECT_TRUE(kept);
    return std::move(kept).value();
  }

  TempFolder folder_;
  MachineConfig config_;
  search::ProofOptions proof_;
};

TEST_F(Keeping, HasThoseOfAllRuns) {
  EXPECT_TRUE(Opened().earlier().empty());
  ASSERT_TRUE(Opened().Keep({Finished(kStart, 12)}));
  ASSERT_TRUE(Opened().Keep({Finished(kUp, 34)})) << "of a run without --resume";
  EXPECT_EQ(Opened().earlier().size(), 2U);
  ASSERT_TRUE(Opened().Keep({Finished(kUp, 34)}));
  EXPECT_EQ(Opened().earlier().size(), 2U);
  EXPECT_EQ(EntriesOf(folder_ / "musher/prove").size(), 1U) << "no draft is left";
}

TEST_F(Keeping, EndsWithTheProofThatHasUsedAll) {
  ASSERT_TRUE(Opened().Keep({Finished(kStart, 12), Finished(kUp, 34)}));
  Opened().Remove({Finished(kStart, 12)});
  EXPECT_EQ(Opened().earlier().size(), 2U) << "one is of more faults";
  Opened().Remove({Finished(kStart, 12), Finished(kUp, 34)});
  EXPECT_TRUE(Opened().earlier().empty());
}

TEST_F(Keeping, NamesTheFileThatIsDamaged) {
  KeptSearches kept = Opened();
  ASSERT_TRUE(kept.Keep({Finished(kUp, 34)}));
  EXPECT_EQ(Opened().damage(), "");
  ASSERT_TRUE(WriteFile(kept.file(), ""));
  EXPECT_THAT(Opened().damage(), HasSubstr("no finished searches"));
  EXPECT_TRUE(Opened().earlier().empty());
}

TEST_F(Keeping, LosesNothingThatAnotherProofHasWrittenMeanwhile) {
  KeptSearches first = Opened();
  KeptSearches second = Opened();
  ASSERT_TRUE(first.Keep({Finished(kStart, 12)}));
  ASSERT_TRUE(second.Keep({Finished(kUp, 34)}));
  EXPECT_EQ(Opened().earlier().size(), 2U);
  first.Remove({Finished(kStart, 12)});
  EXPECT_EQ(Opened().earlier().size(), 2U) << "the second one has announced its own as kept";
}

TEST_F(Keeping, IsRefusedInAFolderThatAnotherUserCanWriteTo) {
  KeptSearches kept = Opened();
  ASSERT_TRUE(kept.Keep({Finished(kUp, 34)}));
  for (const char* name : {"", "musher", "musher/prove"}) {
    const std::string folder = folder_ / name;
    ASSERT_EQ(chmod(folder.c_str(), 0777), 0);
    const auto opened = KeptSearches::Open(config_, proof_);
    ASSERT_FALSE(opened) << folder;
    EXPECT_THAT(opened.error().message, HasSubstr("another user can write to "));
    EXPECT_THAT(opened.error().message, HasSubstr("a folder of your own in XDG_CACHE_HOME"));
    EXPECT_FALSE(kept.Keep({Finished(kStart, 12)})) << folder;
    ASSERT_EQ(chmod(folder.c_str(), 0700), 0);
  }
  EXPECT_EQ(Opened().earlier().size(), 1U);
}

// As by sudo, which may leave HOME as it is.
TEST_F(Keeping, OfRootMakesNoFolderInTheHomeOfAUser) {
  if (geteuid() != 0) GTEST_SKIP() << "only root gives a folder away";
  const std::string home = folder_ / "home";
  std::filesystem::create_directory(home);
  setenv("XDG_CACHE_HOME", (home + "/.cache").c_str(), 1);
  KeptSearches kept = Opened();
  ASSERT_EQ(chown(home.c_str(), 12345, 12345), 0);
  EXPECT_FALSE(KeptSearches::Open(config_, proof_));
  EXPECT_FALSE(kept.Keep({Finished(kUp, 34)}));
  EXPECT_TRUE(EntriesOf(std::filesystem::path(home)).empty());
}

TEST_F(Keeping, ReadsNoLinkAndDoesNotWaitForAPipe) {
  KeptSearches kept = Opened();
  ASSERT_TRUE(kept.Keep({Finished(kUp, 34)}));
  const std::string moved = folder_ / "moved";
  std::filesystem::rename(kept.file(), moved);
  std::filesystem::create_symlink(moved, kept.file());
  EXPECT_EQ(Opened().damage(), "it is no regular file");
  EXPECT_TRUE(Opened().earlier().empty());
  std::filesystem::remove(kept.file());
  ASSERT_EQ(mkfifo(kept.file().c_str(), 0600), 0);
  EXPECT_EQ(Opened().damage(), "it is no regular file");
  ASSERT_TRUE(kept.Keep({Finished(kUp, 34)})) << "which replaces it";
  EXPECT_EQ(Opened().earlier().size(), 1U);
}

TEST_F(Keeping, HasAFileForEachConfigItsRulesAndFaults) {
  const std::string first = ProofKey(config_, proof_).value();
  EXPECT_EQ(ProofKey(config_, proof_).value(), first);
  proof_.other_machine = true;
  EXPECT_NE(ProofKey(config_, proof_).value(), first);
  proof_.other_machine = false;
  StableRule rule;
  rule.text = "never a Active";
  proof_.stable_rules = {rule};
  EXPECT_NE(ProofKey(config_, proof_).value(), first);
  proof_.stable_rules.clear();
  config_.hash.back() = '0';
  EXPECT_NE(ProofKey(config_, proof_).value(), first);
}

}  // namespace musher::cli::kept_searches_test
