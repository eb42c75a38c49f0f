// Ports with pointers to classes that derive from each other.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_pointers_test {

struct Tool {
  virtual ~Tool() = default;
  virtual std::string Name() const { return "tool"; }
};
struct Gripper : Tool {
  std::string Name() const override { return "gripper"; }
};
struct SoftGripper : Gripper {
  std::string Name() const override { return "soft gripper"; }
};
struct Camera : Tool {
  std::string Name() const override { return "camera"; }
};

}  // namespace musher::tree::conformance_pointers_test

using musher::tree::conformance_pointers_test::Camera;
using musher::tree::conformance_pointers_test::Gripper;
using musher::tree::conformance_pointers_test::SoftGripper;
using musher::tree::conformance_pointers_test::Tool;

template <>
struct musher::tree::Convert<std::shared_ptr<Tool>> {
  static constexpr std::string_view kName = "Tool";
};
template <>
struct musher::tree::Convert<std::shared_ptr<Gripper>> : musher::tree::PointerWithBase<Tool> {
  static constexpr std::string_view kName = "Gripper";
};
template <>
struct musher::tree::Convert<std::shared_ptr<SoftGripper>>
    : musher::tree::PointerWithBase<Gripper> {
  static constexpr std::string_view kName = "SoftGripper";
};
template <>
struct musher::tree::Convert<std::shared_ptr<Camera>> : musher::tree::PointerWithBase<Tool> {
  static constexpr std::string_view kName = "Camera";
};

namespace musher::tree::conformance_pointers_test {

using testing::HasSubstr;

template <class T>
class Make : public Action {
 public:
  explicit Make(Setup& setup) : to_(setup.Output<std::shared_ptr<T>>("to")) {}

 private:
  Status Do(const Tick&) override {
    to_.Set(std::make_shared<T>());
    return Status::kSuccess;
  }
  OutPort<std::shared_ptr<T>> to_;
};

// Writes the name of what it reads.
template <class T>
class Use : public Action {
 public:
  explicit Use(Setup& setup)
      : of_(setup.Input<std::shared_ptr<T>>("of")), name_(setup.Output<std::string>("name_of")) {}

 private:
  Status Do(const Tick&) override {
    name_.Set(of_.Get() == nullptr ? "none" : of_.Get()->Name());
    return Status::kSuccess;
  }
  InPort<std::shared_ptr<T>> of_;
  OutPort<std::string> name_;
};

struct Pointers : testing::Test {
  Pointers() {
    EXPECT_TRUE(factory.Add<Make<Tool>>("MakeTool"));
    EXPECT_TRUE(factory.Add<Make<Gripper>>("MakeGripper"));
    EXPECT_TRUE(factory.Add<Make<SoftGripper>>("MakeSoft"));
    EXPECT_TRUE(factory.Add<Make<Camera>>("MakeCamera"));
    EXPECT_TRUE(factory.Add<Use<Tool>>("UseTool"));
    EXPECT_TRUE(factory.Add<Use<Gripper>>("UseGripper"));
  }
  static std::string InSequence(const std::string& content) {
    return Main("<Sequence>\n" + content + "\n</Sequence>");
  }
  std::string Found(const std::string& content) { return Findings(InSequence(content), factory); }
  std::string NameAfter(const std::string& content) {
    const auto tree = MakeTree(InSequence(content), factory);
    EXPECT_EQ(Ticks(*tree, 1), "S");
    return tree->board().Get<std::string>("name").value();
  }
  Factory factory;
};

TEST_F(Pointers, ToADerivedClassAreReadByPortsOfItsBases) {
  const std::string use = "<UseTool of=\"{x}\" name_of=\"{name}\"/>";
  EXPECT_EQ(NameAfter("<MakeGripper to=\"{x}\"/>" + use), "gripper");
  EXPECT_EQ(NameAfter("<MakeSoft to=\"{x}\"/>" + use), "soft gripper") << "over two classes";
  EXPECT_EQ(NameAfter("<MakeSoft to=\"{x}\"/><UseGripper of=\"{x}\" name_of=\"{other}\"/>" + use),
            "soft gripper");
}
TEST_F(Pointers, MayBeReadBeforeTheyAreWrittenInTheFile) {
  const auto tree = MakeTree(
      Main("<Fallback><Sequence><ScriptCondition code=\"made == true\"/>"
           "<UseTool of=\"{x}\" name_of=\"{name}\"/><UseGripper of=\"{x}\" name_of=\"{b}\"/>"
           "</Sequence><MakeSoft to=\"{x}\"/></Fallback>"),
      factory);
  ASSERT_TRUE(tree->board().Set("made", false));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  ASSERT_TRUE(tree->board().Set("made", true));
  EXPECT_EQ(Ticks(*tree, 1, 1), "S");
  EXPECT_EQ(tree->board().Get<std::string>("b").value(), "soft gripper");
}
TEST_F(Pointers, OfTwoClassesWithOneBaseShareAnEntryOfThatBase) {
  EXPECT_EQ(NameAfter("<MakeGripper to=\"{x}\"/><MakeCamera to=\"{x}\"/>"
                      "<UseTool of=\"{x}\" name_of=\"{name}\"/>"),
            "camera");
  EXPECT_EQ(Found("<MakeGripper to=\"{x}\"/>\n<MakeCamera to=\"{x}\"/>\n"
                  "<UseGripper of=\"{x}\" name_of=\"{name}\"/>"),
            "t.xml:6:17: error: 'x' is of type Tool, the base of all that is written to it; a port "
            "of type Gripper can not read it\n");
}
TEST_F(Pointers, ToABaseAreNotReadByPortsOfADerivedClass) {
  EXPECT_EQ(Found("<MakeTool to=\"{x}\"/>\n<UseGripper of=\"{x}\" name_of=\"{name}\"/>"),
            "t.xml:5:17: error: 'x' is of type Tool, the base of all that is written to it; a port "
            "of type Gripper can not read it\n");
}
TEST_F(Pointers, OfOtherClassesAreAnErrorAsBefore) {
  EXPECT_THAT(Found("<MakeTool to=\"{x}\"/><Sleep msec=\"{x}\"/>"),
              HasSubstr("port 'msec' (integer from 0) uses 'x', which is of type Tool at"));
}
TEST_F(Pointers, ThatAProgramSetsAreConvertedInTheTick) {
  const auto tree = MakeTree(Main("<Sequence><UseTool of=\"{x}\" name_of=\"{name}\"/>"
                                  "<UseGripper of=\"{x}\" name_of=\"{name}\"/></Sequence>"),
                             factory);
  ASSERT_TRUE(tree->board().Set("x", std::make_shared<SoftGripper>()));
  EXPECT_EQ(Ticks(*tree, 1), "S");
  EXPECT_EQ(tree->board().Get<std::shared_ptr<Tool>>("x").value()->Name(), "soft gripper");
  ASSERT_TRUE(tree->board().Set("x", std::make_shared<Camera>()));
  EXPECT_THAT(tree->TickOnce(At(20)).error().message,
              HasSubstr("port 'of': the value of 'x' is Camera, which is not of the port's type"));
  ASSERT_TRUE(tree->board().Set("x", std::shared_ptr<Gripper>()));
  EXPECT_EQ(Ticks(*tree, 1, 3), "S");
  EXPECT_EQ(tree->board().Get<std::string>("name").value(), "none");
}
TEST_F(Pointers, KeepTheTypeThatAnotherTreeGaveTheSharedBoard) {
  const auto board = std::make_shared<Board>();
  const auto build = [&](const std::string& content) {
    return Build(ReadTree(Main(content), "t.xml").document, factory, {.board = board});
  };
  const Built one = build("<MakeGripper to=\"{x}\"/>");
  ASSERT_NE(one.tree, nullptr);
  EXPECT_NE(build("<MakeSoft to=\"{x}\"/>").tree, nullptr);
  EXPECT_NE(build("<UseTool of=\"{x}\" name_of=\"{name}\"/>").tree, nullptr);
  EXPECT_EQ(Texts(build("<MakeCamera to=\"{x}\"/>").diagnostics),
            "t.xml:3:17: error: 'x' is of type Gripper in another tree that shares the board; a "
            "port of type Camera can not write it\n");
}

}  // namespace musher::tree::conformance_pointers_test
