#include "musher/base/result.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace musher::result_test {

TEST(Result, HoldsAValue) {
  const Result<int> result = 3;
  EXPECT_TRUE(result.ok());
  EXPECT_TRUE(static_cast<bool>(result));
  EXPECT_EQ(result.value(), 3);
}

TEST(Result, HoldsAnErrorInPlaceOfAValue) {
  const Result<int> result = Error{kCodeTimeout, "late"};
  EXPECT_FALSE(result.ok());
  EXPECT_EQ(result.error(), (Error{kCodeTimeout, "late"}));
}

TEST(Result, GivesItsValueAway) {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(7);
  const std::unique_ptr<int> value = std::move(result).value();
  EXPECT_EQ(*value, 7);
}

TEST(Result, LetsItsValueBeChanged) {
  Result<std::string> result = std::string("a");
  result.value() += "b";
  EXPECT_EQ(result.value(), "ab");
}

TEST(ResultOfNothing, IsOkUnlessGivenAnError) {
  const Result<> ok = Ok();
  const Result<> failed = Error{kCodeFailed, "no"};
  EXPECT_TRUE(ok.ok());
  EXPECT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "no");
}

}  // namespace musher::result_test
