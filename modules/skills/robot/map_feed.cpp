#include "musher/modules/skills/robot/map_feed.hpp"

#include <utility>

#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/navigation/planner/cell_map.hpp"

namespace musher::skills {

MapFeed::MapFeed(transport::Node& node, transport::Clock& clock, std::string topic,
                 PlaceInMap place_in_map)
    : node_(node),
      clock_(clock),
      topic_(std::move(topic)),
      place_in_map_(std::move(place_in_map)) {}

GroundMap MapFeed::Ask() {
  if (topic_.empty()) return {};
  asked_ = clock_.Now();
  if (!subscription_) {
    subscribed_ = asked_;
    auto made = transport::MakeSubscription<msg::OccupancyGrid>(
        node_, topic_, [this](const msg::OccupancyGrid& grid, const auto&) { OnGrid(grid); },
        transport::kLatchedQos);
    if (!made) return {false, nullptr, true, nullptr};
    subscription_ = std::move(made).value();
  }
  return {asked_ - subscribed_ < kAwaited, cells_, true, known_};
}

void MapFeed::Update() {
  if (!subscription_ || clock_.Now() - asked_ < kKept) return;
  subscription_.reset();
  cells_.reset();
  known_.reset();
}

void MapFeed::OnGrid(const msg::OccupancyGrid& grid) {
  const auto frame = place_in_map_(grid.header.frame_id);
  const auto origin = ToPose(grid.info.origin);
  const std::uint64_t count = std::uint64_t{grid.info.width} * grid.info.height;
  if (!frame || !origin || grid.data.size() != count) return;
  const navigation::OccupancyGrid occupancy{grid.info.resolution,
                                            navigation::PlacedAt(frame.value(), *origin),
                                            grid.info.width, grid.info.height, grid.data};
  auto map = navigation::FromOccupancyGrid(occupancy, {.unknown_is_free = true});
  auto known = navigation::FromOccupancyGrid(occupancy, {.unknown_is_free = false});
  if (!map || !known) return;
  cells_ = std::make_shared<const navigation::CellMap>(std::move(map).value());
  known_ = std::make_shared<const navigation::CellMap>(std::move(known).value());
}

}  // namespace musher::skills
