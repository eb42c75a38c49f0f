#include "musher/view/record/schema.hpp"

#include "musher/messages/definitions.hpp"

namespace musher::view {

std::string SchemaText(std::string_view dds_type) {
  const msg::MessageDefinition* definition = msg::FindDefinition(dds_type);
  return definition == nullptr ? "" : std::string(definition->text);
}

}  // namespace musher::view
