// The folder of pictures and videos, on a real disk.

#include "musher/modules/camera/store.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <optional>

#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::camera::store_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

msg::Image Picture() {
  msg::Image picture;
  picture.width = 64;
  picture.height = 48;
  picture.encoding = "bgr8";
  picture.step = 64 * 3;
  picture.data.assign(std::size_t{picture.step} * 48, 100);
  return picture;
}

class StoreTest : public ::testing::Test {
 protected:
  template <class T>
  Result<T> Await(const std::function<void(Store::Done<T>)>& start) {
    std::optional<Result<T>> answer;
    start([&answer](const Result<T>& result) { answer = result; });
    EXPECT_FALSE(answer) << "never inside the call";
    EXPECT_TRUE(loop_.RunUntil([&] { return answer.has_value(); },
                               loop_.Now() + std::chrono::seconds(120)));
    return *answer;
  }
  Result<std::string> Save(const NewFile& file) {
    return Await<std::string>([&](auto done) { store_->Save(Picture(), file, done); });
  }
  std::vector<std::string> List() {
    return Await<std::vector<std::string>>([&](auto done) { store_->List(done); }).value();
  }
  Result<> Delete(const std::string& file) {
    return Await<void>([&](auto done) { store_->Delete(file, done); });
  }

  const TempFolder folder_;
  const std::string saved_ = folder_ / "deep/saved";
  transport::LinuxEventLoop loop_;
  std::unique_ptr<Store> store_ = MakeStore(loop_, saved_);
};

TEST_F(StoreTest, SavesListsAndDeletesPictures) {
  EXPECT_THAT(List(), IsEmpty()) << "there is no folder yet";
  const auto path = Save({"a.png"});
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_EQ(path.value(), saved_ + "/a.png");
  EXPECT_TRUE(Save({"b.jpg"}));
  EXPECT_THAT(List(), ElementsAre("a.png", "b.jpg"));
  EXPECT_EQ(Save({"a.png"}).error().code, 4410) << "nothing is written over";
  EXPECT_TRUE(Delete("a.png"));
  EXPECT_EQ(Delete("a.png").error().code, 4410);
  EXPECT_THAT(List(), ElementsAre("b.jpg"));
}

// A world's time starts at zero with each run, and so do names by the time.
TEST_F(StoreTest, NumbersAGeneratedNameThatExistsAlready) {
  const NewFile again = {"picture_16.560.jpg", true};
  EXPECT_EQ(Save(again).value(), saved_ + "/picture_16.560.jpg");
  EXPECT_EQ(Save(again).value(), saved_ + "/picture_16.560_2.jpg");
  store_ = MakeStore(loop_, saved_);
  EXPECT_EQ(Save(again).value(), saved_ + "/picture_16.560_3.jpg") << "by another process, too";
  const auto video = [&] {
    return Await<std::string>([&](auto done) {
      store_->BeginVideo(Picture(), {"video_3.000.avi", true}, 10, done);
    });
  };
  EXPECT_EQ(video().value(), saved_ + "/video_3.000.avi");
  EXPECT_TRUE(Await<std::string>([&](auto done) { store_->EndVideo(done); }));
  EXPECT_EQ(video().value(), saved_ + "/video_3.000_2.avi");
  EXPECT_THAT(List(), SizeIs(5));
}

TEST_F(StoreTest, DeletesNeitherALinkNorAFolderNorWhatALinkLeadsTo) {
  std::filesystem::create_directories(saved_ + "/folder.jpg");
  std::ofstream(folder_ / "precious") << "keep me";
  std::filesystem::create_symlink(folder_ / "precious", saved_ + "/link.jpg");
  EXPECT_FALSE(Delete("link.jpg"));
  EXPECT_FALSE(Delete("folder.jpg"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "precious"));
  EXPECT_THAT(List(), IsEmpty());
  EXPECT_EQ(Save({"link.jpg"}).error().code, 4410) << "nor is it written through";
}

TEST_F(StoreTest, RecordsAVideoThatCanBePlayed) {
  const auto begun =
      Await<std::string>([&](auto done) { store_->BeginVideo(Picture(), {"walk.avi"}, 10, done); });
  ASSERT_TRUE(begun) << begun.error().message;
  for (int i = 0; i < 9; ++i) store_->AddFrame(Picture());
  EXPECT_EQ(Delete("walk.avi").error().code, 4411) << "while it is being recorded";
  const auto ended = Await<std::string>([&](auto done) { store_->EndVideo(done); });
  ASSERT_TRUE(ended) << ended.error().message;
  cv::VideoCapture capture(ended.value(), cv::CAP_FFMPEG);
  cv::Mat frame;
  int frames = 0;
  while (capture.read(frame)) ++frames;
  EXPECT_EQ(frames, 10);
  EXPECT_EQ(capture.get(cv::CAP_PROP_FPS), 10);
}

TEST_F(StoreTest, ReportsWhyAFolderCannotBeWrittenTo) {
  std::ofstream(folder_ / "deep") << "a file where the folder should be";
  const auto path = Save({"a.png"});
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().code, 4401);
  EXPECT_THAT(path.error().message, HasSubstr("deep/saved"));
}

TEST_F(StoreTest, EndsAVideoInItsDestructor) {
  ASSERT_TRUE(Await<std::string>(
      [&](auto done) { store_->BeginVideo(Picture(), {"walk.avi"}, 10, done); }));
  store_.reset();
  cv::VideoCapture capture(saved_ + "/walk.avi", cv::CAP_FFMPEG);
  EXPECT_TRUE(capture.grab());
}

}  // namespace musher::camera::store_test
