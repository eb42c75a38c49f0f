// Runs the tests; MUSHER_MUTANTS_REACHED=file makes it write which mutants each test comes by, a
// line each: the test, its milliseconds, their numbers.

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "musher/test/mutation/mutants.hpp"

namespace {

class Tracer : public ::testing::EmptyTestEventListener {
 public:
  explicit Tracer(const std::string& path) : out_(path) {}

  void OnTestStart(const ::testing::TestInfo&) override { musher::mutation::reached.reset(); }
  void OnTestEnd(const ::testing::TestInfo& test) override {
    out_ << test.test_suite_name() << '.' << test.name() << ' ' << test.result()->elapsed_time();
    for (std::size_t i = 0; i < musher::mutation::kMost; ++i) {
      if (musher::mutation::reached[i]) out_ << ' ' << i;
    }
    out_ << std::endl;
  }

 private:
  std::ofstream out_;
};

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (const char* path = std::getenv("MUSHER_MUTANTS_REACHED")) {
    ::testing::UnitTest::GetInstance()->listeners().Append(new Tracer(path));
  }
  return RUN_ALL_TESTS();
}
