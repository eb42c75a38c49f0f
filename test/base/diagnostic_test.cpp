#include "musher/base/diagnostic.hpp"

#include <gtest/gtest.h>

namespace musher::diagnostic_test {

TEST(Diagnostic, IsPrintedAsEditorsAndCompilersDo) {
  EXPECT_EQ(FormatDiagnostic({"a/b.toml", 3, 14, Severity::kError, "bad"}),
            "a/b.toml:3:14: error: bad");
  EXPECT_EQ(FormatDiagnostic({"b.toml", 1, 1, Severity::kWarning, "odd"}),
            "b.toml:1:1: warning: odd");
  EXPECT_EQ(FormatDiagnostic({"b.toml", 1, 1, Severity::kNote, "so"}), "b.toml:1:1: note: so");
}

TEST(Diagnostic, HasNoPlaceWhenItIsAboutTheWholeFile) {
  EXPECT_EQ(FormatDiagnostic({"b.toml", 0, 0, Severity::kError, "gone"}), "b.toml: error: gone");
}

TEST(HasError, LooksForErrorsOnly) {
  const Diagnostic note{"f", 1, 1, Severity::kNote, ""};
  const Diagnostic warning{"f", 1, 1, Severity::kWarning, ""};
  const Diagnostic error{"f", 1, 1, Severity::kError, ""};
  EXPECT_FALSE(HasError({}));
  EXPECT_FALSE(HasError({note, warning}));
  EXPECT_TRUE(HasError({note, error, warning}));
}

}  // namespace musher::diagnostic_test
