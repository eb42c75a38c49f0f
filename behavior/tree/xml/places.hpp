#pragma once
// Where the elements and attributes of an XML text stand, which the parser does not report.

#include <cstdint>
#include <string_view>
#include <vector>

namespace musher::tree {

struct ElementPlace {
  struct Attribute {
    std::uint32_t name_at = 0;
    std::uint32_t value_at = 0;  // behind the quotation mark
  };
  std::uint32_t at = 0;  // of the '<'
  std::vector<Attribute> attributes;
};

// In the order of the elements in the text, for a text that is XML; for others as far as it is.
std::vector<ElementPlace> FindPlaces(std::string_view text);

}  // namespace musher::tree
