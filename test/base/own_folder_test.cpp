#include "musher/base/own_folder.hpp"

#include <gmock/gmock.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

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

class SharedFolder : public OwnFolder {
 protected:
  // A group that this process may give files to: root another than its own.
  SharedFolder() {
    const group* entry = getgrgid(geteuid() == 0 ? kOtherGroup : getegid());  // NOLINT: one thread
    if (entry != nullptr) group_ = entry->gr_name;
  }
  struct stat Look(const std::string& path) const {
    struct stat info {};
    EXPECT_EQ(lstat(path.c_str(), &info), 0) << path;
    return info;
  }
  void Make(const std::string& name, mode_t mode) const {
    std::ofstream(folder_ + "/" + name) << name;
    ASSERT_EQ(chmod((folder_ + "/" + name).c_str(), mode), 0);
  }

  static constexpr gid_t kOtherGroup = 65534;
  std::string group_;
};

TEST_F(SharedFolder, CanBeReadByTheGroupAndNotBeChanged) {
  if (group_.empty()) GTEST_SKIP() << "the group of this process has no name";
  Make("journal", 0644);
  Make("lock", 0600);
  ASSERT_EQ(chmod(folder_.c_str(), 0700), 0);
  for (int i = 0; i < 2; ++i) {  // again at the next start
    const auto shared = ShareFolder(folder_, group_);
    ASSERT_TRUE(shared) << shared.error().message;
  }
  const gid_t id = GroupNamed(group_).value();
  EXPECT_EQ(Look(folder_).st_gid, id);
  EXPECT_EQ(Look(folder_).st_mode & 07777U, 02750U);
  EXPECT_EQ(Look(folder_ + "/journal").st_gid, id);
  EXPECT_EQ(Look(folder_ + "/journal").st_mode & 0777U, 0644U);
  EXPECT_EQ(Look(folder_ + "/lock").st_mode & 0777U, 0600U) << "which its owner alone may read";
  Make("later", 0640);
  EXPECT_EQ(Look(folder_ + "/later").st_gid, id);
  EXPECT_TRUE(CheckOwnFolder(folder_));
}

TEST_F(SharedFolder, IsNotSharedWithAGroupThatDoesNotExist) {
  const auto shared = ShareFolder(folder_, "no_such_group");
  EXPECT_EQ(shared.error().message, "this host has no group 'no_such_group'");
  EXPECT_FALSE(GroupNamed("no_such_group"));
}

TEST_F(SharedFolder, IsNotSharedWhereTheUmaskKeepsNewFilesFromTheGroup) {
  if (group_.empty()) GTEST_SKIP() << "the group of this process has no name";
  const mode_t before = umask(077);
  const auto shared = ShareFolder(folder_, group_);
  EXPECT_EQ(umask(before), 077U) << "is as it was";
  EXPECT_THAT(shared.error().message, HasSubstr("use umask 027"));
}

}  // namespace musher::own_folder_test
