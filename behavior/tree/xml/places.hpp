#pragma once
// Where the elements and attributes of an XML text stand, which the parser does not report.

#include <cstdint>
#include <string_view>
#include <vector>

namespace musher::tree {

struct AttributePlace {
  std::uint32_t name_at = 0;
  std::uint32_t value_at = 0;  // behind the quotation mark
};

struct ElementPlace {
  std::uint32_t at = 0;               // of the '<'
  std::uint32_t first_attribute = 0;  // its attributes end where those of the next element begin
};

// In the order of the text.
struct Places {
  std::vector<ElementPlace> elements;
  std::vector<AttributePlace> attributes;
};

// The places in an XML text. In a text that is not XML, those before its first error are right.
Places FindPlaces(std::string_view text);

}  // namespace musher::tree
