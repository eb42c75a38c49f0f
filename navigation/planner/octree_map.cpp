#include "musher/navigation/planner/octree_map.hpp"

#include <fmt/format.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

octomap::point3d Place(const Point& point) {
  return {static_cast<float>(point.x_m), static_cast<float>(point.y_m),
          static_cast<float>(point.z_m)};
}

// Cells of a cube, which a leaf of any size is, set to one value.
void Fill(const octomap::OcTree::leaf_bbx_iterator& leaf, std::uint8_t value, CellMap& map) {
  const double size_m = leaf.getSize();
  const auto first = [&](double centre_m, double origin_m) {
    return static_cast<int>(std::lround((centre_m - size_m / 2 - origin_m) / map.resolution_m));
  };
  const int count = static_cast<int>(std::lround(size_m / map.resolution_m));
  const Cell from = {first(leaf.getX(), map.origin.at.x_m), first(leaf.getY(), map.origin.at.y_m),
                     first(leaf.getZ(), map.origin.at.z_m)};
  const auto end = [&](int begin, int size) { return std::min(begin + count, size); };
  for (int z = std::max(from.z, 0); z < end(from.z, map.size_z); ++z) {
    for (int y = std::max(from.y, 0); y < end(from.y, map.size_y); ++y) {
      for (int x = std::max(from.x, 0); x < end(from.x, map.size_x); ++x) {
        map.blocked[map.IndexOf({x, y, z})] = value;
      }
    }
  }
}

}  // namespace

struct OctreeMap::Tree {
  std::unique_ptr<octomap::OcTree> tree;
};

OctreeMap::OctreeMap(std::unique_ptr<Tree> tree) : tree_(std::move(tree)) {}
OctreeMap::OctreeMap(OctreeMap&&) noexcept = default;
OctreeMap& OctreeMap::operator=(OctreeMap&&) noexcept = default;
OctreeMap::~OctreeMap() = default;

Result<OctreeMap> OctreeMap::Make(double resolution_m) {
  if (!(resolution_m >= 0.001 && resolution_m <= 100)) {
    return MakeError(Fault::kMap,
                     fmt::format("octree: resolution {} m, expected 0.001 to 100 m", resolution_m));
  }
  return OctreeMap(std::make_unique<Tree>(Tree{std::make_unique<octomap::OcTree>(resolution_m)}));
}

Result<OctreeMap> OctreeMap::Read(const std::string& content) {
  std::istringstream stream(content);
  const bool binary = content.starts_with("# Octomap OcTree binary file");
  std::unique_ptr<octomap::OcTree> tree;
  if (binary) {
    tree = std::make_unique<octomap::OcTree>(0.1);
    if (!tree->readBinary(stream)) tree = nullptr;
  } else if (content.starts_with("# Octomap OcTree file")) {
    std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(stream));
    if (dynamic_cast<octomap::OcTree*>(any.get())) {
      tree.reset(static_cast<octomap::OcTree*>(any.release()));
    }
  } else {
    return MakeError(Fault::kMap,
                     "octree: its first line is not that of a file of OctoMap (.bt or .ot)");
  }
  if (!tree || !(tree->getResolution() > 0)) {
    return MakeError(Fault::kMap, "octree: the file is damaged, or its tree is not an OcTree");
  }
  return OctreeMap(std::make_unique<Tree>(Tree{std::move(tree)}));
}

std::size_t OctreeMap::Block(const std::vector<Point>& points) {
  octomap::OcTree& tree = *tree_->tree;
  std::size_t used = 0;
  for (const Point& point : points) {
    octomap::OcTreeKey key;
    if (!IsFinite(point) || !tree.coordToKeyChecked(Place(point), key)) continue;
    tree.setNodeValue(key, tree.getClampingThresMaxLog(), true);
    ++used;
  }
  tree.updateInnerOccupancy();
  tree.prune();
  return used;
}

std::size_t OctreeMap::See(const Point& from, const std::vector<Point>& points, double range_m) {
  octomap::OcTree& tree = *tree_->tree;
  octomap::OcTreeKey key;
  if (!IsFinite(from) || !tree.coordToKeyChecked(Place(from), key)) return 0;
  octomap::Pointcloud cloud;
  for (const Point& point : points) {
    if (IsFinite(point) && tree.coordToKeyChecked(Place(point), key)) cloud.push_back(Place(point));
  }
  tree.insertPointCloud(cloud, Place(from), range_m, true, true);
  tree.updateInnerOccupancy();
  return cloud.size();
}

std::string OctreeMap::Binary() const {
  std::ostringstream stream;
  tree_->tree->writeBinaryConst(stream);
  return stream.str();
}

double OctreeMap::resolution_m() const {
  return tree_->tree->getResolution();
}

Result<CellMap> OctreeMap::Cells(const CellRules& rules) const {
  const octomap::OcTree& tree = *tree_->tree;
  if (tree.size() == 0) return MakeError(Fault::kMap, "octree: it is empty");
  Point low, high;
  tree.getMetricMin(low.x_m, low.y_m, low.z_m);
  tree.getMetricMax(high.x_m, high.y_m, high.z_m);
  CellMap map;
  map.resolution_m = tree.getResolution();
  const double margin = std::max(0.0, std::floor(rules.margin_m / map.resolution_m));
  const double margin_m = margin * map.resolution_m;
  map.origin.at = {low.x_m - margin_m, low.y_m - margin_m, low.z_m - margin_m};
  const auto cells = [&](double from_m, double to_m) {
    const double count = std::round((to_m - from_m) / map.resolution_m) + 2 * margin;
    return static_cast<int>(std::min(count, 1e9));
  };
  map.size_x = cells(low.x_m, high.x_m);
  map.size_y = cells(low.y_m, high.y_m);
  map.size_z = std::max(2, cells(low.z_m, high.z_m));  // one layer would be a map of the ground
  const double count = double{1} * map.size_x * map.size_y * map.size_z;
  if (!(count <= static_cast<double>(kMostCells))) {
    return MakeError(Fault::kMap,
                     fmt::format("octree: {} x {} x {} leaves of {} m, at most {} in "
                                 "all; use a coarser one",
                                 map.size_x, map.size_y, map.size_z, map.resolution_m, kMostCells));
  }
  map.blocked.assign(static_cast<std::size_t>(count), rules.unknown_is_free ? 0 : 1);
  for (auto leaf = tree.begin_leafs_bbx(Place(low), Place(high)); leaf != tree.end_leafs_bbx();
       ++leaf) {
    Fill(leaf, tree.isNodeOccupied(*leaf) ? 1 : 0, map);
  }
  return map;
}

}  // namespace musher::navigation
