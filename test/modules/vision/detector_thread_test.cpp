// A real thread and a real loop, with a detector controlled by the test.

#include <gmock/gmock.h>

#include <future>
#include <stdexcept>

#include "musher/modules/vision/faces/detector.hpp"
#include "musher/modules/vision/picture/detector_thread.hpp"
#include "musher/test/modules/vision/faces.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::vision::detector_thread_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ScriptedDetector : public Detector {
 public:
  using Script = std::function<std::vector<FaceBox>(const msg::Image&)>;
  explicit ScriptedDetector(const Script& script) : script_(script) {}
  std::vector<FaceBox> Detect(const msg::Image& picture) override { return script_(picture); }

 private:
  const Script& script_;
};

class DetectorThreadTest : public ::testing::Test {
 protected:
  void Start() {
    thread_.emplace(
        loop_,
        [this]() -> Result<std::unique_ptr<Detector>> {
          ++made_;
          if (on_make_) on_make_();
          if (broken_) return Error{5912, "there is no such model"};
          return std::unique_ptr<Detector>(new ScriptedDetector(script_));
        },
        DetectorLimits{Milliseconds(700), 3},
        DetectorThreadEvents<Detector>{
            [this](DetectionResult<Detector> result) { results_.push_back(std::move(result)); },
            [this] { ++left_out_; },
            [this](Duration allowance) {
              const std::lock_guard lock(mutex_);
              checkpoints_.push_back(allowance);
            },
            [this](const Error& error) { lost_.set_value(error.message); }});
  }
  bool AwaitResults(std::size_t count) {
    return loop_.RunUntil([&] { return results_.size() >= count; },
                          loop_.Now() + std::chrono::seconds(120));
  }
  std::vector<std::int64_t> Stamps() const {
    std::vector<std::int64_t> stamps;
    for (const DetectionResult<Detector>& result : results_) stamps.push_back(result.stamp_ns);
    return stamps;
  }

  transport::LinuxEventLoop loop_;
  ScriptedDetector::Script script_ = [](const msg::Image&) {
    return std::vector{FaceAt(0.5, 0.5)};
  };
  std::atomic<int> made_ = 0;
  std::function<void()> on_make_;
  std::atomic<bool> broken_ = false;
  std::vector<DetectionResult<Detector>> results_;
  int left_out_ = 0;
  std::mutex mutex_;
  std::vector<Duration> checkpoints_;
  std::promise<std::string> lost_;
  std::optional<DetectorThread<Detector>> thread_;  // last: it uses the rest
};

TEST_F(DetectorThreadTest, GivesWhatTheDetectorFinds) {
  Start();
  thread_->Submit({7, Picture()});
  ASSERT_TRUE(AwaitResults(1));
  EXPECT_EQ(results_[0].stamp_ns, 7);
  EXPECT_EQ(results_[0].width_px, 64U);
  EXPECT_THAT(results_[0].found.value(), ElementsAre(FaceAt(0.5, 0.5)));
  EXPECT_EQ(thread_->Busy(), Duration::zero());
}

TEST_F(DetectorThreadTest, TakesTheNewestPictureAndCountsTheOthers) {
  std::promise<void> begun;
  std::promise<void> release;
  bool first = true;
  script_ = [&](const msg::Image&) {
    if (std::exchange(first, false)) {
      begun.set_value();
      release.get_future().wait();
    }
    return std::vector<FaceBox>();
  };
  Start();
  thread_->Submit({1, Picture()});
  begun.get_future().wait();
  EXPECT_GT(thread_->Busy(), Duration::zero());
  for (const std::int64_t stamp_ns : {2, 3, 4}) thread_->Submit({stamp_ns, Picture()});
  EXPECT_EQ(left_out_, 2);
  release.set_value();
  ASSERT_TRUE(AwaitResults(2));
  EXPECT_THAT(Stamps(), ElementsAre(1, 4));
}

TEST_F(DetectorThreadTest, ReplacesADetectorThatThrew) {
  int call = 0;
  script_ = [&](const msg::Image&) -> std::vector<FaceBox> {
    if (++call == 1) throw std::runtime_error("out of luck\nand more");
    if (call == 2) throw 5;
    return {};
  };
  Start();
  for (const std::size_t count : {1, 2, 3}) {
    thread_->Submit({std::int64_t(count), Picture()});
    ASSERT_TRUE(AwaitResults(count));
  }
  EXPECT_EQ(results_[0].found.error().message, "the detector failed: out of luck");
  EXPECT_EQ(results_[0].found.error().code, 5912);
  EXPECT_EQ(results_[1].found.error().message, "the detector failed");
  EXPECT_TRUE(results_[2].found);
  EXPECT_EQ(made_, 3);
}

TEST_F(DetectorThreadTest, GivesUpADetectorThatFailsRepeatedly) {
  script_ = [](const msg::Image&) -> std::vector<FaceBox> { throw std::runtime_error("dead"); };
  Start();
  auto lost = lost_.get_future();
  for (const std::size_t count : {1, 2, 3}) {
    thread_->Submit({std::int64_t(count), Picture()});
    ASSERT_TRUE(AwaitResults(count));
  }
  EXPECT_EQ(lost.get(), "3 pictures in a row: the detector failed: dead");
  thread_->Submit({4, Picture()});  // without a detector nothing hangs
}

TEST_F(DetectorThreadTest, LoadsTheModelAheadOrReportsWhyNot) {
  broken_ = true;
  Start();
  EXPECT_EQ(thread_->Load().error().message, "there is no such model");
  thread_->Submit({1, Picture()});
  ASSERT_TRUE(AwaitResults(1));
  EXPECT_EQ(results_[0].found.error().message, "there is no such model");
  broken_ = false;
  EXPECT_TRUE(thread_->Load());
  EXPECT_TRUE(thread_->Load());
  EXPECT_EQ(made_, 3) << "once it is there it is kept";
}

// A caller that waits to load, while another loads for long, does not wait for the picture either.
TEST_F(DetectorThreadTest, LoadsWithoutWaitingForAPictureThatBeginsMeanwhile) {
  std::promise<void> making;
  std::promise<void> release;
  on_make_ = [&] {
    making.set_value();
    release.get_future().wait();
  };
  Start();
  auto first = std::async(std::launch::async, [&] { return thread_->Load().ok(); });
  making.get_future().wait();
  std::promise<void> begun;
  auto second = std::async(std::launch::async, [&] {
    begun.set_value();
    return thread_->Load().ok();
  });
  begun.get_future().wait();
  thread_->Submit({1, Picture()});
  EXPECT_EQ(second.wait_for(std::chrono::seconds(120)), std::future_status::ready);
  release.set_value();
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(second.get());
  EXPECT_TRUE(AwaitResults(1));
}

TEST_F(DetectorThreadTest, SetsACheckpointBeforeEachPicture) {
  Start();
  thread_->Submit({1, Picture()});
  ASSERT_TRUE(AwaitResults(1));
  EXPECT_THAT(checkpoints_, ElementsAre(Duration(Milliseconds(700)), Duration::max()));
}

TEST_F(DetectorThreadTest, IsDestroyedWhileAPictureIsProcessed) {
  Start();
  thread_->Submit({1, Picture()});
  thread_.reset();
  loop_.RunUntil([] { return false; }, loop_.Now() + Milliseconds(20));
  EXPECT_THAT(results_, ::testing::IsEmpty());
}

}  // namespace musher::vision::detector_thread_test
