// TryCatch and Finally. "a^" is a's first tick, "a" a further one, "a!" its halt.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::cleanup_test {

struct Cleanup : TickedTree {
  std::string Halt() {
    const Result<> halted = tree->Halt(At(500));
    return Take() + (halted ? "" : halted.error().message);
  }
};

std::string TryCatch(const std::string& children, const std::string& port = "") {
  return "<TryCatch " + port + ">" + children + "</TryCatch>";
}
std::string Finally(const std::string& children) {
  return "<Finally>" + children + "</Finally>";
}

TEST_F(Cleanup, TryCatchSucceedsWithoutItsLastChild) {
  EXPECT_EQ(Run(TryCatch(Leaf("a", "RS") + Leaf("b", "S") + Leaf("c", "S")), 3), "RSR a^ a b^ a^ ");
}
TEST_F(Cleanup, TryCatchFailsAfterItsLastChild) {
  EXPECT_EQ(Run(TryCatch(Leaf("a", "F") + Leaf("b", "S") + Leaf("c", "RS")), 3),
            "RFR a^ c^ c a^ c^ ");
}
TEST_F(Cleanup, TryCatchIsSkippedWhereAllItTriesIs) {
  const std::string skipped = Leaf("a", "S", "_skipIf=\"true\"");
  EXPECT_EQ(Run(TryCatch(skipped + Leaf("c", "S")), 1), "- ");
  EXPECT_EQ(Run(TryCatch(skipped + Leaf("b", "S") + Leaf("c", "S")), 1), "S b^ ");
}
TEST_F(Cleanup, TryCatchTicksItsLastChildInAHaltOnRequest) {
  const std::string children = Leaf("a", "R") + Leaf("c", "R");
  Run(TryCatch(children), 1);
  EXPECT_EQ(Halt(), "a! ");
  Run(TryCatch(children, "catch_on_halt=\"true\""), 1);
  EXPECT_EQ(Halt(), "a! c^ c! ");
  Run(TryCatch(Leaf("a", "F") + Leaf("c", "R"), "catch_on_halt=\"true\""), 1);
  EXPECT_EQ(Halt(), "c! ") << "it is ticked already";
}
TEST_F(Cleanup, FinallyHasTheResultOfItsFirstChild) {
  EXPECT_EQ(Run(Finally(Leaf("a", "RF") + Leaf("c", "RS")), 3), "RRF a^ a c^ c ");
  EXPECT_EQ(Run(Finally(Leaf("a", "S") + Leaf("c", "S")), 1), "S a^ c^ ");
  EXPECT_EQ(Run(Finally(Leaf("a", "S") + Leaf("c", "F")), 1), "F a^ c^ ");
  EXPECT_EQ(Run(Finally(Leaf("a", "-") + Leaf("c", "S")), 1), "- a^ c^ ");
}
TEST_F(Cleanup, FinallyTicksItsSecondChildOnceInAHalt) {
  Run(Finally(Leaf("a", "R") + Leaf("c", "R")), 1);
  EXPECT_EQ(Halt(), "a! c^ c! ");
  EXPECT_EQ(Halt(), "");
  Run(Finally(Leaf("a", "S") + Leaf("c", "RRR")), 1);
  EXPECT_EQ(Halt(), "c c! ") << "it runs already";
}
TEST_F(Cleanup, FinallyCleansUpAfterAnException) {
  EXPECT_EQ(Run(Finally(Leaf("a", "!") + Leaf("c", "S")), 1), "! a^ c^ ");
  EXPECT_EQ(Run(Finally(Leaf("a", "S") + Leaf("c", "!S")), 1), "! a^ c^ ");
  EXPECT_EQ(Letter(tree->TickExactlyOnce(At(10))), 'S') << "it begins again";
  Run(Finally(Leaf("a", "R") + Leaf("c", "!")), 1);
  EXPECT_THAT(Halt(), testing::HasSubstr("a! c^ "));
  EXPECT_EQ(tree->status(), Status::kIdle);
}

}  // namespace musher::tree::cleanup_test
