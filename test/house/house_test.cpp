// The rules of the house, held against the whole tree.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "musher/test/house/build_rules.hpp"
#include "musher/test/house/doc_rules.hpp"
#include "musher/test/house/field_rules.hpp"
#include "musher/test/house/function_rules.hpp"
#include "musher/test/house/include_rules.hpp"
#include "musher/test/house/interface_rules.hpp"
#include "musher/test/house/message_rules.hpp"
#include "musher/test/house/reference_rules.hpp"
#include "musher/test/house/site_rules.hpp"
#include "musher/test/house/text_rules.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::house::house_test {

using ::testing::IsEmpty;

const std::vector<SourceFile>& Tree() {
  static const std::vector<SourceFile> tree = ReadTree(SourceDir());
  return tree;
}

using Rule = std::function<std::vector<std::string>(const SourceFile&)>;
using Filter = std::function<bool(const SourceFile&)>;

// All violations of `rule`, one on each line; fails when the rule had nothing to check.
std::string ViolationsOf(const Filter& concerned, const Rule& rule) {
  std::string text;
  bool checked = false;
  for (const SourceFile& file : Tree()) {
    if (!concerned(file)) continue;
    checked = true;
    for (const std::string& violation : rule(file)) text += violation + "\n";
  }
  EXPECT_TRUE(checked) << "the rule concerns no file";
  return text;
}

bool IsCpp(const SourceFile& file) {
  return file.IsCpp();
}
bool IsProduct(const SourceFile& file) {
  return file.IsCpp() && !file.In("test/");
}
bool IsHeader(const SourceFile& file) {
  return file.Is(".hpp");
}
bool IsPure(const SourceFile& file) {
  return file.IsCpp() && (file.In("lifecycle/") || file.In("behavior/") || file.In("navigation/"));
}
bool IsDocument(const SourceFile& file) {
  return file.Is(".md");
}
bool IsGuide(const SourceFile& file) {
  return file.path == "README.md" || (file.In("docs/") && file.Is(".md"));
}
// Read by people who are new to the project.
bool IsRead(const SourceFile& file) {
  return IsCpp(file) || IsDocument(file) || file.Is("CMakeLists.txt") || file.In("scripts/") ||
         file.In("cmake/") || file.Is(".py") || file.Is(".idl") || file.Is(".js") ||
         file.Is(".expected") || (file.In("config/") && file.Is(".toml"));
}
bool IsMessage(const SourceFile& file) {
  return file.In("messages/") && file.Is(".idl");
}
bool IsAny(const SourceFile&) {
  return true;
}
// The floor below all others (docs/architecture.md).
constexpr std::array kCore = {"base/",        "lifecycle/",  "messages/",   "wire/",
                              "transport/",   "actuator/",   "controller/", "behavior/",
                              "application/", "simulation/", "search/",     "cyberdog/"};
// Pictures have any bytes.
bool IsText(const SourceFile& file) {
  return file.text.find('\0') == std::string::npos;
}

// The benchmark of an idle process has to let time go by, and a plain C peer has no event to wait
// for.
bool MustNotSleep(const SourceFile& file) {
  return file.IsCpp() && file.In("test/") && !file.In("test/benchmark/") && !file.In("test/house/");
}

// An empty one where there is none.
SourceFile File(const std::string& path) {
  for (const SourceFile& file : Tree()) {
    if (file.path == path) return file;
  }
  ADD_FAILURE() << "there is no " << path;
  return {path, "", false};
}

TEST(House, FoldersIncludeOnlyWhatIsBelowThem) {
  EXPECT_THAT(ViolationsOf(IsCpp, ForbiddenIncludes), IsEmpty());
}

TEST(House, NoFoldersIncludeEachOther) {
  EXPECT_THAT(IncludeCycles(Tree()), IsEmpty());
}

TEST(House, PureFoldersUseNoClockNoThreadNoSocketAndNoEnvironment) {
  EXPECT_THAT(ViolationsOf(IsPure, Impurities), IsEmpty());
}

TEST(House, TestsWaitForEventsAndNeverSleep) {
  EXPECT_THAT(ViolationsOf(MustNotSleep, Sleeps), IsEmpty());
}

TEST(House, NoExceptionWhereAFileVanishesWhileItIsRead) {
  EXPECT_EQ(ViolationsOf(IsProduct, ThrowingIterators), "");
}

TEST(House, AMethodIsNamedForWhatItDoes) {
  EXPECT_EQ(ViolationsOf(IsProduct, VagueMethods), "");
}

TEST(House, ATypeIsNamedForAThing) {
  EXPECT_EQ(ViolationsOf(IsProduct, GerundTypes), "");
}

TEST(House, NoFunctionIsLongerThanAScreen) {
  EXPECT_EQ(ViolationsOf(IsProduct, LongFunctions), "");
}

TEST(House, NoClientOutlivesTheControllerThatItWaitsFor) {
  const Filter client = [](const SourceFile& file) {
    return file.In("python/") || (file.IsCpp() && (file.In("cli/") || file.In("view/")));
  };
  EXPECT_EQ(ViolationsOf(client, UnwatchedCalls), "");
}

TEST(House, NothingIsLeftForLaterInTheCode) {
  EXPECT_THAT(ViolationsOf(IsText, Leftovers), IsEmpty());
}

TEST(House, UsesTheWordsOfTheField) {
  std::map<std::string, std::string> words;
  for (const SourceFile& file : Tree()) {
    if (file.path == "test/house/private_words.txt") words = ReadPrivateWords(file.text);
  }
  ASSERT_FALSE(words.empty());
  const Rule rule = [&](const SourceFile& file) {
    return PrivateWords(IsRead(file) ? file : SourceFile{file.path, ""}, words);
  };
  EXPECT_EQ(ViolationsOf(IsAny, rule), "");
}

TEST(House, NoSentenceOfACommentRefersBackTwice) {
  const Filter cpp = [](const SourceFile& file) { return file.IsCpp(); };
  EXPECT_EQ(ViolationsOf(cpp, ChainedReferences), "");
}

TEST(House, ACommentInTheCoreNamesItsSubject) {
  const Filter core = [](const SourceFile& file) {
    return file.IsCpp() &&
           std::ranges::any_of(kCore, [&](const char* folder) { return file.In(folder); });
  };
  EXPECT_EQ(ViolationsOf(core, UnnamedSubjects), "");
}

TEST(House, EveryHeaderMayBeIncludedTwice) {
  EXPECT_THAT(ViolationsOf(IsHeader, MissingPragmaOnce), IsEmpty());
}

TEST(House, EveryScriptIsExecutable) {
  EXPECT_THAT(ViolationsOf(IsAny, NotExecutable), IsEmpty());
}

TEST(House, EverySourceAndEveryTestIsBuilt) {
  EXPECT_THAT(DeadFiles(Tree()), IsEmpty());
}

TEST(House, CodeInDocumentsIsCodeThatIsCompiledAndRun) {
  EXPECT_THAT(ViolationsOf(IsGuide, [](const auto& f) { return StaleSnippets(f, Tree()); }),
              IsEmpty());
}

TEST(House, LinksInDocumentsLeadSomewhere) {
  EXPECT_THAT(ViolationsOf(IsDocument, [](const auto& f) { return DeadLinks(f, Tree()); }),
              IsEmpty());
}

TEST(House, TestsThatDocumentsCiteExist) {
  const std::set<std::string> tests = TestsOf(Tree());
  EXPECT_THAT(ViolationsOf(IsGuide, [&](const auto& f) { return MissingTests(f, tests); }),
              IsEmpty());
}

TEST(House, TheReferenceExplainsEveryConfigKey) {
  for (const char* file : {"every_key.toml", "recovery.toml", "protocols.toml", "hosts.toml"}) {
    EXPECT_THAT(Unexplained(File("docs/reference.md"),
                            File("test/golden/configs/good/" + std::string(file))),
                IsEmpty());
  }
}

TEST(House, TheReferenceListsEveryCodeAndEveryEnvironmentVariable) {
  EXPECT_THAT(WrongCodes(File("docs/reference.md"), File("base/code.hpp"),
                         File("cyberdog/codes/module_codes.hpp")),
              IsEmpty());
  EXPECT_THAT(WrongVariables(File("docs/reference.md"), Tree()), IsEmpty());
}

TEST(House, TheReferenceListsEveryTopicAndServiceOfTheMachine) {
  EXPECT_THAT(WrongTopicsAndServices(File("docs/reference.md"), Tree()), IsEmpty());
}

TEST(House, ThePageOfCyberDogListsWhatIsImplementedAndWhatIsLeftOut) {
  EXPECT_THAT(WrongInterfaces(File("docs/cyberdog.md"), Tree()), IsEmpty());
}

TEST(House, EveryInterfaceOfTheManagerHasPermissions) {
  EXPECT_THAT(UnlistedInterfaces(File("cyberdog/interfaces.hpp"), File("cyberdog/interfaces.cpp")),
              IsEmpty());
}

TEST(House, EveryModuleOfCyberDogHasItsName) {
  EXPECT_THAT(WronglyNamedModules(File("cyberdog/codes/module_codes.hpp"),
                                  File("cyberdog/codes/module_codes.cpp")),
              IsEmpty());
}

TEST(House, TheReferenceExplainsEveryFieldOfTheWire) {
  for (const SourceFile& file : Tree()) {
    if (!file.In("messages/musher_msgs/") || !file.Is(".idl")) continue;
    EXPECT_THAT(Unexplained(File("docs/reference.md"), file), IsEmpty()) << file.path;
  }
}

TEST(House, EveryFieldOfAMessageHasAComment) {
  EXPECT_EQ(ViolationsOf(IsMessage, UncommentedFields), "");
}

TEST(House, TroubleshootingExplainsEveryRecordFindingAndCode) {
  const SourceFile page = File("docs/troubleshooting.md");
  EXPECT_THAT(UnexplainedRecords(page, Tree()), IsEmpty());
  EXPECT_THAT(UnexplainedFindings(page, Tree()), IsEmpty());
  EXPECT_THAT(UnexplainedCodes(page, Tree()), IsEmpty());
  EXPECT_THAT(SentencesOfNoProgram(page, Tree()), IsEmpty());
}

TEST(House, EveryRefusalHasOneSentenceATestAndARow) {
  EXPECT_THAT(UnexplainedRefusals(File("docs/troubleshooting.md"), Tree()), IsEmpty());
  EXPECT_THAT(UntestedRefusals(Tree()), IsEmpty());
  EXPECT_THAT(RefusalsElsewhere(Tree()), IsEmpty());
}

TEST(House, TheReferenceOfPythonHasEveryPublicName) {
  EXPECT_THAT(PythonNamesOutsideTheReference(File("docs/api/python.md"), Tree()), IsEmpty());
}

TEST(House, EveryHeaderOfTheReferenceStatesItsThreads) {
  EXPECT_THAT(HeadersWithoutThreads(Tree()), IsEmpty());
}

TEST(House, EveryPageIsInTheContentsOfTheSite) {
  EXPECT_THAT(PagesOutsideTheContents(Tree()), IsEmpty());
}

TEST(House, EveryDrawingFitsAPrintedPage) {
  EXPECT_THAT(DrawingsThatFitNoPage(Tree()), IsEmpty());
}

TEST(House, TheChinesePagesHaveTheCodeAndTheHeadingsOfTheEnglishOnes) {
  EXPECT_THAT(DifferingBlocks(File("README.md"), "", File("README.zh.md")), IsEmpty());
  EXPECT_THAT(DifferingHeadings(File("README.md"), File("README.zh.md")), IsEmpty());
  EXPECT_THAT(DifferingBlocks(File("docs/guide.md"), "Your first module in ten minutes",
                              File("docs/zh/first-module.md")),
              IsEmpty());
}

}  // namespace musher::house::house_test
