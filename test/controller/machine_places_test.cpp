// Where a stop without an express name has to reach a machine of this host.

#include "musher/controller/storage/machine_places.hpp"

#include <gmock/gmock.h>

namespace musher::machine_places_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const MachinePlace kOwn{7, ""};
const MachinePlace kDogA{7, "dogA"};
const MachinePlace kOtherDomain{8, ""};

std::vector<MachinePlace> ToStop(const MeantPlace& meant, const std::vector<MachinePlace>& running,
                                 bool has_files = true) {
  return PlacesToStop(meant, running, [has_files](const MachinePlace&) { return has_files; });
}

TEST(AStop, ReachesTheMachinesOfItsDomainInOtherNamespaces) {
  EXPECT_THAT(ToStop({kOwn}, {kDogA}), ElementsAre(kDogA));
  EXPECT_THAT(ToStop({kOwn}, {kOwn, kDogA}), ElementsAre(kDogA)) << "also beside one of its own";
  EXPECT_THAT(ToStop({kOwn}, {kOwn}), IsEmpty());
}

TEST(AStop, ReachesARobotOfAnotherDomainWhereNothingRunsInItsOwn) {
  EXPECT_THAT(ToStop({kOwn}, {kOtherDomain}), ElementsAre(kOtherDomain));
  EXPECT_THAT(ToStop({kOwn}, {kOtherDomain}, /*has_files=*/false), IsEmpty())
      << "a simulation of a colleague";
  EXPECT_THAT(ToStop({kOwn}, {kOwn, kOtherDomain}), IsEmpty());
  EXPECT_THAT(ToStop({kOwn}, {kDogA, kOtherDomain}), ElementsAre(kDogA));
}

TEST(AStop, ReachesNoMachineBesideTheOneThatIsNamedExpressly) {
  EXPECT_THAT(ToStop({kOwn, true, false}, {kDogA}), IsEmpty());
  EXPECT_THAT(ToStop({kOwn, true, false}, {kOtherDomain}), ElementsAre(kOtherDomain));
  EXPECT_THAT(ToStop({kOwn, false, true}, {kOtherDomain}), IsEmpty());
  EXPECT_THAT(ToStop({kOwn, false, true}, {kDogA}), ElementsAre(kDogA));
}

}  // namespace musher::machine_places_test
