#include "musher/base/own_folder.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "musher/test/support/temp_folder.hpp"

namespace musher::own_folder_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr uid_t kAnother = 12345;

class OwnFolder : public ::testing::Test {
 protected:
  OwnFolder() { fs::create_directory(folder_); }
  std::string Refusal() const {
    const auto checked = CheckOwnFolder(folder_);
    return checked ? "" : checked.error().message;
  }

  TempFolder parent_;
  const std::string folder_ = parent_ / "state";
};

TEST_F(OwnFolder, IsOneThatOnlyThisUserCanWriteTo) {
  ASSERT_EQ(chmod(folder_.c_str(), 0755), 0);
  EXPECT_EQ(Refusal(), "");
  EXPECT_TRUE(CheckOwnFolder("/")) << "root's";
  EXPECT_TRUE(CheckOwnFolder(folder_ + "/none"));
}

TEST_F(OwnFolder, IsNoneThatAllUsersCanWriteTo) {
  for (const mode_t mode : {0777U, 01777U, 0707U}) {
    ASSERT_EQ(chmod(folder_.c_str(), mode), 0);
    EXPECT_THAT(Refusal(),
                AllOf(HasSubstr(folder_ + " is writable for all users"), HasSubstr("chmod go-w ")));
  }
}

TEST_F(OwnFolder, IsNoneOfAnotherUserAndNoLinkOfAnotherUser) {
  if (geteuid() != 0) GTEST_SKIP() << "only root gives a folder away";
  ASSERT_EQ(chown(folder_.c_str(), kAnother, kAnother), 0);
  EXPECT_THAT(Refusal(), HasSubstr(folder_ + " belongs to user 12345, who could "));
  ASSERT_EQ(chown(folder_.c_str(), 0, kAnother), 0);
  ASSERT_EQ(chmod(folder_.c_str(), 0775), 0);
  EXPECT_THAT(Refusal(), HasSubstr("is writable for group 12345"));
  const std::string link = parent_ / "link";
  fs::create_symlink("/root", link);
  ASSERT_EQ(lchown(link.c_str(), kAnother, kAnother), 0);
  EXPECT_FALSE(CheckOwnFolder(link));
}

}  // namespace musher::own_folder_test
