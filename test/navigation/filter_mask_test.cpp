// Masks as those of nav2's costmap filters: values of places, and cells that no path touches.

#include "musher/navigation/masks/filter_mask.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "musher/navigation/planner/planner.hpp"

namespace musher::navigation::filter_mask_test {

// 4 x 2 cells of 1 m from (1, 0) on.
FilterMask Mask() {
  return {{1, {{1, 0, 0}, 0}, 4, 2, {0, 50, 100, -1, 0, 0, 0, 0}}, 100, -1};
}

TEST(FilterMask, HasTheValuesOfItsCells) {
  const FilterMask mask = Mask();
  EXPECT_EQ(mask.At({1.5, 0.5, 0}), 100);
  EXPECT_EQ(mask.At({2.5, 0.5, 3}), 50) << "at any height";
  EXPECT_EQ(mask.At({3.5, 0.5, 0}), 0);
  EXPECT_EQ(mask.At({4.5, 0.5, 0}), std::nullopt) << "unknown";
  EXPECT_EQ(mask.At({0.5, 0.5, 0}), std::nullopt) << "beside it";
  EXPECT_EQ(mask.At({std::numeric_limits<double>::quiet_NaN(), 0, 0}), std::nullopt);
}

TEST(FilterMask, IsRefusedIfItIsNone) {
  EXPECT_TRUE(CheckFilterMask(Mask()));
  FilterMask mask = Mask();
  mask.grid.data.pop_back();
  EXPECT_FALSE(CheckFilterMask(mask));
  EXPECT_FALSE(CheckFilterMask({{1, {}, 0, 0, {}}, 0, 1}));
  mask = Mask();
  mask.multiplier = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(CheckFilterMask(mask));
}

TEST(KeepOut, IsPlannedAroundWhateverTheResolutions) {
  for (const double mask_m : {0.05, 0.1, 0.5}) {
    CellMap map;
    map.resolution_m = 0.1;
    map.size_x = map.size_y = 60;
    map.blocked.assign(60 * 60, 0);
    // Across the room, with a gap at its end.
    const auto cells = static_cast<std::uint32_t>(std::lround(4.5 / mask_m));
    const auto thick = static_cast<std::uint32_t>(std::lround(0.5 / mask_m));
    const FilterMask mask{
        {mask_m, {{3, 0, 0}, 0}, thick, cells, std::vector<std::int8_t>(thick * cells, 100)}, 0, 1};
    const CellMap keep_out = KeepOutCells(mask, 65);
    BlockKeepOut(keep_out, map);
    const auto planner = Planner::Make(map, {});
    ASSERT_TRUE(planner);
    const auto plan = planner.value().Find({{1, 1, 0}, 0}, {{5, 1, 0}, 0});
    ASSERT_TRUE(plan) << plan.error().message;
    for (const Pose& pose : plan.value().path) {
      const bool inside = pose.at.x_m > 3 && pose.at.x_m < 3.5 && pose.at.y_m < 4.5;
      EXPECT_FALSE(inside) << mask_m << ": " << pose.at.x_m << ", " << pose.at.y_m;
    }
    EXPECT_GT(plan.value().length_m, 7) << "straight it is 4 m";
  }
}

}  // namespace musher::navigation::filter_mask_test
