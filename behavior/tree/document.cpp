#include "musher/behavior/tree/document.hpp"

#include <algorithm>

namespace musher::tree {

const Attribute* Element::Find(std::string_view attribute) const {
  const auto found = std::ranges::find(attributes, attribute, &Attribute::name);
  return found == attributes.end() ? nullptr : &*found;
}

const Document::Tree* Document::Find(std::string_view id) const {
  const auto found = std::ranges::find(trees, id, &Tree::id);
  return found == trees.end() ? nullptr : &*found;
}

Diagnostic Document::At(Place place, Severity severity, std::string message) const {
  const File& file = files.at(place.file);
  const std::string_view before = std::string_view(file.text).substr(0, place.at);
  const auto line = std::ranges::count(before, '\n') + 1;
  const std::size_t begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return {file.path, static_cast<int>(line), static_cast<int>(before.size() - begin + 1), severity,
          std::move(message)};
}

Place Document::Inside(const Attribute& attribute, std::size_t offset) const {
  const std::string_view text = files.at(attribute.value_at.file).text;
  std::size_t at = attribute.value_at.at;
  for (; offset > 0 && at < text.size(); --offset) {
    const std::size_t end = text[at] == '&' ? text.find(';', at) : at;
    at = end == std::string_view::npos ? at + 1 : end + 1;
  }
  return {attribute.value_at.file, static_cast<std::uint32_t>(at)};
}

}  // namespace musher::tree
