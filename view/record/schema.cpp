#include "musher/view/record/schema.hpp"

#if __has_include("musher/messages/definitions.hpp")
#include "musher/messages/definitions.hpp"
#endif

namespace musher::view {

#if __has_include("musher/messages/definitions.hpp")
std::string SchemaText(std::string_view dds_type) {
  const msg::MessageDefinition* definition = msg::FindDefinition(dds_type);
  return definition == nullptr ? "" : std::string(definition->text);
}
#else
std::string SchemaText(std::string_view /*dds_type*/) {
  return "";
}
#endif

}  // namespace musher::view
