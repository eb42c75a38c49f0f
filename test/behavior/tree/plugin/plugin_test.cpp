// Nodes from shared libraries.

#include "musher/behavior/tree/plugin/plugin.hpp"
#include "musher/base/version.hpp"
#include "musher/behavior/tree/plugin/load_plugin.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::plugin_test {

using testing::HasSubstr;

std::string Library(const std::string& name) {
  return std::string(MUSHER_TEST_PLUGINS) + "/lib" + name + ".so";
}

struct APlugin : testing::Test {
  std::string ErrorOf(const std::string& path) {
    const Result<> loaded = LoadPlugin(factory, path);
    return loaded ? "" : loaded.error().message;
  }
  Factory factory;
};

TEST_F(APlugin, HasNodesWhosePortsShareEntriesWithThoseOfTheProgram) {
  ASSERT_EQ(ErrorOf(Library("arm_nodes")), "");
  const auto tree = MakeTree(Main("<Sequence><Script code=\"force := 0.5 + 1\"/>"
                                  "<Grip force_n=\"{force}\" held=\"{held}\"/>"
                                  "<ScriptCondition code=\"held == true\"/></Sequence>"),
                             factory);
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<bool>("held").value(), true);
  EXPECT_THAT(Findings(Main("<Grip force_n=\"much\"/>"), factory),
              HasSubstr("t.xml:3:16: error: port 'force_n': 'much' is not valid"));
}
TEST_F(APlugin, WhoseNodeThrowsEndsTheTickWithItsPath) {
  ASSERT_EQ(ErrorOf(Library("arm_nodes")), "");
  const auto tree = MakeTree(Main("<Grip force_n=\"-1\"/>"), factory);
  EXPECT_EQ(tree->TickOnce(At(0)).error().message, "t.xml:3:1: Main/Grip: a force below 0");
}
TEST_F(APlugin, IsRefusedWhereItIsOfAnotherVersionOrItsHeadersWere) {
  EXPECT_THAT(MUSHER_TREE_PLUGIN_BUILD, HasSubstr(" " + std::string(Version()) + ","))
      << "a plugin of another version has another text";
  EXPECT_THAT(ErrorOf(Library("other_sizes_plugin")),
              HasSubstr("it was built with another version of Musher, or other options"));
}
TEST_F(APlugin, IsRefusedWhereItThrowsSomethingElseThanAnException) {
  EXPECT_THAT(ErrorOf(Library("throwing_plugin")), HasSubstr("it threw something that is not"));
  EXPECT_EQ(ErrorOf(Library("arm_nodes")), "");
}
TEST_F(APlugin, IsRefusedWhereItsNodesAreThereAlreadyOrItIsNone) {
  ASSERT_EQ(ErrorOf(Library("arm_nodes")), "");
  EXPECT_THAT(ErrorOf(Library("arm_nodes")), HasSubstr("there is already a node 'Grip'"));
  EXPECT_THAT(ErrorOf(Library("no_plugin")),
              HasSubstr("it has no nodes for Musher: none of its sources has MUSHER_TREE_PLUGIN"));
  EXPECT_THAT(ErrorOf(Library("old_plugin")), HasSubstr("it is 'musher tree plugin 0'"));
  EXPECT_THAT(ErrorOf("/nowhere/libarm.so"), HasSubstr("plugin /nowhere/libarm.so: "));
  EXPECT_THAT(ErrorOf("libc.so.6"), HasSubstr("cannot open shared object file"))
      << "only the file that was named";
}

}  // namespace musher::tree::plugin_test
