#include "musher/modules/meilin/field/box_map.hpp"

namespace musher::meilin {

Box BoxMap::At(Cell cell) const {
  return boxes.at(static_cast<std::size_t>(cell.row)).at(static_cast<std::size_t>(cell.col));
}

}  // namespace musher::meilin
