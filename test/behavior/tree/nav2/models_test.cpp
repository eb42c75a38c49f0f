// The models of nav2's nodes: for editors, for a check without a robot, and as a page.

#include <fstream>
#include <map>

#include "musher/behavior/tree/models.hpp"
#include "musher/test/behavior/tree/nav2/fake_robot.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::tree::nav2::models_test {

using testing::HasSubstr;

Factory ForCheck() {
  Factory factory;
  AddForCheck(factory);
  return factory;
}

TEST(Nav2Models, HaveADefaultForWhatIsReadFromAnEntry) {
  EXPECT_THAT(
      ModelsXml(ForCheck()),
      HasSubstr("<Condition ID=\"GoalUpdated\">\n"
                "      <input_port name=\"goal\" default=\"{goal}\">the goal</input_port>"));
}
TEST(Nav2Models, DescribeEachNodeThatRuns) {
  const Factory factory = ForCheck();
  for (const std::string& name : factory.Names()) {
    const Factory::Registered& node = *factory.Find(name);
    EXPECT_TRUE(node.placeholder || DescriptionOf(name) != "" || node.description != "") << name;
  }
}
TEST(Nav2Models, CheckATreeWithNodesThatNoRobotHas) {
  const std::string tree =
      "<PipelineSequence><RateController hz=\"1\"><Sequence>"
      "<ComputePathToPose goal=\"{goal}\" path=\"{path}\"/>"
      "<DockRobot dock_pose=\"{dock}\" success=\"{docked}\"/></Sequence></RateController>"
      "<FollowPath path=\"{path}\" tracking_feedback=\"{f}\"/></PipelineSequence>";
  EXPECT_EQ(Findings(Main(tree), ForCheck()), "");
  EXPECT_THAT(Findings(Main("<DockRobot dock_poses=\"{dock}\"/>"), ForCheck()),
              HasSubstr("<DockRobot> has no port 'dock_poses'; did you mean 'dock_pose'?"));
  EXPECT_THAT(Findings(Main("<RateController hz=\"often\"><Wait/></RateController>"), ForCheck()),
              HasSubstr("port 'hz': 'often' is not valid: expected number"));
  EXPECT_THAT(Findings(Main("<GoalReached goal=\"1;2\"/>"), ForCheck()),
              HasSubstr("'1;2' is not valid: expected pose, as 'x;y;yaw'"));
}
TEST(Nav2Models, FindAPathWhereAPoseIsExpected) {
  EXPECT_THAT(Findings(Main("<Sequence><ComputePathToPose goal=\"{goal}\" path=\"{path}\"/>"
                            "<FollowPath path=\"{goal}\"/></Sequence>"),
                       ForCheck()),
              HasSubstr("uses 'goal', which is of type pose"));
}
// So that a reader of the page knows which nodes end the tick of a tree.
TEST(Nav2Models, ThatNoRobotHasAreAllNamedOnThePage) {
  std::ifstream file(SourceDir() + "/docs/behavior-trees.md");
  std::map<std::string, std::string> has_model;
  for (std::string line; std::getline(file, line);) {
    for (const std::string kind : {"controls", "decorators", "conditions", "actions"}) {
      if (line.rfind("| " + kind + " |", 0) != 0) continue;
      has_model[kind] = line.substr(line.rfind('|', line.size() - 2));
    }
  }
  ASSERT_EQ(has_model.size(), 4u);
  FakeRobot robot;
  Factory factory;
  AddNodes(factory, robot);
  std::string all;
  for (const auto& [kind, names] : has_model) all += names;
  for (const std::string& name : factory.Names()) {
    const bool is_named = all.find("`" + name + "`") != std::string::npos;
    EXPECT_EQ(is_named, factory.Find(name)->placeholder) << name;
  }
}
TEST(Nav2Models, FailInATickWhereNoRobotHasTheNode) {
  FakeRobot robot;
  Factory factory;
  AddNodes(factory, robot);
  const auto tree = MakeTree(Main("<DockRobot/>"), factory);
  EXPECT_THAT(tree->TickOnce(At(0)).error().message, HasSubstr("placeholder of a model"));
}
TEST(Nav2Models, DoNotReplaceANodeOfTheProgram) {
  Factory factory;
  ASSERT_TRUE(factory.AddAction("Wait", [](const Tick&) { return Status::kFailure; }));
  AddForCheck(factory);
  EXPECT_EQ(Letter(MakeTree(Main("<Wait/>"), factory)->TickOnce(At(0))), 'F');
}

TEST(Nav2Reference, IsThatOfTheNodes) {
  const std::string path = SourceDir() + "/docs/nav2-nodes.md";
  const std::string begin = "<!-- generated -->\n\n";
  std::ifstream file(path);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::size_t at = text.find(begin);
  ASSERT_NE(at, std::string::npos);
  Factory factory = Factory::Empty();
  AddForCheck(factory);
  const std::string expected = text.substr(0, at) + begin + ModelsMarkdown(factory);
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {  // NOLINT(concurrency-mt-unsafe)
    std::ofstream(path) << expected;
    text = expected;
  }
  EXPECT_EQ(text, expected) << "docs/nav2-nodes.md is old: run this test with "
                               "MUSHER_UPDATE_GOLDEN=1";
}

}  // namespace musher::tree::nav2::models_test
