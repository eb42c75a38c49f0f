#pragma once
// A mask of nav2's costmap filters on the network: what it means comes on one topic
// (nav2_msgs/CostmapFilterInfo), the mask itself on the topic that this names.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <string>

#include "musher/messages/nav2_msgs/costmap_filter_info.hpp"
#include "musher/messages/nav_msgs/occupancy_grid.hpp"
#include "musher/navigation/masks/filter_mask.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::navigation {

class MaskSource {
 public:
  struct Handlers {
    std::function<void(std::uint8_t type, FilterMask mask)> on_mask;
    std::function<void(const std::string& why)> on_refusal;  // the mask before stays
  };

  // `frame`: of the map. `endpoints` must outlive it.
  MaskSource(transport::Endpoints& endpoints, const std::string& info_topic, std::string name_space,
             std::string frame, Handlers handlers);

 private:
  void OnInfo(const msg::CostmapFilterInfo& info);
  void OnGrid(const msg::OccupancyGrid& grid);

  transport::Node& node_;
  const std::string name_space_;
  const std::string frame_;
  const Handlers handlers_;
  msg::CostmapFilterInfo info_;
  std::shared_ptr<const msg::OccupancyGrid> grid_;
  std::unique_ptr<transport::Subscription> mask_;
};

}  // namespace musher::navigation
