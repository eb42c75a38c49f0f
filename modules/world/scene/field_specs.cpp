#include "musher/modules/world/scene/field_specs.hpp"

#include <cmath>

namespace musher::world {

const char* NameOf(KfsKind kind) {
  return kind == KfsKind::kKfs1 ? "KFS1" : kind == KfsKind::kKfs2 ? "KFS2" : "fake";
}

Eigen::Vector2d FieldSpec::CentreOf(const FieldCell& cell) const {
  return origin_m + cell_m * Eigen::Vector2d(cell.row, cell.col);
}

FieldCell FieldSpec::CellOf(const Eigen::Vector2d& point_m) const {
  const Eigen::Vector2d from_corner = (point_m - origin_m) / cell_m + Eigen::Vector2d(0.5, 0.5);
  return {static_cast<int>(std::floor(from_corner.x())),
          static_cast<int>(std::floor(from_corner.y()))};
}

bool FieldSpec::Has(const FieldCell& cell) const {
  return cell.row >= 0 && cell.row < rows && cell.col >= 0 && cell.col < cols;
}

double FieldSpec::HeightMm(const FieldCell& cell) const {
  if (!Has(cell)) return 0;
  return heights_mm.at(static_cast<std::size_t>(cell.row * cols + cell.col));
}

}  // namespace musher::world
