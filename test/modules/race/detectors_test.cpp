// The subscriptions to detectors on a simulated network, in virtual time.

#include "musher/modules/race/detectors.hpp"

#include "musher/test/modules/module_on_network.hpp"
#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::detectors_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class DetectorsTest : public test::ModuleOnNetwork {
 protected:
  using Sightings = std::unique_ptr<transport::Publisher<msg::Sighting>>;

  DetectorsTest() {
    std::vector<bool> wanted(TheCourse().detectors.size());
    wanted[qr_] = true;
    detectors_.Watch(wanted);
  }

  Sightings MakeDetector() {
    Sightings sightings = Publisher<msg::Sighting>("dog1/qr_detector/sighting");
    Run(Milliseconds(500));  // discovery
    return sightings;
  }
  void Publish(const Sightings& sightings) {
    EXPECT_TRUE(sightings->Publish({}));
    Run(Milliseconds(100));
  }

  const Index qr_ = FindByName(TheCourse().detectors, "qr").value();
  int received_ = 0;
  std::string doubt_;
  std::vector<Index> doubled_;
  Detectors detectors_{*robot_,
                       "dog1",
                       TheCourse(),
                       {.on_sighting = [this](Index, const msg::Sighting&) { ++received_; },
                        .on_lines = [](Index, const msg::YellowLines&) {},
                        .on_text = [](Index, const std::string&) {},
                        .on_doubt = [this](Index, const std::string& why) { doubt_ = why; },
                        .on_two_publishers = [this](Index found) { doubled_.push_back(found); },
                        .log = [](const std::string& line) { ADD_FAILURE() << line; }}};
};

TEST_F(DetectorsTest, TakeADetectorThatIsRestartedForAnotherOne) {
  for (int restart = 0; restart < 3; ++restart) {
    const Sightings sightings = MakeDetector();
    Publish(sightings);
    Publish(sightings);
  }
  EXPECT_EQ(received_, 6);
  EXPECT_THAT(doubled_, IsEmpty());
}

TEST_F(DetectorsTest, SayWhyAPictureHasNoSighting) {
  const auto doubts = Publisher<msg::String>("dog1/qr_detector/doubt");
  Run(Milliseconds(500));  // discovery
  EXPECT_TRUE(doubts->Publish({"the floor has the colour of the light"}));
  Run(Milliseconds(100));
  EXPECT_EQ(doubt_, "the floor has the colour of the light");
  EXPECT_EQ(received_, 0);
}

TEST_F(DetectorsTest, ReportTwoPublishersThatTakeTurns) {
  const Sightings one = MakeDetector(), other = MakeDetector();
  Publish(one);
  Publish(other);
  EXPECT_THAT(doubled_, IsEmpty());
  Publish(one);
  EXPECT_THAT(doubled_, ElementsAre(qr_));
}

// Only a change back to the publisher before the last one was reported.
TEST_F(DetectorsTest, ReportThreePublishersThatTakeTurns) {
  const Sightings one = MakeDetector(), two = MakeDetector(), three = MakeDetector();
  Publish(one);
  Publish(two);
  Publish(three);
  EXPECT_THAT(doubled_, IsEmpty());
  Publish(one);
  EXPECT_THAT(doubled_, ElementsAre(qr_));
}

}  // namespace musher::race::detectors_test
