#include "musher/base/words.hpp"

#include <gtest/gtest.h>

namespace musher::words_test {

TEST(Words, CountOneThingInTheSingular) {
  EXPECT_EQ(Counted(0, "number"), "0 numbers");
  EXPECT_EQ(Counted(1, "number"), "1 number");
  EXPECT_EQ(Counted(7, "number"), "7 numbers");
  EXPECT_EQ(Counted(1, "child", "children"), "1 child");
  EXPECT_EQ(Counted(2, "child", "children"), "2 children");
}

TEST(Words, NameTheDefaultNamespace) {
  EXPECT_EQ("in " + NamespaceText(""), "in the default namespace");
  EXPECT_EQ("in " + NamespaceText("fleet/dog1"), "in namespace 'fleet/dog1'");
}

TEST(Words, QuoteAWordOfACommandWhereAShellNeedsIt) {
  EXPECT_EQ(ShellWord("/robots/dog-1.toml"), "/robots/dog-1.toml");
  EXPECT_EQ(ShellWord("my robot"), "'my robot'");
  EXPECT_EQ(ShellWord("dog's"), R"('dog'\''s')");
  EXPECT_EQ(ShellWord("$HOME;~"), "'$HOME;~'");
  EXPECT_EQ(ShellWord("größe"), "'größe'");
  EXPECT_EQ(ShellWord(""), "''");
}

}  // namespace musher::words_test
